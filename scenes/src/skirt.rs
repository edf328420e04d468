//! A skirt on a body that walks in a circle: hips that turn and rise, legs that swing, all capsules.

use core::f32::consts::TAU;
use std::sync::Arc;

use glam::{Quat, Vec3, vec3};

use super::{Scene, SceneCloth, fabric, grid};
use bevy_drape::solver::body::{Body, Pose, shape};
use bevy_drape::solver::rest::{RestShape, SourceMesh};

/// Radius at the waist and at the hem, and length along the slope `[m]`.
pub const CUT: (f32, f32, f32) = (0.15, 0.40, 0.56);
/// Strides per second: a stride is a step of each leg `[1/s]`.
const STRIDES: f32 = 0.9;
/// Radius of the circle `[m]` and speed on it `[m/s]`.
const WALK: (f32, f32) = (0.8, 0.9);
/// How far a leg swings to either side `[rad]`, and the hips turn.
const SWING: (f32, f32) = (0.45, 0.15);
/// Time in which the walk begins `[s]`.
const START: f32 = 1.5;

/// A part of the body: a capsule between two points in the frame that carries it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limb {
    /// Ends of its axis `[m]`.
    pub ends: [Vec3; 2],
    /// Radius `[m]`.
    pub radius: f32,
}

/// The hips, in the frame of the waist, and the legs, each in the frame of its joint.
pub const LIMBS: [Limb; 3] = [
    Limb { ends: [vec3(-0.05, -0.11, 0.0), vec3(0.05, -0.11, 0.0)], radius: 0.105 },
    Limb { ends: [Vec3::ZERO, vec3(-0.01, -0.8, 0.0)], radius: 0.065 },
    Limb { ends: [Vec3::ZERO, vec3(0.01, -0.8, 0.0)], radius: 0.065 },
];
/// Joints of the legs in the frame of the waist `[m]`.
const JOINTS: [Vec3; 2] = [vec3(-0.085, -0.13, 0.0), vec3(0.085, -0.13, 0.0)];

/// The skirt: a cone open at both ends, its waist in the plane y = 0, of `n` vertices per metre.
#[must_use]
pub fn mesh(n: u32) -> SourceMesh {
    let (waist, hem, length) = CUT;
    let drop = (length * length - (hem - waist) * (hem - waist)).sqrt();
    let per_metre = (n.max(4) - 1) as f32;
    let around = (0.5 * (waist + hem) * TAU * per_metre).round() as u32 + 1;
    let down = (length * per_metre).round() as u32 + 1;
    grid(around, down, |u, v| {
        // The last column is the first again: they are welded.
        let (sin, cos) = (TAU * u.fract()).sin_cos();
        let radius = waist + (hem - waist) * v;
        vec3(radius * sin, -drop * v, radius * cos)
    })
}

/// How long the walk has lasted after `time` `[s]`, had it begun at full speed.
fn walked(time: f32) -> f32 {
    let time = time.max(0.0);
    if time < START { 0.5 * time * time / START } else { time - 0.5 * START }
}

/// Where the waist is after `time` `[s]`.
#[must_use]
pub fn waist(time: f32) -> Pose {
    let (radius, speed) = WALK;
    let walked = walked(time);
    let (heading, phase) = (walked * speed / radius, TAU * STRIDES * walked);
    let (sin, cos) = heading.sin_cos();
    let at = vec3(-radius * cos, 0.02 * (2.0 * phase).sin(), radius * sin);
    Pose::from_parts(at, Quat::from_rotation_y(heading + SWING.1 * phase.sin()) * Quat::from_rotation_z(0.05 * phase.sin()))
}

/// Where the [`LIMBS`] are after `time` `[s]`.
#[must_use]
pub fn limbs(time: f32) -> [Pose; 3] {
    let waist = waist(time);
    let swing = SWING.0 * (TAU * STRIDES * walked(time)).sin();
    let leg = |side: usize, angle: f32| waist * Pose::from_parts(JOINTS[side], Quat::from_rotation_x(angle));
    [waist, leg(0, swing), leg(1, -swing)]
}

/// The skirt on the body.
#[must_use]
pub fn skirt(n: u32) -> Scene {
    let mesh = mesh(n);
    let held: Vec<u32> = mesh.positions.iter().zip(0..).filter(|(p, _)| p.y > -1.0e-4).map(|(_, i)| i).collect();
    let (rest, _) = RestShape::build(&mesh).unwrap_or_default();
    let start = waist(0.0);
    let mut cloth = SceneCloth::new(Arc::new(rest), fabric(), Vec3::ZERO, &held);
    for x in cloth.sim.state.positions.iter_mut().chain(&mut cloth.sim.state.previous) {
        *x = (start * x.truncate()).extend(x.w);
    }
    for x in cloth.anchors.from.iter_mut().chain(&mut cloth.anchors.to) {
        *x = start * *x;
    }
    let mut scene = Scene::new(vec![cloth]);
    for (Limb { ends: [a, b], radius }, pose) in LIMBS.into_iter().zip(limbs(0.0)) {
        scene.bodies.extend(shape::capsule_between(a, b, radius).ok().map(|shape| Body::at_rest(shape, pose)));
    }
    scene.drive = Some(|scene, time| {
        scene.bodies.iter_mut().zip(limbs(time)).for_each(|(body, to)| body.to = to);
        let waist = waist(time);
        for SceneCloth { rest, anchors, .. } in &mut scene.cloths {
            for (&p, to) in anchors.particles.iter().zip(&mut anchors.to) {
                *to = waist * rest.positions[p as usize];
            }
        }
    });
    scene
}
