//! A strip whose two ends are turned against each other, first into a rope, then, as they come closer, into a knot.

use core::f32::consts::TAU;
use std::sync::Arc;

use glam::{Quat, vec3};

use super::{Scene, SceneCloth, fabric, grid, smooth};
use bevy_drape::solver::body::Pose;
use bevy_drape::solver::rest::{RestShape, SourceMesh};

/// Length and width of the strip `[m]`.
const STRIP: (f32, f32) = (1.2, 0.35);
/// Turns of either end, and how long they take `[s]`.
const TURNS: (f32, f32) = (2.0, 6.0);
/// How far either end comes in `[m]`, and when it begins and is done `[s]`.
const APPROACH: (f32, f32, f32) = (0.3, 0.0, 7.0);

/// The strip along x, with `n` vertices per metre.
#[must_use]
pub fn mesh(n: u32) -> SourceMesh {
    let (length, width) = STRIP;
    let along = |side: f32| (side * (n.max(2) - 1) as f32).round() as u32 + 1;
    grid(along(length), along(width), |u, v| vec3(length * (u - 0.5), 0.0, width * (v - 0.5)))
}

/// Whether a vertex of [`mesh`] is held: by the first end, or by the second.
#[must_use]
pub fn end_of(x: f32) -> Option<usize> {
    (x.abs() > 0.4999 * STRIP.0).then_some(usize::from(x > 0.0))
}

/// Where the ends are after `time` `[s]`, with the middle of the strip as origin.
#[must_use]
pub fn ends(time: f32) -> [Pose; 2] {
    let (turns, lasts) = TURNS;
    let (way, from, to) = APPROACH;
    let angle = TAU * turns * smooth(time / lasts);
    let x = way * smooth((time - from) / (to - from));
    [1.0, -1.0].map(|side| Pose::from_parts(vec3(side * x, 0.0, 0.0), Quat::from_rotation_x(side * angle)))
}

/// The strip, held at both ends.
#[must_use]
pub fn twist(n: u32) -> Scene {
    let mesh = mesh(n);
    let held = mesh.positions.iter().zip(0..).filter(|(p, _)| end_of(p.x).is_some());
    let held: Vec<u32> = held.map(|(_, i)| i).collect();
    let (rest, _) = RestShape::build(&mesh).unwrap_or_default();
    let mut scene = Scene::new(vec![SceneCloth::new(Arc::new(rest), fabric(), glam::Vec3::ZERO, &held)]);
    scene.drive = Some(|scene, time| {
        let ends = ends(time);
        for SceneCloth { rest, anchors, .. } in &mut scene.cloths {
            for (&p, to) in anchors.particles.iter().zip(&mut anchors.to) {
                let start = rest.positions[p as usize];
                *to = ends[end_of(start.x).unwrap_or(0)] * start;
            }
        }
    });
    scene
}
