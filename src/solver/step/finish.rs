//! Ends a frame.

use super::settling::{damp_oscillation, mean_square_speed};
use super::shorten::shorten;
use super::{Memory, StepReport, Stepped};
use crate::solver::integrate::spring;
use crate::solver::state::StateMut;

impl Stepped<'_> {
    /// Ends the frame; nothing when none was begun. `crowded`: whether it may touch cloth.
    pub(crate) fn finish(&self, crowded: bool, state: &mut StateMut<'_>, memory: &mut Memory) -> Option<StepReport> {
        let frame = memory.frame.take()?;
        let Self { rest, fabric, .. } = *self;
        let mut report = frame.report;
        *state.time += f64::from(frame.dt);
        Self::give_back(state, memory);
        report.bend_held = memory.factors.bends.held(frame.h / frame.steps as f32);
        memory.keep_air(state);
        memory.carried.end();
        if frame.settling && fabric.damping > 0.0 {
            damp_oscillation(&memory.before, 1.0 / report.substeps as f32, state);
        }
        let speed2 = mean_square_speed(state.positions, &memory.before, frame.dt);
        (report.worst_edge, report.mean_edge) = spring::strain(&rest.springs, state.positions);
        memory.worst_edge = report.worst_edge;
        if memory.is_overlong(fabric) {
            shorten(self, crowded, state, memory, report.mean_edge);
            // Pins on bodies that cloth moves have a mass, and yet stay where they are.
            memory.coupling.place(self.anchors, 1.0, state.positions);
            if let Some(skinned) = self.input.skinned {
                skinned.limit_silently(&memory.tangled_limits, state.positions, state.previous);
            }
            (report.worst_edge, report.mean_edge) = spring::strain(&rest.springs, state.positions);
        }
        self.count_for_heavy_bodies(memory);
        memory.note_speed(speed2, frame.dt);
        Some(report)
    }
}
