//! A corner of a hanging sheet pinched between two balls that close on it, drag it aside and let go.
//!
//! They close until they touch: there is no room for the sheet between them, and it has to end up in one of them, or both.

use glam::vec3;

use super::{Scene, SceneCloth, fabric, sheet, smooth};
use bevy_drape::solver::body::{Body, Pose, shape};

/// Radius of the balls `[m]`.
const BALL: f32 = 0.12;
/// Distance of their surfaces when open `[m]`.
const OPEN: f32 = 0.5;
/// When they begin to close, are closed, begin to open and are open, and the period `[s]`.
const TIMES: [f32; 5] = [0.5, 1.3, 2.8, 3.4, 5.0];
/// How far they drag the sheet aside while closed `[m]`.
const DRAG: f32 = 0.15;

/// Where the balls are after `time` `[s]`.
#[must_use]
pub fn balls(time: f32) -> [Pose; 2] {
    let [close, closed, open, opened, period] = TIMES;
    let time = time.rem_euclid(period);
    let grip = smooth((time - close) / (closed - close)) - smooth((time - open) / (opened - open));
    let drag = smooth((time - closed) / (open - closed)) - smooth((time - opened) / (period - opened));
    let apart = BALL + 0.5 * OPEN * (1.0 - grip);
    [1.0, -1.0].map(|side| Pose::from_translation(vec3(-0.42 + DRAG * drag, -0.88, side * apart)))
}

/// A 1 m sheet of `n` x `n` vertices, hung at two corners, and the balls.
#[must_use]
pub fn pinch(n: u32) -> Scene {
    let rest = sheet(n);
    let n = n.max(2);
    let mut cloth = SceneCloth::new(rest, fabric(), glam::Vec3::ZERO, &[0, n * n - n]);
    // Upright: the sheet lies in the plane y = 0, its pinned side at z = -0.5.
    for x in cloth.sim.state.positions.iter_mut().chain(&mut cloth.sim.state.previous) {
        *x = glam::vec4(x.x, -0.5 - x.z, 0.0, x.w);
    }
    for x in cloth.anchors.from.iter_mut().chain(&mut cloth.anchors.to) {
        *x = vec3(x.x, -0.5 - x.z, 0.0);
    }
    let mut scene = Scene::new(vec![cloth]);
    for at in balls(0.0) {
        scene.bodies.extend(shape::ball(BALL).ok().map(|ball| Body::at_rest(ball, at)));
    }
    scene.drive = Some(|scene, time| {
        scene.bodies.iter_mut().zip(balls(time)).for_each(|(body, to)| body.to = to);
    });
    scene
}
