//! Where sheets face along contours.

use glam::Vec3;

use super::contour::ContourGraph;
use super::separation::{Member, nodes};
use super::view::View;

/// Least length of the mean unit normal of a side along contours that one direction may undo (dimensionless). Normals within
/// 80° of the mean have about that. All around a tube it is zero, and a direction that brings one flank of it in drives the
/// other one out.
pub(super) const ONE_WAY: f32 = 0.7;

/// Where a side faces at each crossing of some contours.
pub(super) fn facing_at<'a>(
    view: View<'a>,
    graph: &'a ContourGraph,
    set: &'a [Member],
    side: usize,
) -> impl Iterator<Item = Vec3> + 'a {
    nodes(graph, set).map(move |(i, of_edge)| {
        let c = &view.crossings[i];
        view.facing(if of_edge == side { view.surface.topology.edge_faces[c.edge as usize][0] } else { c.face })
    })
}

/// Mean of unit normals, shorter the less they agree; zero of none.
pub(super) fn mean(normals: impl Iterator<Item = Vec3>) -> Vec3 {
    let (sum, count) = normals.fold((Vec3::ZERO, 0), |(sum, count), normal| (sum + normal, count + 1));
    sum / f32::max(count as f32, 1.0)
}

/// How much the sides of some contours face the same way where they cross: 1, or the opposite way, -1 (dimensionless).
pub(super) fn agreement(view: View<'_>, graph: &ContourGraph, set: &[Member]) -> f32 {
    let [mine, theirs] = [0, 1].map(|side| facing_at(view, graph, set, side));
    let (sum, count) = mine.zip(theirs).fold((0.0, 0), |(sum, count), (n, m)| (sum + n.dot(m), count + 1));
    sum / f32::max(count as f32, 1.0)
}
