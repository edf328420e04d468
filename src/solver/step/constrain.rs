//! The first half of a substep: forces, and all that holds the cloth together.

use super::frame::Frame;
use super::{Memory, Stepped};
use crate::solver::state::StateMut;

impl Stepped<'_> {
    /// Begins the next substep: forces, prediction, and all that holds the cloth together. False when the frame is over, or
    /// none was begun.
    pub(crate) fn constrain(&self, state: &mut StateMut<'_>, memory: &mut Memory) -> bool {
        let Some(frame) = memory.frame.as_mut().and_then(Frame::next_substep) else { return false };
        debug_assert!(memory.late.is_empty() || memory.late.len() == state.previous.len());
        Self::give_back(state, memory);
        if self.input.wind.density > 0.0 && frame.is_gusty() {
            self.blow(&frame, state, memory);
        }
        if frame.begun > 1 {
            memory.keep_air(state);
        }
        if let Some(skinned) = self.input.skinned {
            skinned.draw(memory.pierced.drawn(), frame.span(), frame.h, state.positions, state.previous);
        }
        memory.carried.note(*state.substep, state.positions, state.previous);
        if frame.steps > 1 {
            self.advance_in_steps(&frame, state, memory);
        } else {
            self.advance(&frame, state, memory);
        }
        debug_assert_eq!(*state.substep, frame.h);
        *state.substeps += 1;
        true
    }
}
