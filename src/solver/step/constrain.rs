//! The first half of a substep: forces, and all that holds the cloth together.

use super::frame::Frame;
use super::{Scratch, Stepped};
use crate::solver::state::StateMut;

impl Stepped<'_> {
    /// Begins the next substep: forces, prediction, and all that holds the cloth together. False when the frame is over, or
    /// none was begun.
    pub(crate) fn constrain(&self, state: &mut StateMut<'_>, scratch: &mut Scratch) -> bool {
        let Some(frame) = scratch.frame.as_mut().and_then(Frame::next_substep) else { return false };
        debug_assert!(scratch.late.is_empty() || scratch.late.len() == state.previous.len());
        Self::give_back(state, scratch);
        if self.input.wind.density > 0.0 && frame.is_gusty() {
            self.blow(&frame, state, scratch);
        }
        if frame.begun > 1 {
            scratch.keep_air(state);
        }
        if let Some(skinned) = self.input.skinned {
            skinned.draw(scratch.pierced.drawn(), frame.span(), frame.h, state.positions, state.previous);
        }
        scratch.carried.note(*state.substep, state.positions, state.previous);
        if frame.steps > 1 {
            self.advance_in_steps(&frame, state, scratch);
        } else {
            self.advance(&frame, state, scratch);
        }
        debug_assert_eq!(*state.substep, frame.h);
        *state.substeps += 1;
        true
    }
}
