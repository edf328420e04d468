//! The detector against a checker that shares no code with it.

use core::f32::consts::TAU;
use std::sync::Arc;

use bevy_drape::solver::detect::{Detector, PartRef, Surface};
use bevy_drape::solver::evaluate::EvaluateSettings;
use bevy_drape::solver::island::UntangleSettings;
use bevy_drape::solver::rest::{RestShape, SourceMesh};
use bevy_drape::solver::settings::Fabric;
use bevy_drape::solver::state::ClothState;
use drape_scenes::{self as scenes, Scene, SceneCloth};
use glam::{Vec3, Vec4, vec3};

fn assert_same(rest: &RestShape, positions: &[Vec4], what: &str) -> usize {
    let (topology, rest) = (&rest.topology, &rest.positions);
    let surface = Surface::new(&[PartRef { topology, rest, garment_layer: 0, self_collision: true, thickness: 0.005 }])
        .expect("one cloth");
    let mut detector = Detector::new(&surface);
    let found = detector.detect(&surface, positions).iter().filter(|c| !c.touching);
    let mut found: Vec<([u32; 2], u32)> = found.map(|c| (topology.edges[c.edge as usize], c.face)).collect();
    found.iter_mut().for_each(|(edge, _)| edge.sort_unstable());
    found.sort_unstable();
    let points: Vec<Vec3> = positions.iter().map(|x| x.truncate()).collect();
    let expected = drape_scenes::checker::crossings(&points, &topology.faces);
    let missed = expected.iter().filter(|c| found.binary_search(c).is_err()).count();
    let invented = found.iter().filter(|c| expected.binary_search(c).is_err()).count();
    assert_eq!((missed, invented), (0, 0), "{what}: of {} crossings (missed, invented)", expected.len());
    expected.len()
}

#[test]
fn every_crossing_of_crumpled_sheets_is_found() {
    let (mut crossings, mut looks) = (0, 0);
    for (name, mut scene) in [("ball", scenes::ball(48)), ("flag", scenes::flags(1, 40)), ("hang", scenes::hang(32))] {
        for frame in 0..150 {
            scene.step(1.0 / 60.0);
            if frame % 10 == 0 {
                let cloth = &scene.cloths[0];
                crossings += assert_same(&cloth.rest, &cloth.sim.state.positions, &format!("{name}, frame {frame}"));
                looks += 1;
            }
        }
    }
    assert!(crossings > 1000, "{crossings} crossings in {looks} looks: these sheets should cross themselves");
}

#[test]
fn cloth_from_one_end_of_infinity_to_the_other_is_left_out() {
    let n = 6;
    let (rest, _) = RestShape::build(&scenes::grid(n, n, |u, v| vec3(u, 0.0, v))).expect("a sheet");
    let (topology, shape) = (&rest.topology, &rest.positions);
    let part = PartRef { topology, rest: shape, garment_layer: 0, self_collision: true, thickness: 0.005 };
    let surface = Surface::new(&[part, part]).expect("two cloths");
    let mut detector = Detector::new(&surface);
    let sound = shape.iter().map(|p| p.extend(1.0));
    for poison in [f32::INFINITY, f32::NAN] {
        // Every face reaches both ends, with boxes that meet everything.
        let sign = |i: usize| if (i % n as usize + i / n as usize).is_multiple_of(2) { 1.0 } else { -1.0 };
        let broken = (0..shape.len()).map(|i| Vec3::splat(sign(i) * poison).extend(1.0));
        let positions: Vec<Vec4> = sound.clone().chain(broken).collect();
        assert!(detector.detect(&surface, &positions).is_empty(), "{poison}");
        assert!(detector.is_quarantined(1) && !detector.is_quarantined(0));
    }
}

