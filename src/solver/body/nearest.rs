//! The point of a face that is nearest to a convex part of a body.
//!
//! ```text
//!  ball, capsule   closest points of the face and of the part's core, a point or a segment
//!  other convex    closest points of face and part (GJK)
//!  ──►  weights w of the face's particles, p = Σ wᵢ xᵢ, and the part's own distance and normal at p
//! ```
//!
//! Only where something is between them does a direction come of it: a face that the part has gone through has no nearest
//! point. An edge is a face whose third corner is its second, which then has no weight.

use glam::{Vec3, Vec3A};
use parry3d::math::Pose;
use parry3d::query::gjk::{CsoPoint, GJKResult, VoronoiSimplex, closest_points};
use parry3d::shape::{Segment, SupportMap, Triangle};

use super::distance::Sample;
use super::geometry::Geometry;
use crate::solver::detect::proximity::{closest_edges, vertex_face};

/// Projections in turn after GJK, at most.
const PROJECTIONS: u32 = 3;

/// Corners of a face in the part's own space `[m]`.
pub(super) type Face = [Vec3A; 3];

/// The nearest point of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Near {
    /// Share of each corner (dimensionless).
    pub(super) weights: [f32; 3],
    pub(super) point: Vec3A,
    /// Distance and normal of the part there.
    pub(super) sample: Sample,
}

impl Near {
    /// Whether it lies outside the part.
    pub(super) fn is_outside(&self) -> bool {
        self.sample.distance > 0.0
    }
}

/// `Σ wᵢ xᵢ`.
#[inline]
pub(super) fn at(face: &Face, weights: &[f32; 3]) -> Vec3A {
    face[0] * weights[0] + face[1] * weights[1] + face[2] * weights[2]
}

/// A convex part of a body.
#[derive(Clone, Copy)]
pub(super) struct Convex<'a> {
    pub(super) geometry: Geometry<'a>,
    /// The same for GJK.
    pub(super) support: Option<&'a dyn SupportMap>,
}

impl Convex<'_> {
    /// `None`: the part, or its core, goes through the face. `towards`: about where the face lies.
    #[inline]
    pub(super) fn nearest(&self, face: &Face, towards: Vec3A) -> Option<Near> {
        let weights = match self.geometry {
            Geometry::Ball { .. } => to_point(face, Vec3A::ZERO).0,
            Geometry::Capsule { a, ab, .. } => to_segment(face, a, ab)?,
            _ => return self.refined(face, to_support(face, self.support?, towards)?),
        };
        self.near(face, weights)
    }

    fn near(&self, face: &Face, weights: [f32; 3]) -> Option<Near> {
        let point = at(face, &weights);
        let sample = self.geometry.sample(point, f32::MAX);
        (sample.normal != Vec3A::ZERO && sample.distance.is_finite()).then_some(Near { weights, point, sample })
    }

    /// The closest point by GJK, which stops early at round shapes, after alternating projections onto part and face. These
    /// approach the closest points of any two convex sets.
    fn refined(&self, face: &Face, weights: [f32; 3]) -> Option<Near> {
        let mut best = self.near(face, weights)?;
        for _ in 0..PROJECTIONS {
            let foot = best.point - best.sample.normal * best.sample.distance;
            let next = self.near(face, to_point(face, foot).0)?;
            if next.sample.distance >= 0.999 * best.sample.distance {
                break;
            }
            best = next;
        }
        Some(best)
    }
}

/// Whether a face is an edge.
#[inline]
fn is_edge(face: &Face) -> bool {
    face[1] == face[2]
}

/// Weights of the face's closest point to `p`, and its distance `[m]`.
#[inline]
pub(super) fn to_point(face: &Face, p: Vec3A) -> ([f32; 3], f32) {
    if is_edge(face) {
        let [a, b, _] = *face;
        let (ab, ap) = (b - a, p - a);
        let length2 = ab.length_squared();
        let t = if length2 > 0.0 { (ap.dot(ab) / length2).clamp(0.0, 1.0) } else { 0.0 };
        return ([1.0 - t, t, 0.0], (ap - ab * t).length());
    }
    let points = [p, face[0], face[1], face[2]];
    let near = vertex_face([0, 1, 2, 3], |i| points[i as usize].into());
    let [_, a, b, c] = near.weights;
    ([-a, -b, -c], near.distance)
}

