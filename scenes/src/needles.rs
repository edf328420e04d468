//! A sheet falls on twenty needles, thinner than its meshes are wide.

use glam::{Vec3, vec3};

use super::{Scene, SceneCloth, fabric, sheet};
use bevy_drape::solver::body::{Body, Pose, shape};

/// Radius of a needle at its foot and height `[m]`.
pub const NEEDLE: (f32, f32) = (0.012, 0.3);
/// Needles along x and along z, and how far they are from each other `[m]`.
const ROWS: (u32, u32, f32) = (5, 4, 0.19);

/// Where the needles stand `[m]`.
pub fn feet() -> impl Iterator<Item = Vec3> {
    let (columns, rows, step) = ROWS;
    let middle = vec3((columns - 1) as f32, 0.0, (rows - 1) as f32) * 0.5;
    (0..columns * rows).map(move |i| step * (vec3((i / rows) as f32, 0.0, (i % rows) as f32) - middle))
}

/// A 1 m sheet of `n` x `n` vertices, dropped from 0.15 m above the points of twenty upright cones on the floor.
#[must_use]
pub fn needles(n: u32) -> Scene {
    let (radius, height) = NEEDLE;
    let mut scene = Scene::new(vec![SceneCloth::new(sheet(n), fabric(), vec3(0.006, height + 0.15, 0.004), &[])]);
    if let Ok(cone) = shape::cone(radius, 0.5 * height) {
        let middle = Vec3::Y * (0.5 * height);
        scene.bodies.extend(feet().map(|foot| Body::at_rest(cone.clone(), Pose::from_translation(foot + middle))));
    }
    scene.bodies.extend(shape::half_space(Vec3::Y).ok().map(|floor| Body::at_rest(floor, Pose::IDENTITY)));
    scene
}
