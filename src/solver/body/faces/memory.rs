//! What is known of a face from one substep and one frame to the next: on which side of a part it belongs.

use glam::{Vec3, Vec3A};

use super::Candidate;
use super::piece::{Piece, is_within};
use crate::solver::body::feature_edges::FeatureEdge;
use crate::solver::body::nearest::{Face, Near};

impl Candidate {
    /// Notes where the face is outside.
    pub(super) fn lies(&mut self, near: &Near, face: &Face) {
        self.side = near.sample.normal.into();
        if !matches!(self.piece, Piece::Edge(_)) && is_within(&near.weights) {
            self.over = near.sample.normal.dot(normal(face)).signum();
        }
    }

    /// Notes that the face is in front of the part, and that its corners may go as far as `clear` `[m]` from here.
    pub(super) fn pass_by(&mut self, normal: Vec3A, clear: f32, corners: &Face) {
        if normal != Vec3A::ZERO {
            self.side = normal.into();
        }
        self.over = 0.0;
        (self.clear, self.corners) = (clear, corners.map(Vec3::from));
    }
}

/// Passes on the memory of faces that stay. Both lists are in the order of feature edges, edges before what is between them,
/// and faces.
pub(super) fn remember(
    (before, feature_edges_before): (&[Candidate], &[FeatureEdge]),
    (first, end): (u32, u32),
    now: &mut [Candidate],
    feature_edges: &[FeatureEdge],
) {
    let key = |c: &Candidate, feature_edges: &[FeatureEdge]| {
        (feature_edges.get(c.feature_edge as usize).map(FeatureEdge::key), c.piece >= Piece::Within, c.face, c.piece)
    };
    let mut before = before.get(first as usize..end as usize).unwrap_or(&[]).iter().peekable();
    for candidate in now {
        let wanted = key(candidate, feature_edges);
        while before.next_if(|old| key(old, feature_edges_before) < wanted).is_some() {}
        if let Some(old) = before.next_if(|old| key(old, feature_edges_before) == wanted) {
            // The part may have become another one, or grown.
            let clear = f32::NEG_INFINITY;
            *candidate = Candidate {
                particles: candidate.particles,
                feature_edge: candidate.feature_edge,
                clear,
                left_out: false,
                ..*old
            };
        }
    }
}

/// Unit normal; zero without area.
pub(super) fn normal(face: &Face) -> Vec3A {
    (face[1] - face[0]).cross(face[2] - face[0]).normalize_or_zero()
}
