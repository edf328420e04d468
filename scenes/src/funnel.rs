//! A sheet falls through a funnel, crumpled to a twentieth of its area on the way, and onto the floor.

use core::f32::consts::TAU;
use std::sync::Arc;

use glam::{Vec3, vec3};

use super::{Scene, SceneCloth, fabric, grid};
use bevy_drape::solver::body::{Body, Pose, shape};
use bevy_drape::solver::rest::RestShape;

/// Radius and height of the rim, of the neck and of the mouth of the spout `[m]`.
pub const PROFILE: [(f32, f32); 3] = [(0.55, 0.75), (0.11, 0.0), (0.11, -0.2)];
/// Height of the floor `[m]`.
pub const FLOOR: f32 = -0.8;
/// Side and height of the sheet `[m]`.
pub const SHEET: (f32, f32) = (0.8, 0.85);
/// Friction of the funnel: of polished metal (dimensionless).
pub const FRICTION: f32 = 0.05;
/// Corners of the funnel seen from above.
const CORNERS: u32 = 64;

/// Vertices `[m]` and triangles of the funnel, seen from above and from below.
#[must_use]
pub fn surface() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let ring = |(radius, y): (f32, f32)| {
        (0..CORNERS).map(move |i| {
            let (sin, cos) = (TAU * i as f32 / CORNERS as f32).sin_cos();
            vec3(radius * cos, y, radius * sin)
        })
    };
    let quads = |row: u32| {
        (0..CORNERS).flat_map(move |i| {
            let (a, b) = (row * CORNERS + i, row * CORNERS + (i + 1) % CORNERS);
            [[a, b, a + CORNERS], [b, b + CORNERS, a + CORNERS]]
        })
    };
    (PROFILE.into_iter().flat_map(ring).collect(), (0..PROFILE.len() as u32 - 1).flat_map(quads).collect())
}

/// A sheet with `n` vertices per metre above a funnel above a floor.
#[must_use]
pub fn funnel(n: u32) -> Scene {
    let (side, height) = SHEET;
    let count = (side * (n.max(2) - 1) as f32).round() as u32 + 1;
    let (rest, _) = RestShape::build(&grid(count, count, |u, v| side * vec3(u - 0.5, 0.0, v - 0.5))).unwrap_or_default();
    let mut scene = Scene::new(vec![SceneCloth::new(Arc::new(rest), fabric(), vec3(0.01, height, 0.02), &[])]);
    let (vertices, triangles) = surface();
    let funnel = shape::trimesh(vertices, triangles).ok().map(|funnel| Body {
        static_friction: FRICTION,
        dynamic_friction: FRICTION,
        ..Body::at_rest(funnel, Pose::IDENTITY)
    });
    let floor = shape::half_space(Vec3::Y).ok().map(|floor| Body::at_rest(floor, Pose::from_translation(Vec3::Y * FLOOR)));
    scene.bodies.extend(funnel.into_iter().chain(floor));
    scene
}
