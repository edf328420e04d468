//! Fitted colliders of a figure of tapered limbs, and of what no modeller should hand over.

use std::f32::consts::TAU;

use glam::{Affine3A, Quat, Vec3};

use super::hull::Hull;
use super::{BoneCollider, BoneShape, FitSettings, SkinnedBody, fit, measure};
use crate::solver::body::shape;

/// A body that owns what [`SkinnedBody`] borrows.
#[derive(Clone, Default)]
struct Figure {
    positions: Vec<Vec3>,
    joints: Vec<[u16; 4]>,
    weights: Vec<[f32; 4]>,
    inverse_binds: Vec<Affine3A>,
    parents: Vec<Option<usize>>,
    unit: f32,
}

const PELVIS: usize = 1;
const CHEST: usize = 2;
const HEAD: usize = 3;
const THIGH: usize = 4;
const CALF: usize = 5;
const ARM: usize = 6;
const HAND: usize = 7;
const FINGER: usize = 8;

impl Figure {
    /// A figure of 1.8 m: a root without vertices, pelvis, flat chest, head, one leg, one arm with a finger.
    fn new() -> Self {
        let mut figure = Self { unit: 1.0, ..Self::default() };
        let joints = [
            (None, Vec3::ZERO),
            (Some(0), Vec3::new(0.0, 0.95, 0.0)),
            (Some(PELVIS), Vec3::new(0.0, 1.15, 0.0)),
            (Some(CHEST), Vec3::new(0.0, 1.5, 0.0)),
            (Some(PELVIS), Vec3::new(0.1, 0.9, 0.0)),
            (Some(THIGH), Vec3::new(0.1, 0.48, 0.0)),
            (Some(CHEST), Vec3::new(0.2, 1.42, 0.0)),
            (Some(ARM), Vec3::new(0.72, 1.42, 0.0)),
            (Some(HAND), Vec3::new(0.8, 1.42, 0.0)),
        ];
        for (parent, place) in joints {
            figure.parents.push(parent);
            // Joints do not stand as the mesh does.
            let turn = Quat::from_axis_angle(Vec3::new(1.0, 2.0, 0.5).normalize(), figure.parents.len() as f32);
            figure.inverse_binds.push(Affine3A::from_rotation_translation(turn, place).inverse());
        }
        let y = |x: f32, y: f32| Vec3::new(x, y, 0.0);
        figure.limb(PELVIS, [y(0.0, 0.85), y(0.0, 1.15)], [0.12, 0.12], 1.0);
        figure.limb(CHEST, [y(0.0, 1.12), y(0.0, 1.48)], [0.18, 0.2], 0.3);
        figure.limb(HEAD, [y(0.0, 1.5), y(0.0, 1.8)], [0.09, 0.09], 1.0);
        figure.limb(THIGH, [y(0.1, 0.9), y(0.1, 0.5)], [0.09, 0.065], 1.0);
        figure.limb(CALF, [y(0.1, 0.48), y(0.1, 0.0)], [0.06, 0.04], 1.0);
        figure.limb(ARM, [y(0.2, 1.42), y(0.72, 1.42)], [0.05, 0.04], 1.0);
        figure.limb(HAND, [y(0.72, 1.42), y(0.8, 1.42)], [0.04, 0.04], 1.0);
        figure.limb(FINGER, [y(0.8, 1.42), y(0.88, 1.42)], [0.01, 0.01], 1.0);
        figure
    }

    /// A closed, tapered cylinder that one joint moves, and a neighbour a little; `depth` squeezes it along z.
    fn limb(&mut self, joint: usize, [from, to]: [Vec3; 2], radii: [f32; 2], depth: f32) {
        let axis = (to - from).normalize();
        let (u, v) = axis.any_orthonormal_pair();
        for ring in 0..=20 {
            let share = ring as f32 / 20.0;
            let radius = radii[0] + (radii[1] - radii[0]) * share;
            for corner in 0..16 {
                let turn = corner as f32 / 16.0 * TAU;
                let across = (u * turn.cos() + v * turn.sin()) * radius;
                self.positions.push(from.lerp(to, share) + across * Vec3::new(1.0, 1.0, depth));
                self.joints.push([0, joint as u16, 0, 0]);
                self.weights.push([0.2, 0.8, 0.0, 0.0]);
            }
        }
    }

