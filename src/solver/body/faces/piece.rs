//! Pieces of a face: edges are looked at by themselves, and so is what lies between them.

use super::setting::Setting;
use crate::solver::body::nearest::Face;

/// Pieces of a face: its edges, and itself.
pub(super) const PIECES: u32 = 4;
/// Least weight of every corner of a face that is touched between its edges (dimensionless).
const WITHIN: f32 = 0.02;
/// How far from its edges a face is touched between them, at least, in distances that it keeps (dimensionless): they reach
/// farther than that.
const OWN: f32 = 0.5;

/// What of a face is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) enum Piece {
    /// One of its edges, by number: a face whose third corner is its second.
    Edge(u8),
    /// What lies between its edges.
    Within,
    /// All of it.
    Whole,
}

impl Piece {
    /// Those of the three particles that count.
    pub(super) fn of(self, particles: &[u32; 3]) -> &[u32] {
        if let Self::Edge(_) = self { &particles[..2] } else { particles }
    }

    /// Weights of its middle.
    pub(super) fn middle(self) -> [f32; 3] {
        if let Self::Edge(_) = self { [0.5, 0.5, 0.0] } else { [1.0 / 3.0; 3] }
    }

    /// Its place among the pieces of all faces.
    pub(super) fn place(self, face: u32) -> u32 {
        PIECES * face + if let Self::Edge(k) = self { u32::from(k) } else { PIECES - 1 }
    }
}

/// Whether a point of a face lies between its edges.
pub(super) fn is_within(weights: &[f32; 3]) -> bool {
    weights.iter().all(|w| *w > WITHIN)
}

impl Setting<'_> {
    /// Whether a touch is for a piece to take. The piece between edges takes only touches that are farther from each edge than
    /// the edge itself reaches.
    pub(super) fn takes(&self, piece: Piece, weights: &[f32; 3], face: &Face) -> bool {
        let area = (face[1] - face[0]).cross(face[2] - face[0]).length();
        piece != Piece::Within
            || (0..3).all(|i| {
                let edge = (face[(i + 1) % 3] - face[(i + 2) % 3]).length();
                // wᵢ times the height over an edge is the distance from it.
                weights[i] > WITHIN || weights[i] * area > OWN * self.keep * edge
            })
    }
}
