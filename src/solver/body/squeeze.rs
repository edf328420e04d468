//! Cloth between two parts of bodies that leave no room for it.
//!
//! ```text
//!   part A  │ <- dA -> x <- dB -> │  part B      nA · nB < 0:  kept (dA + dB) / 2 away from both, never more than anywhere else
//! ```
//!
//! Pushed out of one part after the other, it would end up in the first, with loads that hold it there as no friction could.

use glam::{Vec3, Vec3A};

/// Cosine of two normals beyond which something is between the two parts (dimensionless).
pub(super) const OPPOSED: f32 = -0.5;
/// Least distance that is kept between two parts, as a share of what is kept elsewhere (dimensionless).
const CLOSEST: f32 = 0.02;

/// What something is close to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
struct Close {
    /// Number of the substep, from 1; 0: nothing.
    substep: u32,
    part: u32,
    /// In the cloth's frame.
    normal: Vec3,
    /// Distance after the part pushed `[m]`.
    distance: f32,
}

/// Which part each particle, or each face, was last close to.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Squeezes {
    close: Vec<Close>,
    substep: u32,
}

impl Squeezes {
    /// Begins a frame with `parts` parts, numbered anew; with less than two nothing is between them.
    pub(super) fn begin(&mut self, parts: usize, count: usize) {
        self.substep = 0;
        self.close.clear();
        if parts > 1 {
            self.close.resize(count, Close::default());
        }
    }

    /// Begins a substep.
    pub(super) fn advance(&mut self) {
        self.substep += 1;
    }

    /// The distance to keep `[m]` from `part`, `distance` away along its unit normal: `keep`, or half of the room that another
    /// part leaves.
    #[inline]
    pub(super) fn keep(&mut self, index: u32, part: u32, normal: Vec3A, distance: f32, keep: f32) -> f32 {
        let Some(close) = self.close.get_mut(index as usize) else { return keep };
        let other = *close;
        let is_other = other.substep > 0 && other.part != part && self.substep - other.substep <= 1;
        let between = is_other && normal.dot(other.normal.into()) < OPPOSED;
        let keep = if between { (0.5 * (distance + other.distance)).clamp(CLOSEST * keep, keep) } else { keep };
        *close = Close { substep: self.substep, part, normal: normal.into(), distance: distance.max(keep) };
        keep
    }
}