    fn body(&self) -> SkinnedBody<'_> {
        SkinnedBody {
            positions: &self.positions,
            joints: &self.joints,
            weights: &self.weights,
            inverse_binds: &self.inverse_binds,
            parents: &self.parents,
            unit: self.unit,
        }
    }

    fn fitted(&self) -> Vec<BoneCollider> {
        fit(&self.body(), &FitSettings::default())
    }
}

/// Ends and radius of a capsule in the space of the mesh `[m]`.
fn capsule(figure: &Figure, colliders: &[BoneCollider], joint: usize) -> (Vec3, Vec3, f32) {
    let collider = colliders.iter().find(|c| c.joint == joint).unwrap_or_else(|| panic!("joint {joint} has no collider"));
    let BoneShape::Capsule { a, b, radius } = collider.shape else {
        panic!("joint {joint} has no capsule: {:?}", collider.shape);
    };
    let bone = figure.inverse_binds[joint].inverse();
    let place = |p: Vec3| bone.transform_point3(p) * figure.unit;
    (place(a), place(b), radius * collider.unit)
}

fn joints(colliders: &[BoneCollider]) -> Vec<usize> {
    colliders.iter().map(|c| c.joint).collect()
}

/// Everything of a collider is a number, and the solver takes its shape.
fn assert_sound(colliders: &[BoneCollider], what: &str) {
    for collider in colliders {
        let shape = match &collider.shape {
            &BoneShape::Capsule { a, b, radius } => shape::capsule_between(a, b, radius),
            BoneShape::Hull { points } => shape::convex_hull(points),
        };
        assert!(shape.is_ok(), "{what}: {:?} of {collider:?}", shape.err());
        let numbers = [collider.margin, collider.unit, collider.outside.p50, collider.outside.max];
        assert!(numbers.iter().all(|n| n.is_finite() && *n >= 0.0), "{what}: {collider:?}");
    }
}

#[test]
fn limbs_get_capsules_along_their_bones() {
    let figure = Figure::new();
    let colliders = figure.fitted();
    for (joint, axis, radii, length) in [
        (HEAD, Vec3::Y, 0.08..0.095, 0.3),
        (THIGH, Vec3::Y, 0.065..0.09, 0.4),
        (CALF, Vec3::Y, 0.04..0.06, 0.48),
        // With the hand and the finger.
        (ARM, Vec3::X, 0.035..0.05, 0.68),
    ] {
        let (a, b, radius) = capsule(&figure, &colliders, joint);
        let aligned = (b - a).normalize().dot(axis).abs();
        let whole = a.distance(b) + 2.0 * radius;
        assert!(aligned > 0.999, "joint {joint}: axis {:?}", b - a);
        assert!(radii.contains(&radius), "joint {joint}: radius {radius}, not within {radii:?}");
        // Around flat ends a capsule is longer.
        assert!((0.95 * length..length + 1.5 * radius).contains(&whole), "joint {joint}: {whole} m of {length} m");
    }
    let outside = measure(&figure.body(), &colliders);
    assert!(outside.p95 < 0.015, "{outside:?}");
}

#[test]
fn small_groups_go_to_the_parent_and_strays_get_nothing() {
    let mut figure = Figure::new();
    let strays = figure.positions.len();
    figure.positions.extend([Vec3::ZERO; 3]);
    figure.joints.extend([[0; 4]; 3]);
    figure.weights.extend([[1.0, 0.0, 0.0, 0.0]; 3]);
    let colliders = figure.fitted();
    assert_eq!(joints(&colliders), [PELVIS, CHEST, HEAD, THIGH, CALF, ARM], "the hand and its finger belong to the arm");
    let counted: usize = colliders.iter().map(|c| c.vertices).sum();
    assert_eq!(counted, strays, "vertices of the body, without the three of the root");
    let all = fit(&figure.body(), &FitSettings { least_share: 0.0, ..FitSettings::default() });
    assert_eq!(joints(&all), [PELVIS, CHEST, HEAD, THIGH, CALF, ARM, HAND, FINGER]);
    let one = fit(&figure.body(), &FitSettings { least_share: 1.0, least_vertices: usize::MAX, ..FitSettings::default() });
    assert_eq!(joints(&one), [0], "all there is goes to the root");
}

