//! How the length of a contour changes when its surfaces move (Volino and Magnenat-Thalmann 2006; Wen et al. 2009).
//!
//! An edge with unit direction `E` crosses a face with unit normal `N`. Each face `i` at the edge starts a segment of the
//! contour. Its unit direction `Rᵢ` points from the crossing into that face:
//!
//! ```text
//!   Rᵢ = ± N × Mᵢ / |N × Mᵢ|         Mᵢ normal of face i, sign from the in-plane inward normal
//!   R  = Σ Rᵢ                         S = Σ (E·Rᵢ)/(E·N) N
//!   G  = R - 2 S                      the edge moves along +G, the face along -G;  dL = -½ Σ G·D for a relative shift D
//!
//!   ∂L/∂a = -(1-t)(R - S)    ∂L/∂b = -t (R - S)    ∂L/∂cⱼ = -wⱼ S         edge (a, b), face corners cⱼ
//! ```
//!
//! Near parallel `1/(E·N)` explodes: it is replaced by `(E·N)/((E·N)² + bound²)`, and `Rᵢ` is dropped where `|N × Mᵢ| < 10⁻⁶`.

use glam::DVec3;

use crate::solver::detect::Crossing;
use crate::solver::topology::{NONE, Topology};

/// Bound of `E·N` near parallel.
pub(crate) const BOUND: f64 = 0.05;

/// The gradient's ingredients at one crossing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Terms {
    /// The crossing `[m]`, on the edge.
    pub point: DVec3,
    /// Unit normal of the face.
    pub normal: DVec3,
    /// Sum of the directions of the segments that start here.
    pub r: DVec3,
    /// Share of the face's tilt, along its normal.
    pub s: DVec3,
}

impl Terms {
    /// Evaluates one crossing; `at` gives the positions `[m]`. `bound` is `BOUND` except where the exact derivative is wanted
    /// (0).
    #[must_use]
    pub fn new(topology: &Topology, crossing: &Crossing, bound: f64, at: impl Fn(u32) -> DVec3) -> Self {
        let [a, b] = topology.edges[crossing.edge as usize].map(&at);
        let [p, q, r] = topology.faces[crossing.face as usize].map(&at);
        let normal = (q - p).cross(r - p).normalize_or_zero();
        let edge = (b - a).normalize_or_zero();
        let slope = edge.dot(normal);
        let tilt = slope / (slope * slope + bound * bound);
        let tilt = if tilt.is_finite() { tilt } else { 0.0 };
        let mut terms = Self { point: a + f64::from(crossing.t) * (b - a), normal, ..Self::default() };
        for face in topology.edge_faces[crossing.edge as usize] {
            if face == NONE {
                continue;
            }
            let [x, y, z] = topology.faces[face as usize].map(&at);
            let line = normal.cross((y - x).cross(z - x).normalize_or_zero());
            let length = line.length();
            if length < 1.0e-6 {
                continue;
            }
            let into = at(topology.opposite(crossing.edge, face)) - a;
            let into = into - into.dot(edge) * edge;
            let r = if line.dot(into) < 0.0 { line / -length } else { line / length };
            terms.r += r;
            terms.s += edge.dot(r) * tilt * normal;
        }
        terms
    }

    /// `G`: along it the edge moves, against it the face.
    #[must_use]
    pub fn pull(&self) -> DVec3 {
        self.r - 2.0 * self.s
    }
}
