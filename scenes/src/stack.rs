//! A stack of sheets that falls on a ball: every layer carries all that lie above it.

use std::sync::Arc;

use glam::{Vec3, vec3};

use super::{Scene, SceneCloth, fabric, sheet};
use bevy_drape::solver::body::{Body, Pose, shape};

/// Radius of the ball, whose centre is the origin `[m]`.
pub const BALL: f32 = 0.3;
/// Height of the floor `[m]`.
const FLOOR: f32 = -0.5;
/// Height of the lowest sheet above the top of the ball, and between two sheets `[m]`.
const DROP: (f32, f32) = (0.1, 0.02);

/// Where sheet `i`, counted from below, begins `[m]`. A little aside, so that no two edges lie exactly above each other.
#[must_use]
pub fn place(i: u32) -> Vec3 {
    let i = i as f32;
    vec3(0.004 * (1.7 * i).sin(), BALL + DROP.0 + DROP.1 * i, 0.004 * (2.3 * i).cos())
}

/// `k` sheets of 1 m and `n` x `n` vertices, one above the other, dropped on a ball above a floor.
#[must_use]
pub fn stack(k: u32, n: u32) -> Scene {
    let rest = sheet(n);
    let mut scene = Scene::new((0..k.max(1)).map(|i| SceneCloth::new(Arc::clone(&rest), fabric(), place(i), &[])).collect());
    let ball = shape::ball(BALL).ok().map(|ball| Body::at_rest(ball, Pose::IDENTITY));
    let floor = shape::half_space(Vec3::Y).ok().map(|floor| Body::at_rest(floor, Pose::from_translation(Vec3::Y * FLOOR)));
    scene.bodies.extend(ball.into_iter().chain(floor));
    scene
}
