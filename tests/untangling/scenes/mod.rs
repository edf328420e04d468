//! Whole scenes come apart, a frame at a time. The quick tier leaves them out.

mod garments;
mod layers;
mod rollback;
mod tangles;

use drape_scenes::{Scene, SceneCloth};
use glam::Vec3;

const FRAME: f32 = 1.0 / 60.0;

fn floating(cloths: Vec<SceneCloth>) -> Scene {
    Scene { gravity: Vec3::ZERO, ..Scene::new(cloths) }
}

fn positions(scene: &Scene) -> Vec<Vec3> {
    scene.cloths.iter().flat_map(|c| c.sim.state.positions.iter().map(|p| p.truncate())).collect()
}

/// Longest edge over rest length (dimensionless).
fn worst_edge(scene: &Scene) -> f32 {
    scene.cloths.iter().map(|c| c.report.worst_edge).fold(0.0, f32::max)
}

/// Speed of the fastest particle [m/s].
fn fastest(scene: &Scene) -> f32 {
    let speed = |c: &SceneCloth| (0..c.sim.state.positions.len()).map(|i| c.sim.state.velocity(i).length()).fold(0.0, f32::max);
    scene.cloths.iter().map(speed).fold(0.0, f32::max)
}

/// Frames until nothing crosses.
fn clean_after(scene: &mut Scene, most: u32) -> Option<u32> {
    (1..=most).find(|_| {
        scene.step(FRAME);
        scene.crossings() == 0
    })
}