/// Cloth that is pressed together within its plane folds back over single faces, while the normals around hardly bend.
#[test]
fn faces_that_slide_over_each_other_are_seen() {
    let n = 24;
    let edge = 1.0 / (n - 1) as f32;
    let (rest, _) = RestShape::build(&scenes::grid(n, n, |u, v| vec3(u, 0.0, v))).expect("a sheet");
    let mut rng = fastrand::Rng::with_seed(7);
    let mut crossings = 0;
    for (flat, up) in [(0.5, 0.1), (0.5, 0.3), (0.7, 0.1), (0.7, 0.3), (0.9, 0.1)] {
        for _ in 0..10 {
            let mut shift = |by: f32| by * edge * (2.0 * rng.f32() - 1.0);
            let mut move_one = |p: &Vec3| (*p + vec3(shift(flat), shift(up), shift(flat))).extend(1.0);
            let positions: Vec<Vec4> = rest.positions.iter().map(&mut move_one).collect();
            crossings += assert_same(&rest, &positions, &format!("moved by {flat} and {up} edges"));
        }
    }
    assert!(crossings > 1000, "{crossings} crossings");
}

/// Looked at in every frame, cloth that hardly moves is only looked at where it was close.
#[test]
fn what_comes_to_cross_by_and_by_is_seen_at_once() {
    let n = 20;
    let edge = 1.0 / (n - 1) as f32;
    let (rest, _) = RestShape::build(&scenes::grid(n, n, |u, v| vec3(u, 0.0, v))).expect("a sheet");
    let (topology, rest) = (&rest.topology, &rest.positions);
    let part = PartRef { topology, rest, garment_layer: 0, self_collision: true, thickness: 0.005 };
    let sheet = |at: &dyn Fn(Vec3) -> Vec3| rest.iter().map(|&x| at(x)).collect::<Vec<Vec3>>();
    // Two sheets pass through each other, and one is rolled up until its ends meet; by a hundredth of an edge in each frame.
    let wave = |x: Vec3, time: f32| edge * (0.2 * (9.0 * x.x).sin() + 0.01 * time - 0.4);
    let pass = |time: f32| [sheet(&|x| vec3(x.x, wave(x, time), x.z)), sheet(&|x| vec3(x.z, -wave(x, time), x.x))].concat();
    let roll = |time: f32| {
        let turn = 5.9 + 0.003 * time;
        sheet(&|x| vec3((turn * x.x).sin() / turn, (turn * x.x).cos() / turn * (1.0 + 0.02 * x.z), x.z + 0.1 * x.x))
    };
    let mut rng = fastrand::Rng::with_seed(3);
    let mut compare = |name: &str, parts: &[PartRef<'_>], at: &dyn Fn(f32) -> Vec<Vec3>| {
        let surface = Surface::new(parts).expect("one cloth or two");
        let (mut detector, mut other) = (Detector::new(&surface), Detector::new(&surface));
        let (mut first, mut crossings) = (None, 0);
        for frame in 0..200u8 {
            let mut shift = || 0.003 * edge * (2.0 * rng.f32() - 1.0);
            let mut move_one = |x: Vec3| (x + vec3(shift(), shift(), shift())).extend(1.0);
            let positions: Vec<Vec4> = at(f32::from(frame)).into_iter().map(&mut move_one).collect();
            let expected = other.detect(&surface, &positions);
            assert_eq!(detector.detect_again(&surface, &positions), expected, "{name}, frame {frame}");
            crossings += expected.len();
            if !expected.is_empty() {
                first = first.or(Some(frame));
            }
        }
        assert!(first.is_some_and(|frame| frame > 5) && crossings > 100, "{name}: from frame {first:?} on, {crossings}");
    };
    compare("pass", &[part, part], &pass);
    compare("roll", &[part], &roll);
}

