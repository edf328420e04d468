//! Pieces of a face: edges are looked at by themselves, and so is what lies between them.

/// Pieces of a face: its edges, and itself.
pub(super) const PIECES: u32 = 4;
/// Least weight of every corner of a face that is touched between its edges (dimensionless).
const WITHIN: f32 = 0.02;

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

    /// Whether a touch at these weights is for it to take: what is between edges takes none on them.
    pub(super) fn takes(self, weights: &[f32; 3]) -> bool {
        self != Self::Within || is_within(weights)
    }
}

/// Whether a point of a face lies between its edges.
pub(super) fn is_within(weights: &[f32; 3]) -> bool {
    weights.iter().all(|w| *w > WITHIN)
}
