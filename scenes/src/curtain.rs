//! A gathered curtain into which a ball swings.

use core::f32::consts::TAU;
use std::sync::Arc;

use glam::vec3;

use super::{Scene, SceneCloth, fabric, grid};
use bevy_drape::solver::body::{Body, Pose, shape};
use bevy_drape::solver::rest::{RestShape, SourceMesh};

/// Width and height of the curtain as it hangs `[m]`.
pub const SIZE: (f32, f32) = (1.2, 1.4);
/// Folds, and how far each reaches to either side `[m]`: the cloth is 1.4 times as wide as the curtain.
const FOLDS: (f32, f32) = (7.0, 0.035);
/// Radius of the ball `[m]`.
pub const BALL: f32 = 0.2;
/// Length of the rope, how far the ball swings to either side `[m]`, and the period `[s]`.
pub const SWING: (f32, f32, f32) = (1.8, 0.6, 2.7);
/// How far below the rail the ball hangs `[m]`.
const DEPTH: f32 = 0.8;

/// The curtain below y = 0, in the plane z = 0, of `n` vertices per metre and 3`n` / 2 across.
#[must_use]
pub fn mesh(n: u32) -> SourceMesh {
    let ((width, height), (folds, amplitude)) = (SIZE, FOLDS);
    let rows = (height * (n.max(2) - 1) as f32).round() as u32 + 1;
    grid(n.max(2) * 7 / 4, rows, |u, v| vec3(width * (u - 0.5), -height * v, amplitude * (TAU * folds * u).sin()))
}

/// Where the ball is after `time` `[s]`.
#[must_use]
pub fn ball(time: f32) -> Pose {
    let (rope, way, period) = SWING;
    let z = way * (TAU * time / period).cos();
    Pose::from_translation(vec3(0.05, rope - (rope * rope - z * z).sqrt() - DEPTH, z))
}

/// The curtain and the ball.
#[must_use]
pub fn curtain(n: u32) -> Scene {
    let mesh = mesh(n);
    let top: Vec<u32> = mesh.positions.iter().zip(0..).filter(|(p, _)| p.y > -1.0e-4).map(|(_, i)| i).collect();
    let (rest, _) = RestShape::build(&mesh).unwrap_or_default();
    let mut scene = Scene::new(vec![SceneCloth::new(Arc::new(rest), fabric(), glam::Vec3::ZERO, &top)]);
    scene.bodies.extend(shape::ball(BALL).ok().map(|shape| Body::at_rest(shape, ball(0.0))));
    scene.drive = Some(|scene, time| scene.bodies.iter_mut().for_each(|body| body.to = ball(time)));
    scene
}
