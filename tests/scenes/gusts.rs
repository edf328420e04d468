//! Light cloth that gusts fold and whip: contacts do not stretch it, and what gets through itself for a moment does not tangle.

use std::sync::Arc;

use bevy_drape::solver::rest::RestShape;
use bevy_drape::solver::settings::Fabric;
use bevy_drape::solver::wind::{Turbulence, Wind};
use drape_scenes::{Scene, SceneCloth, flags, grid};
use glam::vec3;

use crate::{FRAME, untangled};

/// 2 m of light cloth of `n` x `n` vertices, level and pinned along one side, in a wind of `speed` [m/s] along that side that
/// rises and falls by half.
fn along_pins(n: u32, speed: f32, seed: u64) -> Scene {
    let mesh = grid(n, n, |u, v| vec3(2.0 * u - 1.0, 0.0, 2.0 * v - 1.0));
    let (rest, _) = RestShape::build(&mesh).expect("a sheet");
    let pins: Vec<u32> = (0..n).collect();
    let fabric = Fabric { density: 0.15, ..Fabric::default() };
    let mut scene = Scene::new(vec![SceneCloth::new(Arc::new(rest), fabric, vec3(0.0, 2.0, 0.0), &pins)]);
    let turbulence = Turbulence { intensity: 0.5, length: 4.0, frequency: 0.5, seed };
    scene.wind = Wind { velocity: vec3(speed, 0.0, 0.0), turbulence, ..Wind::STILL };
    untangled(scene, true)
}

/// The worst edge of all `frames`, and how many of them end crossing.
fn worst(scene: &mut Scene, frames: u32) -> (f32, u32) {
    let (mut worst, mut crossing) = (0.0f32, 0);
    for _ in 0..frames {
        scene.step(FRAME);
        worst = worst.max(scene.cloths[0].report.worst_edge);
        crossing += u32::from(scene.crossings() > 0);
    }
    (worst, crossing)
}

#[test]
fn contacts_do_not_stretch_light_cloth_in_gusts() {
    for seed in 1..=4 {
        let (worst, crossing) = worst(&mut along_pins(30, 4.0, seed), 240);
        assert!(worst < 1.3 && crossing == 0, "gusts {seed}: edge {worst}, {crossing} frames cross");
    }
}

#[test]
fn contacts_do_not_stretch_a_flag_in_gusts() {
    for seed in 1..=3 {
        let mut scene = untangled(flags(1, 64), true);
        scene.wind.turbulence.seed = seed;
        let (worst, crossing) = worst(&mut scene, 180);
        assert!(worst < 1.5 && crossing == 0, "gusts {seed}: edge {worst}, {crossing} frames cross");
    }
}
