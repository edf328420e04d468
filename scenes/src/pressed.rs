//! A ball that comes down on a stack of sheets, presses it on the floor and goes up again: sphere on a stack of cloths of
//! Codimensional IPC (Li et al. 2021), with a ball whose way is given.

use std::sync::Arc;

use glam::{Quat, Vec3, vec3};

use super::{Scene, SceneCloth, fabric, grid, smooth};
use bevy_drape::solver::body::{Body, Pose, shape};
use bevy_drape::solver::rest::RestShape;

/// Sheets, and height between two of them at first `[m]`.
const SHEETS: (u8, f32) = (10, 0.03);
/// Radius of the ball `[m]`.
const BALL: f32 = 0.15;
/// Height of the lowest point of the ball over the floor at first and at last `[m]`.
const HEIGHT: (f32, f32) = (0.5, 0.04);
/// When it comes down, how long that takes, and when it goes up `[s]`.
const DOWN: (f32, f32, f32) = (1.0, 0.4, 3.0);

/// Lowest point of the ball after `time` `[m]`.
fn lowest(time: f32) -> f32 {
    let (high, low) = HEIGHT;
    let (begins, lasts, ends) = DOWN;
    let down = smooth((time - begins) / lasts) - smooth((time - ends) / lasts);
    high + (low - high) * down
}

/// Sheets of 1 m, `n` x `n` vertices each, one above the other and each turned against the one below.
#[must_use]
pub fn pressed(n: u32) -> Scene {
    let (count, apart) = SHEETS;
    let sheet = |i: u8| {
        let turn = Quat::from_rotation_y(core::f32::consts::FRAC_PI_2 * f32::from(i) / f32::from(count + 1));
        let (rest, _) = RestShape::build(&grid(n, n, |u, v| turn * vec3(u - 0.5, 0.0, v - 0.5))).unwrap_or_default();
        SceneCloth::new(Arc::new(rest), fabric(), Vec3::Y * apart * f32::from(i + 1), &[])
    };
    let mut scene = Scene::new((0..count).map(sheet).collect());
    let floor = shape::half_space(Vec3::Y).ok().map(|floor| Body::at_rest(floor, Pose::IDENTITY));
    let ball = shape::ball(BALL).ok().map(|ball| Body::at_rest(ball, Pose::from_translation(Vec3::Y * (lowest(0.0) + BALL))));
    scene.bodies.extend(floor.into_iter().chain(ball));
    scene.drive = Some(|scene, time| {
        if let Some(ball) = scene.bodies.last_mut() {
            ball.to = Pose::from_translation(Vec3::Y * (lowest(time) + BALL));
        }
    });
    scene
}
