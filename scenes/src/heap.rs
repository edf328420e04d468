//! A sheet of denim that hangs from one vertex is let go, and falls in a heap on the floor.

use std::sync::Arc;

use bevy_drape::ClothMaterial;
use bevy_drape::solver::anchors::Anchors;
use bevy_drape::solver::body::{Body, Pose, shape};
use bevy_drape::solver::rest::RestShape;
use glam::{Vec3, vec3};

use super::{Scene, SceneCloth, grid};

/// When it is let go `[s]`.
pub const LET_GO: f32 = 4.0;

/// Side of the sheet, and its height when it starts `[m]`.
const SIDE: f32 = 1.6;
const HEIGHT: f32 = 1.9;

/// A sheet of `n` x `n` vertices of raw denim that hangs from `vertex`, and is let go after [`LET_GO`].
#[must_use]
pub fn heap(n: u32, vertex: u32) -> Scene {
    let denim = ClothMaterial::DENIM.to_fabric();
    let mesh = grid(n, n, |u, v| SIDE * vec3(u - 0.5, 0.0, v - 0.5));
    let rest = RestShape::build(&mesh).map(|(rest, _)| rest).unwrap_or_default();
    let mut scene = Scene::new(vec![SceneCloth::new(Arc::new(rest), denim, Vec3::Y * HEIGHT, &[vertex])]);
    scene.bodies.extend(shape::half_space(Vec3::Y).ok().map(|floor| Body::at_rest(floor, Pose::IDENTITY)));
    scene.drive = Some(|scene, time| {
        for cloth in scene.cloths.iter_mut().filter(|cloth| time > LET_GO && !cloth.anchors.particles.is_empty()) {
            cloth.anchors = Anchors::default();
            cloth.prepare();
        }
    });
    scene
}
