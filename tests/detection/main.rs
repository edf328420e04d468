//! The detector against a checker that shares no code with it.

mod checker;

use bevy_drape::scenes;
use bevy_drape::solver::detect::{Detector, PartRef, Surface};
use bevy_drape::solver::rest::{RestShape, SourceMesh};
use glam::{Vec3, Vec4, vec3};

fn assert_same(rest: &RestShape, positions: &[Vec4], what: &str) -> usize {
    let (topology, rest) = (&rest.topology, &rest.positions);
    let surface =
        Surface::new(&[PartRef { topology, rest, layer: 0, self_collision: true, thickness: 0.005 }]).expect("one cloth");
    let mut detector = Detector::new(&surface);
    let found = detector.detect(&surface, positions).iter().filter(|c| !c.touching);
    let mut found: Vec<([u32; 2], u32)> = found.map(|c| (topology.edges[c.edge as usize], c.face)).collect();
    found.iter_mut().for_each(|(edge, _)| edge.sort_unstable());
    found.sort_unstable();
    let points: Vec<Vec3> = positions.iter().map(|x| x.truncate()).collect();
    let expected = checker::crossings(&points, &topology.faces);
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
                crossings += assert_same(&cloth.rest, &cloth.state.positions, &format!("{name}, frame {frame}"));
                looks += 1;
            }
        }
    }
    assert!(crossings > 1000, "{crossings} crossings in {looks} looks: these sheets should cross themselves");
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

/// A sheet with a slit along its middle, the two flaps of which bend through each other.
#[test]
fn flaps_at_a_slit_are_seen() {
    let n = 17;
    let mut mesh = scenes::grid(n, n, |u, v| vec3(u, 0.0, v));
    // Doubles the middle row on the left half: the faces above it get particles of their own.
    let middle = n / 2;
    let first = mesh.positions.len() as u32;
    for i in 0..middle {
        mesh.positions.push(mesh.positions[(i * n + middle) as usize]);
    }
    let own = |v: u32| if v % n == middle && v / n < middle { first + v / n } else { v };
    let SourceMesh { positions, triangles } = &mut mesh;
    for t in triangles.iter_mut() {
        if t.iter().any(|&v| v < first && v % n > middle) {
            *t = t.map(own);
        }
    }
    // Apart at rest, or they would be welded.
    for i in 0..middle {
        positions[(first + i) as usize].z += 1.0e-3 * (middle - i) as f32;
    }
    let (rest, _) = RestShape::build(&mesh).expect("a sheet with a slit");
    // Both flaps overlap by bending in the plane, one of them tilted through the other.
    let bent = |p: Vec3| {
        let upper = p.z > 0.5 + 1.0e-4 || (p.z > 0.5 && p.x < 0.45);
        let reach = (0.5 - p.x).max(0.0);
        let tilt = 0.25 * (p.x - 0.2);
        let slide = 0.3 * reach * reach;
        if upper { vec3(p.x, tilt * reach, p.z - slide) } else { vec3(p.x, -tilt * reach, p.z + slide) }
    };
    let positions: Vec<Vec4> = rest.positions.iter().map(|&p| bent(p).extend(1.0)).collect();
    let crossings = assert_same(&rest, &positions, "slit");
    assert!(crossings > 0, "the flaps should cross");
}
