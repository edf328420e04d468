//! A substep in inner steps.

use glam::Vec3;

use super::frame::Frame;
use super::hold::hold_together;
use super::{Memory, Stepped};
use crate::solver::integrate::anchor;
use crate::solver::state::StateMut;

impl Stepped<'_> {
    /// A substep in inner steps: forces, bending and membrane act in each. Bounds on lengths and soft pins follow at its end,
    /// and contacts after it (multiple time stepping, Tuckerman et al. 1992).
    ///
    /// Bounds and contacts act on the mean velocity of the substep, `(x - start) / h`. What they hold in its place so has none.
    /// That of the last inner step differs by what the forces of the substep do. The difference is [given
    /// back](Self::give_back) after contacts: no momentum is lost.
    pub(super) fn advance_in_steps(&self, frame: &Frame, state: &mut StateMut<'_>, memory: &mut Memory) {
        let Self { rest, fabric, anchors, input } = *self;
        let (h, steps) = (frame.h, frame.steps as f32);
        let step = h / steps;
        let (s0, s1) = frame.span();
        let mut forces = frame.forces(step, Self::motion(state, h) / steps, memory.last_step(state));
        *state.substep = h;
        memory.inner_steps = frame.steps;
        state.positions.clone_into(&mut memory.late);
        self.fold_again(frame, state.positions, state.folds, &mut memory.factors.bends);
        memory.coupling.advance(h);
        memory.inbound.clear();
        for k in 1..=frame.steps {
            self.predict(forces, state, memory);
            forces = frame.forces(step, 1.0, step);
            let x = &mut state.positions;
            if k == 1 && fabric.restitution > 0.0 {
                memory.inbound.extend(x.iter().zip(&*state.previous).map(|(x, old)| (*x - *old) * steps));
            }
            let at = |k: u32| s0 + (s1 - s0) * k as f32 / steps;
            let s = at(k);
            anchor::solve_rigid(anchors, s, x);
            if let Some(skinned) = input.skinned {
                skinned.drive([at(k - 1), s], step, state.previous, x);
            }
            memory.coupling.place(anchors, s, x);
            memory.pulls.solve(s, step, x);
            memory.coupling.note(x);
            memory.factors.bends.solve(&rest.bends, step, x);
            hold_together(rest, fabric, memory, x);
            self.pull(step, s, input.gravity, memory, x);
        }
        Self::take_mean(steps, state, memory);
        let x = &mut state.positions;
        memory.coupling.place(anchors, s1, x);
        anchor::solve_soft(anchors, s1, h, x);
        memory.coupling.note(x);
        self.bound_lengths(frame, *state.substeps, memory, x);
        if frame.taut {
            self.tighten(frame, x, memory);
        }
        self.pull(h, s1, Vec3::ZERO, memory, x);
    }

    /// Takes the mean velocity of the substep for that of the last of its inner `steps`, and notes the difference.
    fn take_mean(steps: f32, state: &mut StateMut<'_>, memory: &mut Memory) {
        for ((x, old), late) in state.positions.iter().zip(&mut *state.previous).zip(memory.late.iter_mut()) {
            let start = core::mem::replace(late, (*x - *old) * steps - (*x - *late));
            *old = start;
        }
    }

    /// Ends a substep taken [in inner steps](Self::advance_in_steps): velocities become those of the last, and what bounds and
    /// contacts added.
    pub(super) fn give_back(state: &mut StateMut<'_>, memory: &mut Memory) {
        for (old, late) in state.previous.iter_mut().zip(memory.late.iter()) {
            *old -= *late;
        }
        memory.late.clear();
    }
}