#[test]
fn a_flat_group_gets_a_hull_of_few_corners() {
    let colliders = Figure::new().fitted();
    let points = |joint: usize| match &colliders.iter().find(|c| c.joint == joint).unwrap().shape {
        BoneShape::Hull { points } => points.len(),
        BoneShape::Capsule { .. } => 0,
    };
    assert!((8..=32).contains(&points(CHEST)), "{} corners", points(CHEST));
    assert_eq!([PELVIS, HEAD, THIGH, CALF, ARM].map(points), [0; 5], "round ones get capsules");
    let figure = Figure::new();
    let coarse = fit(&figure.body(), &FitSettings { flatness: 2.0, hull_vertices: 12, ..FitSettings::default() });
    for collider in &coarse {
        let BoneShape::Hull { points } = &collider.shape else {
            panic!("{collider:?}");
        };
        assert!(points.len() <= 12, "{} corners", points.len());
    }
}

#[test]
fn what_sticks_out_of_a_hull_is_its_distance() {
    let corners: Vec<Vec3> = (0..8).map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32)).collect();
    let hull = Hull::around(&corners, 32).expect("a cube is a hull");
    for (point, distance) in [
        (Vec3::splat(0.5), 0.0),
        (Vec3::new(1.5, 0.5, 0.5), 0.5),
        (Vec3::new(-0.3, 0.5, -0.4), 0.5),
        (Vec3::splat(2.0), 3.0_f32.sqrt()),
    ] {
        assert!((hull.outside(point) - distance).abs() < 1.0e-5, "{point}: {} instead of {distance}", hull.outside(point));
    }
}

#[test]
fn the_margin_covers_nine_vertices_in_ten() {
    let figure = Figure::new();
    for (hulls, margin) in [(0.0, 0.0), (0.0, 0.015), (2.0, 0.0)] {
        let settings = FitSettings { margin, flatness: hulls, hull_vertices: 8, ..FitSettings::default() };
        for collider in fit(&figure.body(), &settings) {
            let group = [collider.clone()];
            let mut own = figure.clone();
            let keep: Vec<usize> = (0..own.positions.len()).filter(|&v| own.joints[v][1] as usize == collider.joint).collect();
            own.positions = keep.iter().map(|&v| own.positions[v]).collect();
            own.joints = vec![[collider.joint as u16; 4]; keep.len()];
            own.weights = vec![[0.25; 4]; keep.len()];
            let outside = measure(&own.body(), &group);
            assert!(collider.margin >= margin, "{collider:?}");
            assert!(collider.margin + 1.0e-5 >= collider.outside.p90, "{collider:?}");
            if collider.vertices == keep.len() {
                assert!((outside.p95 - collider.outside.p95).abs() < 1.0e-5, "measured {outside:?}, said {collider:?}");
                assert!((outside.max - collider.outside.max).abs() < 1.0e-5, "measured {outside:?}, said {collider:?}");
            }
        }
    }
}

