//! Faces of cloth and bodies that are finer than the mesh. What is asked is worked out here in f64, from the numbers of the
//! bodies: nothing of it is the solver's.

use std::sync::Arc;

use bevy_drape::solver::body::{Body, Pose, shape};
use bevy_drape::solver::rest::RestShape;
use drape_scenes::{Scene, SceneCloth, fabric, funnel, grid, needles, tablecloth, untangled};
use glam::{DVec3, Quat, Vec3, vec3};

const FRAME: f32 = 1.0 / 60.0;
/// How deep a midpoint of an edge or a middle of a face may lie in a body [m].
const DEEPEST: f32 = 1.0e-3;

/// A level sheet of 1 m and `n` x `n` vertices, held at the corners if `held`.
fn sheet(n: u32, at: Vec3, held: bool) -> SceneCloth {
    let (rest, _) = RestShape::build(&grid(n, n, |u, v| vec3(u - 0.5, 0.0, v - 0.5))).expect("a sheet");
    let corners = [0, n - 1, n * n - n, n * n - 1];
    SceneCloth::new(Arc::new(rest), fabric(), at, if held { &corners } else { &[] })
}

/// What is shown of the first cloth [m], and its faces.
fn shown(scene: &Scene) -> (Vec<DVec3>, &[[u32; 3]]) {
    let cloth = &scene.cloths[0];
    let live = || cloth.sim.state.positions.iter().map(|x| x.truncate().as_dvec3()).collect();
    let positions = cloth.sim.display.held().map_or_else(live, |held| held.iter().map(|x| x.as_dvec3()).collect());
    (positions, &cloth.rest.topology.faces)
}

/// Whether a segment goes through a triangle, by the signs of the volumes that they span.
fn crosses([u, v]: [DVec3; 2], [p, q, r]: [DVec3; 3]) -> bool {
    let volume = |a: DVec3, b: DVec3, c: DVec3, d: DVec3| (b - a).cross(c - a).dot(d - a);
    let sides = [volume(u, v, p, q), volume(u, v, q, r), volume(u, v, r, p)];
    let around = sides.iter().all(|s| *s > 0.0) || sides.iter().all(|s| *s < 0.0);
    volume(p, q, r, u) * volume(p, q, r, v) < 0.0 && around
}

