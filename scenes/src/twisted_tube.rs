//! A tube whose ends are turned against each other: twisted cylinder of Codimensional IPC (Li et al. 2021).

use core::f32::consts::TAU;
use std::sync::Arc;

use glam::{Quat, Vec3, vec3};

use super::{Scene, SceneCloth, fabric, grid};
use bevy_drape::solver::rest::RestShape;
use bevy_drape::solver::settings::Fabric;

/// Length and radius `[m]`.
const TUBE: (f32, f32) = (1.0, 0.25);
/// How fast either end is turned `[1/s]` and comes in `[m/s]`: 72 degrees and 5 mm a second; for how long `[s]`.
const TURNS: f32 = 0.2;
const APPROACH: f32 = 0.005;
const LASTS: f32 = 6.0;

/// The tube along x, held at both ends: `n` x `n` vertices.
#[must_use]
pub fn twisted_tube(n: u32) -> Scene {
    let (length, radius) = TUBE;
    let mesh = grid(n.max(4), n.max(4), |u, v| {
        let (sin, cos) = (TAU * v.fract()).sin_cos();
        vec3(length * (u - 0.5), radius * cos, radius * sin)
    });
    let held: Vec<u32> = mesh.positions.iter().zip(0..).filter(|(p, _)| p.x.abs() > 0.4999 * length).map(|(_, i)| i).collect();
    let (rest, _) = RestShape::build(&mesh).unwrap_or_default();
    // Its threads have to get longer.
    let elastic = Fabric {
        stretch_stiffness: 0.1 * fabric().stretch_stiffness,
        strain_limit: f32::INFINITY,
        tether_scale: f32::INFINITY,
        ..fabric()
    };
    let mut scene = Scene::new(vec![SceneCloth::new(Arc::new(rest), elastic, Vec3::ZERO, &held)]);
    scene.gravity = Vec3::ZERO;
    scene.drive = Some(|scene, time| {
        let time = time.min(LASTS);
        for SceneCloth { rest, anchors, .. } in &mut scene.cloths {
            for (&p, to) in anchors.particles.iter().zip(&mut anchors.to) {
                let start = rest.positions[p as usize];
                let side = start.x.signum();
                *to = Quat::from_rotation_x(side * TAU * TURNS * time) * start - vec3(side * APPROACH * time, 0.0, 0.0);
            }
        }
    });
    scene
}
