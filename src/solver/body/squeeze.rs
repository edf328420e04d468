//! Cloth between two parts of bodies that leave no room for it.
//!
//! ```text
//!   part A  │ <- dA -> x <- dB -> │  part B      nA · nB < 0:  kept (dA + dB) / 2 away from both, never more than anywhere else
//! ```
//!
//! Pushed out of one part after the other, it would end up in the first, with loads that hold it there as no friction could.

use glam::{Vec3, Vec3A};

use super::respond::Projection;
use crate::solver::scales::{ALIGNED, TOUCHING};

/// What something is close to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
struct Close {
    /// Number of the substep, from 1; 0: nothing.
    substep: u32,
    part: u32,
    /// In the cloth's frame.
    normal: Vec3,
    /// Distance after the part pushed, and what it kept `[m]`.
    distance: f32,
    kept: f32,
}

/// Which part each particle, or each face, was last close to.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Squeezes {
    close: Vec<Close>,
    substep: u32,
    projection: Projection,
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

    /// Begins a projection of a substep. Only the first asks all parts, and is remembered.
    pub(super) fn advance(&mut self, projection: Projection) {
        self.substep += u32::from(projection == Projection::First);
        self.projection = projection;
    }

    /// The distance to keep `[m]` from `part`, `distance` away along its unit normal: `keep`, or half of the room that another
    /// part leaves.
    #[inline]
    pub(super) fn keep(&mut self, index: u32, part: u32, normal: Vec3A, distance: f32, keep: f32) -> f32 {
        let Some(close) = self.close.get_mut(index as usize) else { return keep };
        let other = *close;
        if other.substep == self.substep && other.part == part {
            return other.kept;
        }
        let is_other = other.substep > 0 && other.part != part && self.substep - other.substep <= 1;
        let between = is_other && normal.dot(other.normal.into()) < -ALIGNED;
        let keep = if between { (0.5 * (distance + other.distance)).clamp(TOUCHING * keep, keep) } else { keep };
        if self.projection == Projection::First {
            *close = Close { substep: self.substep, part, normal: normal.into(), distance: distance.max(keep), kept: keep };
        }
        keep
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Something between two parts, 2 mm from one and 4 mm from the other, where 5 mm are kept elsewhere.
    #[test]
    fn what_is_looked_at_again_is_kept_as_far_away_and_nothing_is_remembered_of_that() {
        let mut squeezes = Squeezes::default();
        squeezes.begin(2, 1);
        let up = Vec3A::Y;
        squeezes.advance(Projection::First);
        let first = [squeezes.keep(0, 0, up, 0.002, 0.005), squeezes.keep(0, 1, -up, 0.001, 0.005)];
        assert_eq!(first, [0.005, 0.003], "the first part pushes by 3 mm, the second leaves the middle");
        squeezes.advance(Projection::Relax);
        assert_eq!(squeezes.keep(0, 1, -up, 0.002, 0.005), 0.003);
        squeezes.advance(Projection::First);
        assert_eq!(squeezes.keep(0, 0, up, 0.003, 0.005), 0.003);
        squeezes.advance(Projection::Relax);
        assert_eq!(squeezes.keep(0, 1, -up, 0.003, 0.005), 0.003, "asked alone");
        squeezes.advance(Projection::First);
        assert_eq!(squeezes.keep(0, 1, -up, 0.003, 0.005), 0.003, "the other part is still known");
    }
}
