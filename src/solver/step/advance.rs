//! A substep in one step.

use glam::{Vec3, Vec4};

use super::frame::Frame;
use super::hold::hold_together;
use super::{Memory, Stepped};
use crate::solver::couple::Pull;
use crate::solver::integrate::anchor;
use crate::solver::state::StateMut;

impl Stepped<'_> {
    /// A substep in one step: prediction, and all that holds the cloth together.
    pub(super) fn advance(&self, frame: &Frame, state: &mut StateMut<'_>, memory: &mut Memory) {
        let Self { rest, fabric, anchors, input } = *self;
        let h = frame.h;
        self.predict(frame.forces(h, Self::motion(state, h), memory.last_step(state)), state, memory);
        *state.substep = h;
        memory.inner_steps = 1;
        let (x, old) = (&mut *state.positions, &*state.previous);
        memory.inbound.clear();
        if fabric.restitution > 0.0 {
            memory.inbound.extend(x.iter().zip(old).map(|(x, old)| *x - *old));
        }
        let (s0, s) = frame.span();
        anchor::solve(anchors, s, h, x);
        if let Some(skinned) = input.skinned {
            skinned.drive([s0, s], h, old, x);
        }
        memory.coupling.advance(h);
        memory.coupling.place(anchors, s, x);
        memory.pulls.solve(s, h, x);
        memory.coupling.note(x);
        self.fold_again(frame, x, state.folds, &mut memory.factors.bends);
        memory.factors.bends.solve(&rest.bends, h, x);
        self.bound_lengths(frame, *state.substeps, memory, x);
        hold_together(rest, fabric, memory, x);
        if frame.taut {
            self.tighten(frame, x, memory);
        }
        self.pull(h, s, input.gravity, memory, x);
    }

    /// Tells bodies what the cloth did to pins on them in a step of `h` `[s]` that ended at the share `s` of the frame.
    pub(super) fn pull(&self, h: f32, s: f32, gravity: Vec3, memory: &mut Memory, positions: &mut [Vec4]) {
        let pull = Pull { rest: self.rest, anchors: self.anchors, s, h, gravity, density: self.fabric.density };
        memory.coupling.react(&pull, positions);
    }
}
