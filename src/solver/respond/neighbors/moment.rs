//! What pairs are looked for in.

use glam::Vec4;

use crate::solver::body::Touch;
use crate::solver::effort::Effort;
use crate::solver::jobs::JobSystem;

/// What pairs are looked for in: the state of all cloths after a substep.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moment<'a> {
    /// Position `[m]` and, in `w`, inverse mass `[1/kg]` of every particle.
    pub positions: &'a [Vec4],
    /// Positions `[m]` at the start of the substep.
    pub previous: &'a [Vec4],
    /// Length `[s]` of the substep, for each cloth.
    pub substep: &'a [f32],
    /// Thickness and friction of each cloth.
    pub touch: &'a [Touch],
    /// Whether each cloth rests on cloths at all.
    pub takes_part: &'a [bool],
    /// Whether pins hold each particle; what is not to be moved has no inverse mass either.
    pub pinned: &'a [bool],
    /// Work that one look may be: of pairs that come on top, in cloth that is crushed, nothing is known.
    pub most: Effort,
    /// Threads that may share it.
    pub jobs: Option<&'a dyn JobSystem>,
}

impl Moment<'_> {
    /// Thickness of the thickest cloth `[m]`.
    pub(super) fn thickest(&self) -> f32 {
        self.touch.iter().map(|t| t.thickness).fold(0.0, f32::max)
    }
}
