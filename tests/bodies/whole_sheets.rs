//! Whole sheets against every shape of body: nothing passes through, and at rest nothing is inside.

use std::sync::Arc;

use bevy_drape::solver::body::{Body, Pose, SharedShape, shape};
use bevy_drape::solver::rest::RestShape;
use drape_scenes::{Scene, SceneCloth, fabric, grid};
use glam::{Quat, Vec3, Vec4, vec3};
use parry3d::query::Ray;
use parry3d::shape::TypedShape;

const N: u32 = 24;
const SIZE: f32 = 1.2;
const SPEED: f32 = 10.0;
/// One substep a frame, so that each way can be checked.
const SHORT: f32 = 1.0 / 360.0;

/// A bumpy grid of triangles, wound to face up.
fn hills(n: usize, size: f32, height: f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mesh = grid(n as u32, n as u32, |u, v| {
        vec3((v - 0.5) * size, height * 0.5 * ((u * 9.0).sin() + (v * 7.0).cos()), (u - 0.5) * size)
    });
    (mesh.positions, mesh.triangles)
}

fn shapes() -> Vec<(&'static str, SharedShape)> {
    let (vertices, triangles) = hills(17, 1.8, 0.1);
    let heights: Vec<f32> = vertices.iter().map(|p| p.y).collect();
    let mut random = fastrand::Rng::with_seed(4);
    let cloud: Vec<Vec3> = (0..60).map(|_| (vec3(random.f32(), random.f32(), random.f32()) - 0.5) * 0.7).collect();
    let parts = vec![
        (Pose::translation(-0.25, 0.0, 0.0), shape::cuboid(vec3(0.25, 0.1, 0.3)).expect("valid")),
        (Pose::translation(0.25, 0.0, 0.0), shape::cuboid(vec3(0.25, 0.1, 0.3)).expect("valid")),
        (Pose::translation(0.0, 0.1, 0.0), shape::ball(0.15).expect("valid")),
    ];
    let shapes = [
        ("ball", shape::ball(0.3)),
        ("capsule", shape::capsule_between(vec3(-0.4, 0.0, 0.0), vec3(0.4, 0.1, 0.0), 0.1)),
        ("cuboid", shape::cuboid(vec3(0.4, 0.2, 0.3))),
        ("cylinder", shape::cylinder(0.3, 0.2)),
        ("cone", shape::cone(0.3, 0.3)),
        ("convex hull", shape::convex_hull(&cloud)),
        ("half-space", shape::half_space(Vec3::Y)),
        ("triangle mesh", shape::trimesh(vertices, triangles)),
        ("height field", shape::heightfield(17, 17, &heights, vec3(1.8, 1.0, 1.8))),
        ("compound", shape::compound(parts)),
    ];
    shapes.into_iter().map(|(name, shape)| (name, shape.expect("valid"))).collect()
}

/// A sheet of [`N`] x [`N`] vertices in the plane of x and z, turned and moved, at one velocity.
fn sheet(turn: Quat, center: Vec3, velocity: Vec3, pins: &[u32]) -> Scene {
    let mesh = grid(N, N, |u, v| turn * (vec3(u - 0.5, 0.0, v - 0.5) * SIZE));
    let rest = Arc::new(RestShape::build(&mesh).expect("a valid mesh").0);
    let mut cloth = SceneCloth::new(rest, fabric(), center, pins);
    cloth.sim.state.substep = SHORT;
    for (x, old) in cloth.sim.state.positions.iter().zip(&mut cloth.sim.state.previous) {
        if x.w > 0.0 {
            *old = *x - (velocity * SHORT).extend(0.0);
        }
    }
    Scene::new(vec![cloth])
}

fn is_surface(shape: &SharedShape) -> bool {
    matches!(shape.as_typed_shape(), TypedShape::TriMesh(_) | TypedShape::HeightField(_))
}

/// Signed distance [m]; never negative for a surface.
fn distance(shape: &SharedShape, q: Vec3) -> f32 {
    let p = shape.project_local_point(q, false);
    if p.is_inside && !is_surface(shape) { -p.point.distance(q) } else { p.point.distance(q) }
}

