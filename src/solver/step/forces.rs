//! Forces: the wind, and where it and gravity take particles.

use super::frame::Frame;
use super::{Memory, Stepped};
use crate::solver::integrate::predict;
use crate::solver::state::StateMut;
use crate::solver::wind::Aerodynamics;

impl Stepped<'_> {
    /// Evaluates the wind and gravity for the substeps until the wind is next evaluated.
    pub(super) fn blow(&self, frame: &Frame, state: &StateMut<'_>, memory: &mut Memory) {
        let Self { rest, fabric, input, .. } = *self;
        let (x, old) = (&state.positions, &state.previous);
        memory.acceleration.clear();
        memory.acceleration.resize(x.len(), input.gravity.extend(0.0));
        let air = Aerodynamics { drag: fabric.drag_coefficient, lift: fabric.lift_coefficient };
        let hold = frame.dt / frame.gusts as f32;
        let faces = &rest.topology.faces;
        memory.wind.apply(input.wind, air, faces, x, old, *state.substep, hold, &mut memory.acceleration);
    }

    /// Moves free particles by a share `carry` of their way over the last substep (dimensionless), and by their acceleration
    /// times `push` `[s²]`.
    pub(super) fn predict(&self, (carry, push): (f32, f32), state: &mut StateMut<'_>, memory: &Memory) {
        let (x, old) = (&mut state.positions, &mut state.previous);
        if self.input.wind.density > 0.0 {
            predict::predict(x, old, &memory.acceleration, carry, push);
        } else {
            predict::predict_uniform(x, old, self.input.gravity.extend(0.0), carry, push);
        }
    }

    /// The way of a substep of `h` `[s]` over that of the last one (dimensionless), 0 after none.
    pub(super) fn motion(state: &StateMut<'_>, h: f32) -> f32 {
        if *state.substep > 0.0 { h / *state.substep } else { 0.0 }
    }
}
