//! Two strips that fall crosswise on each other, over a ball on the floor.

use std::sync::Arc;

use glam::{Quat, Vec3, vec3};

use super::{Scene, SceneCloth, fabric, grid};
use bevy_drape::solver::body::{Body, Pose, shape};
use bevy_drape::solver::rest::RestShape;

/// Radius of the ball `[m]`.
const BALL: f32 = 0.2;
/// Length and width of a strip `[m]`.
const STRIP: (f32, f32) = (1.2, 0.5);

/// Two strips with `n` vertices per metre, one turned by a right angle against the other and 0.1 m above it.
#[must_use]
pub fn crosswise(n: u32) -> Scene {
    let (length, width) = STRIP;
    let along = |side: f32| (side * (n.max(2) - 1) as f32).round() as u32 + 1;
    let strip = |turn: f32, at: Vec3| {
        let turn = Quat::from_rotation_y(turn);
        let point = |u: f32, v: f32| turn * vec3(length * (u - 0.5), 0.0, width * (v - 0.5));
        let (rest, _) = RestShape::build(&grid(along(length), along(width), point)).unwrap_or_default();
        SceneCloth::new(Arc::new(rest), fabric(), at, &[])
    };
    let mut scene =
        Scene::new(vec![strip(0.02, vec3(0.01, 0.5, 0.0)), strip(core::f32::consts::FRAC_PI_2, vec3(0.0, 0.6, 0.02))]);
    let ball = shape::ball(BALL).ok().map(|ball| Body::at_rest(ball, Pose::from_translation(vec3(0.0, BALL, 0.0))));
    let floor = shape::half_space(Vec3::Y).ok().map(|floor| Body::at_rest(floor, Pose::IDENTITY));
    scene.bodies.extend(ball.into_iter().chain(floor));
    scene
}