/// Whether a straight way in body space goes through the shape.
fn passes(shape: &SharedShape, a: Vec3, b: Vec3) -> bool {
    if is_surface(shape) {
        a != b && shape.cast_local_ray(&Ray::new(a, b - a), 1.0, false).is_some()
    } else {
        (0..=8).any(|k| shape.contains_local_point(a.lerp(b, k as f32 / 8.0)))
    }
}

/// Steps and counts ways that go through the body.
fn frame(scene: &mut Scene, body: Body, dt: f32) -> usize {
    let before: Vec<Vec4> = scene.cloths[0].sim.state.positions.clone();
    scene.bodies = vec![body.clone()];
    scene.step(dt);
    let local = |pose: &Pose, x: &Vec4| pose.inverse_transform_point(x.truncate());
    let ways = before.iter().zip(&scene.cloths[0].sim.state.positions);
    // Pins go where they are put.
    ways.filter(|(a, b)| b.w > 0.0 && passes(&body.shape, local(&body.from, a), local(&body.to, b))).count()
}

#[test]
fn a_sheet_dropped_at_10_metres_per_second_stays_on_its_side_of_every_shape() {
    let mut bad = Vec::new();
    for (name, shape) in shapes() {
        let mut scene = sheet(Quat::IDENTITY, Vec3::Y * 0.8, Vec3::NEG_Y * SPEED, &[]);
        let body = Body::at_rest(shape, Pose::IDENTITY);
        let passed: usize = (0..180).map(|_| frame(&mut scene, body.clone(), SHORT)).sum();
        if passed > 0 {
            bad.push(format!("{name}: {passed} ways went through"));
        }
    }
    assert!(bad.is_empty(), "{bad:#?}");
}

#[test]
fn every_shape_driven_at_10_metres_per_second_pushes_a_free_and_a_hanging_sheet_before_it() {
    let mut bad = Vec::new();
    for (name, shape) in shapes() {
        for (how, pins) in [("free", &[][..]), ("hanging", &[0, N * (N - 1)])] {
            // Hanging: in the plane of x and y, and the shape comes along z.
            let turn = if pins.is_empty() { Quat::IDENTITY } else { Quat::from_rotation_x(std::f32::consts::FRAC_PI_2) };
            let ahead = turn * Vec3::Y;
            let mut scene = sheet(turn, Vec3::ZERO, Vec3::ZERO, pins);
            let pose = |k: u32| Pose::from_parts(ahead * (SPEED * SHORT * k as f32 - 0.7), turn);
            // A hanging sheet is not driven farther than it is long.
            let drive = (0..if pins.is_empty() { 36 } else { 28 })
                .map(|k| frame(&mut scene, Body::new(shape.clone(), pose(k), pose(k + 1)), SHORT));
            let passed: usize = drive.sum();
            if passed > 0 {
                bad.push(format!("{name}, {how}: {passed} ways went through"));
            }
        }
    }
    assert!(bad.is_empty(), "{bad:#?}");
}

#[test]
fn at_rest_on_every_shape_no_vertex_is_inside() {
    let mut bad = Vec::new();
    for (name, shape) in shapes() {
        let mut scene = sheet(Quat::IDENTITY, Vec3::Y * 0.6, Vec3::ZERO, &[]);
        let body = Body::at_rest(shape.clone(), Pose::IDENTITY);
        let floor = Body::at_rest(shape::half_space(Vec3::Y).expect("valid"), Pose::translation(0.0, -0.5, 0.0));
        scene.bodies = vec![body, floor];
        let mut nearest = f32::MAX;
        for n in 0..300 {
            scene.step(1.0 / 60.0);
            if n >= 240 {
                let gaps = scene.cloths[0].sim.state.positions.iter().map(|x| distance(&shape, x.truncate()));
                nearest = gaps.fold(nearest, f32::min);
            }
        }
        let thickness = scene.cloths[0].fabric.thickness;
        if nearest < -0.1 * thickness {
            bad.push(format!("{name}: {:.2} mm from the surface, thickness {:.2} mm", nearest * 1e3, thickness * 1e3));
        }
    }
    assert!(bad.is_empty(), "{bad:#?}");
}
