//! Holds a taut cloth to its strain limit.

use glam::Vec4;

use super::frame::Frame;
use super::{Scratch, Stepped};
use crate::solver::body::{Grounds, Touch};
use crate::solver::state::ClothState;

/// Sweeps for the strain limit in each substep of a taut cloth.
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
}
