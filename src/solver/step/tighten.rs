//! Holds a cloth to its strain limit within a substep: springs before bodies are met, and whatever contacts have stretched
//! after.

use glam::Vec4;

use super::frame::Frame;
use super::shorten::limit_ways;
use super::strain::{TAUT, WILD};
use super::{Scratch, Stepped};
use crate::solver::body::{Grounds, Touch};
use crate::solver::state::ClothState;

/// Sweeps for the strain limit in each substep of a taut cloth, and in each turn with contacts.
const TAUT_SWEEPS: u32 = 2;

/// The same near bodies that are finer than the mesh: cloth hangs on their corners.
const HUNG_SWEEPS: u32 = 4;

/// The same for a settling cloth, whose edges are shortened at the end of a frame only far beyond the limit.
pub(super) const SETTLING_SWEEPS: u32 = 8;

impl Stepped<'_> {
    /// Lists the springs that may get to the strain limit within the frame.
    pub(super) fn find_tight(&self, settling: bool, state: &ClothState, scratch: &mut Scratch) {
        // A settling cloth would feel a list that shrinks.
        let all = scratch.is_wild(self.fabric);
        scratch.tight.find(&self.rest.springs, self.fabric.strain_limit, (all, settling), &state.positions);
    }

    /// Shortens springs that are beyond the strain limit. Near bodies with corners cloth is laid on bodies before each sweep.
    /// What hangs on a corner could not draw at its neighbours otherwise, which would follow it into the body. Only the edges
    /// next to it would stretch. Round bodies bear it all around: a sheet of 64² that falls on a ball would take a quarter
    /// longer.
    pub(super) fn tighten(&self, frame: &Frame, positions: &mut [Vec4], previous: &[Vec4], scratch: &mut Scratch) {
        let Self { rest, fabric, input, .. } = *self;
        let Scratch { tight, springs, contacts, faces, coupling, provisional, .. } = scratch;
        let mut grounds = Grounds { bodies: input.bodies, span: frame.span(), touch: Touch::of(fabric), rubs: false, coupling };
        let hangs = faces.candidates() > 0;
        let sweeps = match (frame.settling, hangs) {
            (true, _) => SETTLING_SWEEPS,
            (false, true) => HUNG_SWEEPS,
            (false, false) => TAUT_SWEEPS,
        };
        for _ in 0..sweeps {
            if hangs {
                contacts.project_provisionally(&mut grounds, positions, previous, provisional);
                faces.project_provisionally(&mut grounds, positions, previous, provisional);
            }
            tight.solve(&rest.springs, springs, fabric.strain_limit, positions);
        }
        provisional.restore(positions);
    }

    /// Whether neither bodies nor a skin are near, which stretch cloth, too, and which it would be drawn through.
    pub(crate) fn stands_alone(&self, scratch: &Scratch) -> bool {
        self.input.skinned.is_none() && !scratch.is_near_bodies()
    }

    /// Shortens edges that cloth holds beyond the strain limit, if one is [far beyond](WILD) it, or when `again` still
    /// [taut](TAUT); whether it is. No particle goes farther than a thickness in a substep. Only where cloth [stands
    /// alone](Self::stands_alone); `again` only what was shortened in the first turn.
    pub(crate) fn shorten_overlong(&self, again: bool, state: &mut ClothState, scratch: &mut Scratch) -> bool {
        let Self { rest, fabric, .. } = *self;
        let bound = 1.0 + fabric.strain_limit;
        let from = if again { TAUT } else { WILD };
        let x = &mut state.positions;
        let alone = self.stands_alone(scratch);
        let Scratch { overlong, springs, displaced: before, .. } = scratch;
        if !again {
            before.clear();
        } else if before.is_empty() {
            return false;
        }
        if !alone || !overlong.find(&rest.springs, [bound, 1.0 + from * fabric.strain_limit], x) {
            return false;
        }
        if !again {
            (**before).clone_from(x);
        }
        overlong.shorten(&rest.springs, springs, bound, TAUT_SWEEPS, x);
        limit_ways(x, before, fabric.thickness);
        true
    }
}