#[test]
fn units_change_numbers_and_not_sizes() {
    let figure = Figure::new();
    let usual = figure.fitted();
    // (metres per unit of the mesh, units of the joint per metre): metres, centimetres, FBX with a scale of 100, and a mirrored
    // skeleton.
    for (unit, scale) in
        [(0.01, Vec3::ONE), (1.0, Vec3::splat(100.0)), (100.0, Vec3::splat(0.01)), (1.0, Vec3::new(-2.0, 2.0, 2.0))]
    {
        let mut other = figure.clone();
        other.unit = unit;
        for p in &mut other.positions {
            *p /= unit;
        }
        for bind in &mut other.inverse_binds {
            *bind = Affine3A::from_scale(scale) * *bind * Affine3A::from_scale(Vec3::splat(unit));
        }
        let colliders = other.fitted();
        assert_eq!(joints(&colliders), joints(&usual), "unit {unit}, scale {scale}");
        assert_sound(&colliders, "units");
        for (is, was) in colliders.iter().zip(&usual) {
            assert!((is.unit * scale.x.abs() - 1.0).abs() < 1.0e-4, "{} m per unit at scale {scale}", is.unit);
            assert!((is.margin - was.margin).abs() < 1.0e-4, "margin {} was {}", is.margin, was.margin);
        }
        for joint in [HEAD, THIGH, CALF, ARM] {
            let ((a, b, r), (a0, b0, r0)) = (capsule(&other, &colliders, joint), capsule(&figure, &usual, joint));
            let moved = a.distance(a0).max(b.distance(b0)).max((r - r0).abs());
            assert!(moved < 1.0e-3, "joint {joint} at unit {unit}, scale {scale}: {a} {b} {r}, was {a0} {b0} {r0}");
        }
        let (outside, before) = (measure(&other.body(), &colliders), measure(&figure.body(), &usual));
        assert!((outside.p95 - before.p95).abs() < 1.0e-3, "{outside:?}, was {before:?}");
    }
}

#[test]
fn influences_that_mean_nothing_change_nothing() {
    let figure = Figure::new();
    let usual = figure.fitted();
    let mut other = figure.clone();
    for (joints, weights) in other.joints.iter_mut().zip(&mut other.weights) {
        // Sums of five; a joint that is not there; a weight that is no number; one joint in two slots.
        let [_, joint, ..] = *joints;
        *joints = [joint, 60_000, 0, joint];
        *weights = [1.0, 3.0, f32::NAN, 1.0];
    }
    assert_eq!(other.fitted(), usual);
    let count = other.positions.len();
    other.positions.extend([Vec3::splat(f32::NAN), Vec3::splat(f32::INFINITY), Vec3::splat(1.0e30), Vec3::splat(9.0)]);
    other.joints.extend([[HEAD as u16; 4]; 4]);
    other.weights.extend([[0.25; 4], [0.25; 4], [0.25; 4], [0.0, -1.0, f32::NAN, f32::INFINITY]]);
    assert_eq!(other.fitted(), usual, "{count} vertices count, the others have no place or no weight");
}

#[test]
fn what_a_singular_joint_moves_goes_to_its_parent() {
    let mut figure = Figure::new();
    figure.inverse_binds[CALF] = Affine3A::from_scale(Vec3::new(1.0, 0.0, 1.0));
    figure.inverse_binds[HEAD] = Affine3A::from_scale(Vec3::splat(f32::NAN));
    let colliders = figure.fitted();
    assert_eq!(joints(&colliders), [PELVIS, CHEST, THIGH, ARM]);
    assert_sound(&colliders, "singular");
}