/// A sheet in the plane y = 0, whose grid of `n` x `n` particles goes on in a strip of half as many rows: row 0 is the row
/// `from` of the sheet, the next ones are at `to(row, v)`.
fn sheet_with_strip(mut mesh: SourceMesh, n: u32, from: u32, to: impl Fn(u32, f32) -> Vec3) -> SourceMesh {
    let first = mesh.positions.len() as u32;
    let rows = n / 2;
    for row in 1..=rows {
        mesh.positions.extend((0..n).map(|j| to(row, j as f32 / (n - 1) as f32)));
    }
    let particle = |row: u32, j: u32| if row == 0 { from * n + j } else { first + (row - 1) * n + j };
    for (row, j) in (0..rows).flat_map(|row| (0..n - 1).map(move |j| (row, j))) {
        let [a, b, c, d] = [(row, j), (row, j + 1), (row + 1, j), (row + 1, j + 1)].map(|(row, j)| particle(row, j));
        mesh.triangles.extend([[a, b, c], [b, d, c]]);
    }
    mesh
}

fn flat(n: u32) -> SourceMesh {
    scenes::grid(n, n, |u, v| vec3(u, 0.0, v))
}

/// Every particle moved by up to `by` [m] upwards or downwards.
fn roughened(positions: impl Iterator<Item = Vec3>, by: f32) -> Vec<Vec4> {
    let mut rng = fastrand::Rng::with_seed(5);
    positions.map(|p| (p + by * (2.0 * rng.f32() - 1.0) * Vec3::Y).extend(1.0)).collect()
}

/// Three faces meet at the edges along which a flap is sewn on: which normals agree says nothing about what lies on what.
#[test]
fn a_flap_sewn_on_a_sheet_is_seen_to_cross_it() {
    let n = 17;
    let edge = 1.0 / (n - 1) as f32;
    let mesh = sheet_with_strip(flat(n), n, n / 2, |row, v| vec3(0.5, row as f32 * edge, v));
    let (rest, _) = RestShape::build(&mesh).expect("a sheet with a flap");
    let laid = rest.positions.iter().map(|&p| vec3(p.x + p.y, 0.0, p.z));
    assert!(assert_same(&rest, &roughened(laid, 0.1 * edge), "flap") > 100);
}

/// Half of a mesh is turned over, so that a sharp fold between the halves makes the normals agree.
#[test]
fn halves_with_different_fronts_that_are_folded_on_each_other_are_seen_to_cross() {
    let n = 17;
    let mut mesh = flat(n);
    let SourceMesh { positions, triangles, .. } = &mut mesh;
    for t in triangles.iter_mut().filter(|t| t.iter().map(|&v| positions[v as usize].x).sum::<f32>() > 1.5) {
        t.swap(0, 1);
    }
    let (rest, _) = RestShape::build(&mesh).expect("a sheet with two fronts");
    // Not edge on edge.
    let folded = rest.positions.iter().map(|&p| if p.x > 0.5 { vec3(0.965 - 0.93 * p.x, 0.0, 0.97 * p.z) } else { p });
    assert!(assert_same(&rest, &roughened(folded, 0.1 / (n - 1) as f32), "fold") > 100);
}

/// A sheet with a slit along its middle, as wide as `gap` [m] where it opens.
fn slit(n: u32, gap: f32) -> SourceMesh {
    let mut mesh = flat(n);
    // Doubles the middle row on the left half: the faces above it get particles of their own.
    let middle = n / 2;
    let first = mesh.positions.len() as u32;
    for i in 0..middle {
        mesh.positions.push(mesh.positions[(i * n + middle) as usize]);
    }
    let own = |v: u32| if v % n == middle && v / n < middle { first + v / n } else { v };
    let SourceMesh { positions, triangles, .. } = &mut mesh;
    for t in triangles.iter_mut() {
        if t.iter().any(|&v| v < first && v % n > middle) {
            *t = t.map(own);
        }
    }
    // Apart at rest, or they would be welded.
    for i in 0..middle {
        positions[(first + i) as usize].z += gap * (middle - i) as f32 / middle as f32;
    }
    mesh
}

