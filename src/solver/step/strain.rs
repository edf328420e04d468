//! How far beyond the strain limit the cloth is stretched, and from when on more is done about it.

use super::Memory;
use crate::solver::settings::Fabric;

/// Beyond this many strain limits a cloth is strained, until it is within [`EASED`]. Its coarse level is solved in the next
/// frame, and the frame ends with its overlong edges shortened.
const STRAINED: f32 = 1.5;

/// Beyond this many strain limits a cloth is taut, until it is within [`EASED`]. From there on, a settling cloth ends its frame
/// with overlong edges shortened. In the substeps of the next frame those of its springs that are close to the limit are also
/// [swept](super::Stepped::tighten) for it alone.
pub(super) const TAUT: f32 = 2.0;

/// Beyond this many strain limits a cloth is in a storm: any of its springs may get to its limit within a frame. What contacts
/// hold as long in a substep is [shortened](super::Stepped::shorten_overlong) before it ends, until it is no longer [`TAUT`].
pub(super) const WILD: f32 = 8.0;

/// Within this many strain limits a cloth is neither. Less than the others: a cloth that is held at a bound by what is done
/// beyond it would do it every other frame.
const EASED: f32 = 0.5;

/// Least strain limit that these are multiples of (dimensionless). One pass over the springs leaves as much: of a limit of 0,
/// any cloth would be in a storm.
pub(super) const LEAST_LIMIT: f32 = 0.01;

impl Memory {
    /// Whether an edge was so far beyond the strain limit that the last frame solved the coarse level, too.
    #[cfg(feature = "debug")]
    #[must_use]
    pub(crate) fn is_strained(&self) -> bool {
        self.strained
    }

    /// Finds out whether the cloth is strained, and whether it is taut, in the frame that begins.
    pub(super) fn judge(&mut self, fabric: &Fabric) -> (bool, bool) {
        // Of its first frame nothing is known: a cloth may start in a storm.
        let beyond = |limits: f32, was: bool| self.is_beyond(if was { EASED } else { limits }, fabric);
        let (strained, taut) = (beyond(STRAINED, self.strained) || self.worst_edge == 0.0, beyond(TAUT, self.taut));
        (self.strained, self.taut) = (strained, taut);
        (strained, taut)
    }

    /// Whether any spring may get to its limit within the frame.
    pub(super) fn is_wild(&self, fabric: &Fabric) -> bool {
        self.is_beyond(WILD, fabric)
    }

    /// Whether the frame is to end with its overlong edges shortened.
    pub(super) fn is_overlong(&self, fabric: &Fabric) -> bool {
        // In settling cloth what is shortened moves, and is shortened in the next frame again.
        let limits = if self.is_settling() { TAUT } else { STRAINED };
        self.is_beyond(limits, fabric)
    }

    /// Whether the worst edge was longer by more than `limits` strain limits after the substeps of the last frame.
    fn is_beyond(&self, limits: f32, fabric: &Fabric) -> bool {
        self.worst_edge - 1.0 > limits * fabric.strain_limit.max(LEAST_LIMIT)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cloth_that_must_not_stretch_is_strained_by_more_than_one_pass_leaves() {
        let is_strained = |worst_edge: f32, strain_limit: f32| {
            let mut memory = Memory { worst_edge, ..Memory::default() };
            memory.judge(&Fabric { strain_limit, ..Fabric::default() }).0
        };
        for strain_limit in [0.0, 1.0e-3, LEAST_LIMIT] {
            assert!(!is_strained(1.012, strain_limit) && is_strained(1.02, strain_limit), "{strain_limit}");
        }
        assert!(!is_strained(1.07, 0.05) && is_strained(1.08, 0.05));
    }
}