#[test]
fn bodies_without_a_shape_get_a_shape_or_none() {
    let single = |positions: Vec<Vec3>| {
        let count = positions.len();
        let (joints, weights) = (vec![[0; 4]; count], vec![[1.0, 0.0, 0.0, 0.0]; count]);
        Figure { positions, joints, weights, inverse_binds: vec![Affine3A::IDENTITY], parents: vec![None], unit: 1.0 }
    };
    let line = |i: usize| Vec3::X * (i as f32 * 0.01);
    let plane = |i: usize| Vec3::new((i % 10) as f32, 0.0, (i / 10) as f32) * 0.1;
    for (what, figure, count) in [
        ("nothing", Figure::default(), 0),
        ("no vertices", single(Vec::new()), 0),
        ("one vertex", single(vec![Vec3::ONE]), 1),
        ("one place", single(vec![Vec3::ONE; 100]), 1),
        ("a line", single((0..100).map(line).collect()), 1),
        ("a plane", single((0..100).map(plane).collect()), 1),
        ("two places", single((0..100).map(|i| Vec3::Z * (i % 2) as f32).collect()), 1),
        ("a corner", single(vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z]), 1),
        ("no unit", Figure { unit: 0.0, ..Figure::new() }, 0),
        ("no number for a unit", Figure { unit: f32::NAN, ..Figure::new() }, 0),
        ("a negative unit", Figure { unit: -1.0, ..Figure::new() }, 0),
        ("no joints", Figure { inverse_binds: Vec::new(), ..Figure::new() }, 0),
        ("no weights", Figure { weights: Vec::new(), ..Figure::new() }, 0),
        ("no parents", Figure { parents: Vec::new(), ..Figure::new() }, 6),
        ("parents in a cycle", Figure { parents: (1..=9).map(|i| Some(i % 9)).collect(), ..Figure::new() }, 6),
        ("only parents that are not there", Figure { parents: vec![Some(99); 9], ..Figure::new() }, 6),
    ] {
        for flatness in [0.0, 0.4, 2.0] {
            let colliders = fit(&figure.body(), &FitSettings { flatness, ..FitSettings::default() });
            assert_eq!(colliders.len(), count, "{what} at {flatness}: {colliders:?}");
            assert_sound(&colliders, what);
            let outside = measure(&figure.body(), &colliders);
            assert!(outside.max.is_finite(), "{what}: {outside:?}");
        }
    }
}

#[test]
fn settings_out_of_range_are_brought_into_range() {
    let figure = Figure::new();
    let nan = f32::NAN;
    let usual = FitSettings::default();
    let odd = FitSettings { margin: nan, least_share: nan, flatness: nan, ..usual };
    assert_eq!(fit(&figure.body(), &odd), figure.fitted(), "NaN is the default");
    let far = FitSettings { margin: 1.0e9, least_share: 1.0e9, least_vertices: 0, flatness: 1.0e9, hull_vertices: 0 };
    let near = FitSettings { margin: 1.0, least_share: 1.0, least_vertices: 1, flatness: 2.0, hull_vertices: 4 };
    assert_eq!(fit(&figure.body(), &far), fit(&figure.body(), &near));
}

#[test]
fn any_input_at_all_ends_in_sound_colliders() {
    let mut random = fastrand::Rng::with_seed(14);
    let odd = [0.0, -0.0, 1.0, -1.0, 1.0e-30, 1.0e-12, 1.0e9, 1.0e30, f32::MAX, f32::INFINITY, f32::NEG_INFINITY, f32::NAN];
    for round in 0..400 {
        // From tame to wild.
        let wild = round as f32 / 800.0;
        let number = |random: &mut fastrand::Rng| {
            if random.f32() < wild { odd[random.usize(..odd.len())] } else { random.f32() * 2.0 - 1.0 }
        };
        let count = random.usize(1..12);
        let mut figure = Figure { unit: 1.0, ..Figure::default() };
        for _ in 0..random.usize(0..300) {
            let mut vector = || Vec3::new(number(&mut random), number(&mut random), number(&mut random));
            figure.positions.push(vector());
            figure.joints.push(std::array::from_fn(|_| random.u16(..count as u16 + 2)));
            figure.weights.push(std::array::from_fn(|_| number(&mut random)));
        }
        for _ in 0..count {
            let mut columns = [0.0; 12];
            columns.fill_with(|| number(&mut random));
            figure.inverse_binds.push(Affine3A::from_cols_array(&columns));
            figure.parents.push(random.bool().then(|| random.usize(..count + 2)));
        }
        let settings =
            FitSettings { flatness: 2.0 * random.f32(), hull_vertices: random.usize(..40), ..FitSettings::default() };
        let colliders = fit(&figure.body(), &settings);
        for collider in &colliders {
            let numbers = [collider.margin, collider.unit, collider.outside.p50, collider.outside.max];
            assert!(numbers.iter().all(|n| n.is_finite() && *n >= 0.0), "round {round}: {collider:?}");
        }
        assert!(!measure(&figure.body(), &colliders).max.is_nan(), "round {round}");
    }
}