/// Both flaps of a slit overlap by bending in the plane, one of them tilted through the other.
fn crossed_flaps(p: Vec3) -> Vec3 {
    let upper = p.z > 0.5 + 1.0e-4 || (p.z > 0.5 && p.x < 0.45);
    let reach = (0.5 - p.x).max(0.0);
    let tilt = 0.25 * (p.x - 0.2);
    let slide = 0.3 * reach * reach;
    if upper { p + vec3(0.0, tilt * reach, -slide) } else { p + vec3(0.0, -tilt * reach, slide) }
}

#[test]
fn flaps_at_a_slit_are_seen() {
    let n = 17;
    // A hem that hangs down makes the sheet one side of the box around all: its slit lies in that side, but not along it.
    let hemmed = sheet_with_strip(slit(n, 0.008), n, n - 1, |row, v| vec3(1.0, -(row as f32) / (n - 1) as f32, v));
    for (name, mesh) in [("slit", slit(n, 0.008)), ("slit in a cloth with a hem", hemmed)] {
        let (rest, _) = RestShape::build(&mesh).expect("a sheet with a slit");
        let positions: Vec<Vec4> = rest.positions.iter().map(|&p| crossed_flaps(p).extend(1.0)).collect();
        let crossings = assert_same(&rest, &positions, name);
        assert!(crossings > 0, "{name}: the flaps should cross");
        assert_eq!(seen_with_contacts(&rest, &positions), crossings, "{name}");
    }
}

/// Around its end a slit leaves faces that share a particle, hardly bend, and cross each other all the same.
#[test]
fn faces_that_cross_beside_the_end_of_a_slit_are_seen() {
    // A disc with a slit from its rim to its centre, both sides of which are lifted and drawn over each other.
    let fan = |overlap: f32, lift: f32| {
        let rim = (0..=8u8).map(|k| {
            let is_end = k % 8 == 0;
            let angle = f32::from(k) * TAU / 8.0 + if is_end { overlap.copysign(f32::from(k) - 4.0) } else { 0.0 };
            let y = if is_end { lift } else { 0.0 };
            let radius = 1.0 + 0.01 * f32::from(k);
            vec3(radius * angle.cos(), y, radius * angle.sin())
        });
        let positions = core::iter::once(Vec3::ZERO).chain(rim).collect();
        SourceMesh { positions, triangles: (1..=8).map(|k| [0, k + 1, k]).collect(), ..SourceMesh::default() }
    };
    let (rest, _) = RestShape::build(&fan(-0.05, 0.0)).expect("a disc with a slit");
    let crossed = fan(0.25, 0.05).positions;
    let at_rest = fan(-0.05, 0.0).positions;
    let same = |x: &Vec3| at_rest.iter().position(|y| y.distance(*x) < 1.0e-4).expect("a vertex");
    let positions: Vec<Vec4> = rest.positions.iter().map(|x| crossed[same(x)].extend(1.0)).collect();
    let crossings = assert_same(&rest, &positions, "end of a slit");
    assert!(crossings > 0);
    assert_eq!(seen_with_contacts(&rest, &positions), crossings);
}

/// Crossings that are found in the same walk as what may touch.
fn seen_with_contacts(rest: &RestShape, positions: &[Vec4]) -> usize {
    let mut cloth = SceneCloth::new(Arc::new(rest.clone()), Fabric { thickness: 0.005, ..Fabric::default() }, Vec3::ZERO, &[]);
    cloth.sim.state =
        ClothState { positions: positions.to_vec(), previous: positions.to_vec(), substep: 0.01, ..ClothState::default() };
    let settings = UntangleSettings { iterations: 0, ..UntangleSettings::default() };
    let scene = Scene::new(vec![cloth]).untangled(settings, EvaluateSettings::default(), true);
    let mut scene = scene.expect("one cloth");
    scene.finish_frame(0.01);
    let island = &scene.untangle.as_ref().expect("untangled").island;
    island.crossings().iter().filter(|c| !c.touching).count()
}
