//! A convex hull of few points around many.
//!
//! The hull begins with four corners that are far apart. As in quickhull (Barber 1996), it then takes in the corner that sticks
//! out most, again and again. It ends early.

use glam::Vec3;
use parry3d::query::PointQuery;
use parry3d::shape::{ConvexPolyhedron, SharedShape};

use crate::solver::body::shape::convex_hull;

/// A convex hull that lies within that of all points.
pub(super) struct Hull(SharedShape);

impl Hull {
    /// None for points that span no volume.
    pub(super) fn around(points: &[Vec3], most: usize) -> Option<Self> {
        let whole = Self::of(points)?;
        let corners = whole.polyhedron()?.points();
        if corners.len() <= most {
            return Some(whole);
        }
        let mut chosen = far_apart(corners)?;
        let mut hull = Self::of(&chosen)?;
        while chosen.len() < most {
            let polyhedron = hull.polyhedron()?;
            let (corner, height) = farthest(corners, |p| height(polyhedron, p))?;
            if height <= 0.0 {
                break;
            }
            chosen.push(corner);
            // Of corners that are too near each other for a hull, what was found so far is good.
            let Some(larger) = Self::of(&chosen) else {
                break;
            };
            hull = larger;
        }
        Some(hull)
    }

    /// The convex hull of points.
    pub(super) fn of(points: &[Vec3]) -> Option<Self> {
        let hull = Self(convex_hull(points).ok()?);
        hull.polyhedron().is_some().then_some(hull)
    }

    /// Its corners `[m]`.
    pub(super) fn corners(&self) -> &[Vec3] {
        self.polyhedron().map_or(&[], ConvexPolyhedron::points)
    }

    /// How far a point sticks out `[m]`; 0 inside.
    pub(super) fn outside(&self, point: Vec3) -> f32 {
        match self.polyhedron() {
            Some(polyhedron) if height(polyhedron, point) > 0.0 => polyhedron.distance_to_local_point(point, true),
            _ => 0.0,
        }
    }

    fn polyhedron(&self) -> Option<&ConvexPolyhedron> {
        self.0.as_convex_polyhedron()
    }
}

/// Height over the face that a point is highest above `[m]`; negative inside.
fn height(polyhedron: &ConvexPolyhedron, point: Vec3) -> f32 {
    let corner = |face: usize| {
        let first = polyhedron.faces().get(face).map(|face| face.first_vertex_or_edge as usize)?;
        polyhedron.points().get(*polyhedron.vertices_adj_to_face().get(first)? as usize).copied()
    };
    let over = |(i, normal): (usize, Vec3)| corner(i).map_or(f32::MIN, |corner| normal.dot(point - corner));
    polyhedron.faces().iter().map(|face| face.normal).enumerate().map(over).fold(f32::MIN, f32::max)
}

/// Four corners that span a large volume.
fn far_apart(corners: &[Vec3]) -> Option<Vec<Vec3>> {
    let middle = corners.iter().copied().sum::<Vec3>() / corners.len() as f32;
    let (a, _) = farthest(corners, |p| p.distance_squared(middle))?;
    let (b, _) = farthest(corners, |p| p.distance_squared(a))?;
    let along = (b - a).try_normalize()?;
    let (c, _) = farthest(corners, |p| (p - a).reject_from_normalized(along).length_squared())?;
    let normal = along.cross(c - a).try_normalize()?;
    let (d, _) = farthest(corners, |p| (p - a).dot(normal).abs())?;
    Some(vec![a, b, c, d])
}

/// The point of the largest measure, and that.
fn farthest(points: &[Vec3], measure: impl Fn(Vec3) -> f32) -> Option<(Vec3, f32)> {
    points.iter().map(|&p| (p, measure(p))).max_by(|(_, a), (_, b)| a.total_cmp(b))
}
