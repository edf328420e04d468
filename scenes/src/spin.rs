//! A garment on a body that spins up, brakes and spins the other way: it flies up, winds round the body and unwinds.

use core::f32::consts::TAU;
use std::sync::Arc;

use glam::{Quat, Vec2, Vec3, vec3};

use super::{Scene, SceneCloth, fabric, grid};
use bevy_drape::solver::body::{Body, Pose, shape};
use bevy_drape::solver::rest::{RestShape, SourceMesh};

/// Radius at the waist and at the hem of the skirt that is cut as a flat ring `[m]`.
const RING: (f32, f32) = (0.15, 0.5);
/// Turns per second when it is fastest `[1/s]`, and time after which it repeats `[s]`.
const SPIN: (f32, f32) = (1.0, 5.0);

/// A skirt cut as a flat ring round the y axis, of `n` vertices per metre.
#[must_use]
pub fn ring(n: u32) -> SourceMesh {
    let (waist, hem) = RING;
    let per_metre = (n.max(4) - 1) as f32;
    let around = (0.5 * (waist + hem) * TAU * per_metre).round() as u32 + 1;
    let across = ((hem - waist) * per_metre).round() as u32 + 1;
    grid(around, across, |u, v| {
        let (sin, cos) = (TAU * u.fract()).sin_cos();
        let radius = waist + (hem - waist) * v;
        // No flatter than cloth can be: a cone of 6 degrees knows which way down is.
        vec3(radius * sin, -0.1 * (radius - waist), radius * cos)
    })
}

/// How far the body has turned after `time` `[s]`: `∫ TAU f sin(TAU t / T) dt`, one way and back.
fn turned(time: f32) -> f32 {
    let (fastest, period) = SPIN;
    fastest * period * (1.0 - (TAU * time / period).cos())
}

/// The ring on a spinning body.
#[must_use]
pub fn spin(n: u32) -> Scene {
    spin_of(&ring(n))
}

/// Any garment round the y axis, held at its innermost vertices, on a spinning body that fits it.
#[must_use]
pub fn spin_of(mesh: &SourceMesh) -> Scene {
    let radius = |p: &Vec3| Vec2::new(p.x, p.z).length();
    let waist = mesh.positions.iter().map(radius).fold(f32::INFINITY, f32::min);
    let held = mesh.positions.iter().zip(0..).filter(|(p, _)| radius(p) < 1.01 * waist);
    let (held, heights): (Vec<u32>, Vec<f32>) = held.map(|(p, i)| (i, p.y)).unzip();
    let height = heights.iter().sum::<f32>() / heights.len().max(1) as f32;
    let (rest, _) = RestShape::build(mesh).unwrap_or_default();
    let mut scene = Scene::new(vec![SceneCloth::new(Arc::new(rest), fabric(), Vec3::ZERO, &held)]);
    let side = vec3(0.55 * waist, 0.0, 0.0);
    let hips =
        shape::capsule_between(0.4 * side, -0.4 * side, 0.6 * waist).ok().map(|hips| (hips, Vec3::Y * (height - 0.6 * waist)));
    let legs = [side, -side].map(|at| {
        let top = at + Vec3::Y * (height - 0.8 * waist);
        shape::capsule_between(Vec3::ZERO, vec3(0.0, -0.7, 0.0), 0.4 * waist).ok().map(|leg| (leg, top))
    });
    let parts: Vec<_> =
        hips.into_iter().chain(legs.into_iter().flatten()).map(|(s, at)| (Pose::from_translation(at), s)).collect();
    scene.bodies.extend(shape::compound(parts).ok().map(|body| Body::at_rest(body, Pose::IDENTITY)));
    scene.drive = Some(|scene, time| {
        let turn = Quat::from_rotation_y(turned(time));
        scene.bodies.iter_mut().for_each(|body| body.to = Pose::from_parts(Vec3::ZERO, turn));
        for SceneCloth { rest, anchors, .. } in &mut scene.cloths {
            for (&p, to) in anchors.particles.iter().zip(&mut anchors.to) {
                *to = turn * rest.positions[p as usize];
            }
        }
    });
    scene
}