/// Midpoints of the edges and the middle of a face.
fn middles([a, b, c]: [DVec3; 3]) -> [DVec3; 4] {
    [(a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0, (a + b + c) / 3.0]
}

/// How deep the deepest of those lies in a shape, `depth` of a point being positive inside [m].
fn deepest(scene: &Scene, depth: impl Fn(DVec3) -> f64) -> f64 {
    let (x, faces) = shown(scene);
    let all = faces.iter().flat_map(|face| middles(face.map(|v| x[v as usize])));
    all.map(depth).fold(0.0, f64::max)
}

#[test]
fn no_needle_comes_through_a_sheet_that_falls_on_twenty() {
    let (radius, height) = (f64::from(needles::NEEDLE.0), f64::from(needles::NEEDLE.1));
    let axes: Vec<[DVec3; 2]> = needles::feet().map(Vec3::as_dvec3).map(|foot| [foot, foot + DVec3::Y * height]).collect();
    for n in [13, 20, 28] {
        for seed in 1..=2 {
            let mut scene = untangled(needles(n).jittered(seed), true);
            for frame in 1..=150 {
                scene.step(FRAME);
                let (x, faces) = shown(&scene);
                for face in faces {
                    let face = face.map(|v| x[v as usize]);
                    let through = axes.iter().filter(|axis| crosses(**axis, face)).count();
                    assert_eq!(through, 0, "{n}², start {seed}, frame {frame}: needles whose axis goes through {face:?}");
                }
                // A lower bound on how deep a point of the cone lies: how far it is within its side, for slopes as steep as
                // these.
                let depth = |p: DVec3| {
                    let off = axes.iter().map(|[foot, _]| (p - *foot) * DVec3::new(1.0, 0.0, 1.0)).map(DVec3::length);
                    radius * (1.0 - p.y / height) - off.fold(f64::INFINITY, f64::min)
                };
                let deep = deepest(&scene, depth);
                assert!(deep < f64::from(DEEPEST), "{n}², start {seed}, frame {frame}: {deep} m in a needle");
            }
            // It hangs on the points.
            assert!(scene.cloths[0].lowest() > 0.01, "{n}²: lowest particle at {} m", scene.cloths[0].lowest());
        }
    }
}

#[test]
fn a_ball_smaller_than_a_face_does_not_pass_a_held_sheet() {
    let n = 25;
    let edge = 1.0 / (n - 1) as f32;
    for speed in [1.0, 10.0] {
        // Over the middles of a face, of an edge and of a diagonal.
        for off in [vec3(0.3, 0.0, 0.3), vec3(0.5, 0.0, 0.0), vec3(0.5, 0.0, 0.5), vec3(0.62, 0.0, 0.27)] {
            let mut scene = Scene::new(vec![sheet(n, Vec3::ZERO, true)]);
            let radius = 0.5 * edge;
            // It stops 0.1 m below, where the cloth can follow within its strain limit.
            let path = |time: f32| Pose::from_translation(off * edge + Vec3::Y * (0.1 - speed * time).max(-0.1));
            scene.bodies.push(Body::at_rest(shape::ball(radius).expect("a ball"), path(0.0)));
            let mut scene = untangled(scene, true);
            for frame in 1..=60 {
                let body = &mut scene.bodies[0];
                (body.from, body.to) = (body.to, path(frame as f32 * FRAME));
                scene.step(FRAME);
                let centre = scene.bodies[0].to.translation.as_dvec3();
                let (x, faces) = shown(&scene);
                let over = faces.iter().filter(|t| crosses([centre, centre + DVec3::Y], t.map(|v| x[v as usize]))).count();
                assert_eq!(over, 0, "{speed} m/s at {off}, frame {frame}: faces over the ball");
                let deep = deepest(&scene, |p| f64::from(radius) - p.distance(centre));
                assert!(deep < f64::from(DEEPEST), "{speed} m/s at {off}, frame {frame}: {deep} m in the ball");
            }
        }
    }
}

#[test]
fn a_sheet_on_a_corner_or_an_edge_of_a_box_does_not_sink_in() {
    let half = vec3(0.15, 0.1, 0.2);
    let tip = Quat::from_rotation_arc(half.normalize(), Vec3::Y);
    let ridge = Quat::from_rotation_y(0.4) * Quat::from_rotation_x(0.8);
    for (name, turn) in [("flat", Quat::IDENTITY), ("an edge", ridge), ("a corner", tip)] {
        for n in [13, 28] {
            let mut scene = Scene::new(vec![sheet(n, vec3(0.011, 0.5, 0.017), false)]);
            let pose = Pose::from_parts(Vec3::ZERO, turn);
            scene.bodies.push(Body::at_rest(shape::cuboid(half).expect("a box"), pose));
            let mut scene = untangled(scene, true);
            let (back, half) = (turn.inverse().as_dquat(), half.as_dvec3());
            for frame in 1..=90 {
                scene.step(FRAME);
                let deep = deepest(&scene, |p| (half - (back * p).abs()).min_element());
                assert!(deep < f64::from(DEEPEST), "{name} up, {n}², frame {frame}: {deep} m in the box");
            }
        }
    }
}

#[test]
fn a_sheet_over_the_corners_of_a_box_is_not_drawn_out() {
    let mut scene = Scene::new(vec![sheet(60, Vec3::Y * 0.32, false)]).jittered(1);
    scene.bodies.push(Body::at_rest(shape::cuboid(Vec3::splat(0.3)).expect("a box"), Pose::IDENTITY));
    let mut scene = untangled(scene, true);
    for frame in 1..=120 {
        scene.step(FRAME);
        let edge = scene.cloths[0].report.worst_edge;
        assert!(edge < if frame < 60 { 1.25 } else { 1.15 }, "frame {frame}: an edge is {edge} of its length at rest");
    }
}

/// The CCD of cloth took its mean motion into the table again, and one push out made room for the next.
#[test]
fn no_edge_of_a_table_cloth_that_is_pulled_away_is_drawn_through_the_table() {
    let half = tablecloth::TABLE.as_dvec3();
    // Of eight starts of 36² start 3 jams.
    for (n, starts, has_none) in [(30, 1..=4, true), (36, 1..=2, false), (40, 1..=2, true)] {
        for seed in starts {
            let mut scene = untangled(tablecloth(n).jittered(seed), true);
            let mut worst = 0.0f32;
            for frame in 1..=150 {
                scene.step(FRAME);
                worst = worst.max(scene.cloths[0].report.worst_edge);
                let deep = deepest(&scene, |p| (half - (p + DVec3::Y * half.y).abs()).min_element());
                assert!(!has_none || deep < f64::from(DEEPEST), "{n}², start {seed}, frame {frame}: {deep} m in the table");
            }
            assert!(worst < if has_none { 3.0 } else { 6.0 }, "{n}², start {seed}: worst edge {worst}");
            let lowest = scene.cloths[0].lowest();
            assert!(lowest < -0.5, "{n}², start {seed}: lowest particle at {lowest} m");
        }
    }
}

#[test]
fn a_cone_that_rises_beside_an_edge_of_a_coarse_sheet_does_not_come_through() {
    const HEIGHT: f32 = 0.2;
    let n = 9;
    let edge = 1.0 / (n - 1) as f32;
    for off in [0.0, 0.01, 0.03, 0.1] {
        let mut scene = Scene::new(vec![sheet(n, Vec3::ZERO, true)]);
        let foot = |y: f32| vec3(off * edge, y - HEIGHT, 0.43 * edge);
        let cone = shape::cone(0.004, HEIGHT).expect("a cone");
        scene.bodies.push(Body::at_rest(cone, Pose::from_translation(foot(-0.35))));
        (0..30).for_each(|_| scene.step(FRAME));
        let (axis, mut y) = (DVec3::Y * f64::from(HEIGHT), -0.35);
        while y < 0.2 {
            y += 0.5 * FRAME;
            let body = &mut scene.bodies[0];
            (body.from, body.to) = (body.to, Pose::from_translation(foot(y)));
            scene.step(FRAME);
            let (x, faces) = shown(&scene);
            let middle = foot(y).as_dvec3();
            let through = faces.iter().any(|face| crosses([middle - axis, middle + 0.98 * axis], face.map(|v| x[v as usize])));
            assert!(!through, "{off} of an edge beside it: the cone is through at {y} m");
        }
    }
}

/// A particle is at the end on the far side of the wall if it is beside it and farther from the axis than that.
fn beside_and_outside(p: DVec3) -> bool {
    let [(rim, top), (neck, middle), (_, bottom)] = funnel::PROFILE.map(|(r, y)| (f64::from(r), f64::from(y)));
    let wall = if p.y > middle { neck + (rim - neck) * (p.y - middle) / (top - middle) } else { neck };
    p.y > bottom && p.y < top && (p * DVec3::new(1.0, 0.0, 1.0)).length() > wall
}

#[test]
fn a_sheet_goes_through_a_funnel_and_not_through_its_wall() {
    let (vertices, triangles) = funnel::surface();
    let walls: Vec<[DVec3; 3]> = triangles.iter().map(|t| t.map(|v| vertices[v as usize].as_dvec3())).collect();
    for n in [13, 20, 28] {
        let mut scene = untangled(funnel(n).jittered(1), true);
        let (frames, mut through) = (300, 0);
        for _ in 0..frames {
            scene.step(FRAME);
            let (x, _) = shown(&scene);
            let edges = &scene.cloths[0].rest.topology.edges;
            let mut crossed = edges.iter().map(|e| e.map(|v| x[v as usize])).filter(|&[u, v]| {
                walls.iter().any(|&wall| {
                    let meet = |a: DVec3, b: DVec3| (a.cmple(b)).all();
                    let [p, q, r] = wall;
                    meet(u.min(v), p.max(q).max(r)) && meet(p.min(q).min(r), u.max(v)) && crosses([u, v], wall)
                })
            });
            through += u32::from(crossed.next().is_some());
        }
        let (x, _) = shown(&scene);
        let outside = x.iter().filter(|p| beside_and_outside(**p)).count();
        assert_eq!(outside, 0, "{n}: particles outside of the wall at the end");
        assert!(through <= frames / 20, "{n}: edges through the wall in {through} of {frames} frames");
    }
}

#[test]
fn a_ball_that_goes_through_the_middle_of_a_curtain_takes_it_along_whole() {
    for (n, speed, longest) in [(22, 3.0, 1.2), (32, 3.0, 1.2), (43, 5.0, 1.3)] {
        let mesh = grid(n, n, |u, v| vec3(u - 0.5, -v, 0.0));
        let top: Vec<u32> = mesh.positions.iter().zip(0..).filter(|(p, _)| p.y > -1e-4).map(|(_, i)| i).collect();
        let (rest, _) = RestShape::build(&mesh).expect("a sheet");
        let mut scene = Scene::new(vec![SceneCloth::new(Arc::new(rest), fabric(), Vec3::ZERO, &top)]);
        (0..120).for_each(|_| scene.step(FRAME));
        let at = |z: f32| Pose::from_translation(vec3(0.0, -0.5, z));
        let mut z = -0.6;
        scene.bodies.push(Body::at_rest(shape::ball(0.1).expect("a ball"), at(z)));
        let mut worst = 0.0_f32;
        while z < 0.5 {
            scene.bodies[0].from = at(z);
            z += speed * FRAME;
            scene.bodies[0].to = at(z);
            scene.step(FRAME);
            worst = worst.max(scene.cloths[0].report.worst_edge);
        }
        assert!(worst < longest, "{n} x {n} at {speed} m/s: {worst}");
        let farthest = scene.cloths[0].sim.state.positions.iter().map(|x| x.z).fold(f32::MIN, f32::max);
        assert!(farthest > z, "the curtain is left behind: {farthest} m, the ball is at {z} m");
    }
}