/// Weights of the face's closest point to the segment from `a` to `a + ab`; none where they cross.
fn to_segment(face: &Face, a: Vec3A, ab: Vec3A) -> Option<[f32; 3]> {
    let [x, y, z] = *face;
    let b = a + ab;
    let across = (y - x).cross(z - x);
    let (over, under) = (across.dot(a - x), across.dot(b - x));
    if over * under < 0.0 {
        let crossing = a + ab * (over / (over - under));
        let (_, distance) = to_point(face, crossing);
        if distance < 1.0e-6 + 1.0e-6 * crossing.length() {
            return None;
        }
    }
    let (mut best, mut least) = to_point(face, a);
    let (weights, distance) = to_point(face, b);
    if distance < least {
        (best, least) = (weights, distance);
    }
    for k in 0..3 {
        let (from, to) = (k, (k + 1) % 3);
        let points = [face[from], face[to], a, b];
        let near = closest_edges([0, 1, 2, 3], |i| points[i as usize].into());
        if near.distance < least {
            least = near.distance;
            best = [0.0; 3];
            (best[from], best[to]) = (near.weights[0], near.weights[1]);
        }
    }
    Some(best)
}

/// Weights of the face's closest point to a convex shape; none where they overlap.
fn to_support(face: &Face, shape: &dyn SupportMap, towards: Vec3A) -> Option<[f32; 3]> {
    let [a, b, c] = face.map(Vec3::from);
    let (edge, triangle) = (Segment::new(a, b), Triangle::new(a, b, c));
    let cloth: &dyn SupportMap = if is_edge(face) { &edge } else { &triangle };
    let mut simplex = VoronoiSimplex::new();
    let start = Vec3::from(towards).try_normalize().unwrap_or(Vec3::Y);
    simplex.reset(CsoPoint::from_shapes(&Pose::IDENTITY, shape, cloth, start));
    match closest_points(&Pose::IDENTITY, shape, cloth, f32::MAX, true, &mut simplex) {
        GJKResult::ClosestPoints(_, nearest, _) if nearest.is_finite() => Some(to_point(face, nearest.into()).0),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::body::shape;

    #[test]
    fn no_sampled_point_of_a_face_is_nearer_by_two_hundredths_than_the_nearest() {
        let shapes = [
            ("ball", shape::ball(0.1)),
            ("capsule", shape::capsule(0.05, 0.3)),
            ("cuboid", shape::cuboid(Vec3::new(0.3, 0.1, 0.2))),
            ("cylinder", shape::cylinder(0.2, 0.2)),
            ("cone", shape::cone(0.012, 0.15)),
            ("hull", shape::convex_hull(&[Vec3::ZERO, Vec3::X * 0.4, Vec3::Y * 0.3, Vec3::Z * 0.2, Vec3::ONE * 0.2])),
        ];
        let mut rng = fastrand::Rng::with_seed(3);
        for (name, shape) in shapes {
            let shape = shape.unwrap();
            let mut planes = Vec::new();
            if let Some(polyhedron) = shape.as_convex_polyhedron() {
                super::super::geometry::hull_planes(polyhedron, &mut planes);
            }
            let part = Convex { geometry: Geometry::of(&*shape.0, &planes), support: shape.as_support_map() };
            let mut apart = 0;
            for n in 0..3000 {
                let mut corner = |size: f32| (Vec3A::new(rng.f32(), rng.f32(), rng.f32()) - 0.5) * size;
                let middle = corner(0.7);
                let face = [middle + corner(0.2), middle + corner(0.2), middle + corner(0.2)];
                let found = part.nearest(&face, middle);
                let mut least = f32::MAX;
                for i in 0..=20 {
                    for j in 0..=20 - i {
                        let (a, b) = (i as f32 / 20.0, j as f32 / 20.0);
                        least = least.min(part.geometry.sample(at(&face, &[a, b, 1.0 - a - b]), f32::MAX).distance);
                    }
                }
                let deep = matches!(name, "ball" | "capsule");
                match found {
                    Some(near) if near.is_outside() || deep => {
                        apart += 1;
                        let found = near.sample.distance;
                        assert!(found < least + 0.02 * least.abs() + 2.0e-4, "{name} {n}: found {found}, sampled {least}");
                    }
                    _ => assert!(least < 0.01, "{name} {n}: {least} m apart, and taken for overlapping"),
                }
            }
            assert!(apart > 1000, "{name}: {apart} faces apart");
        }
    }
}
