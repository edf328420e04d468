//! A cloth as its island sees it.

use glam::Vec3;

use crate::solver::evaluate::Outcome;
use crate::solver::fit::fit;
use crate::solver::settings::Stepping;
use crate::solver::state::ClothState;
use crate::solver::step::{Scratch, StepReport, Stepped};

/// A cloth of an island, in a frame.
#[derive(Debug)]
pub struct Member<'a> {
    /// What it is stepped with; its frame takes no time where it does not move.
    pub cloth: Stepped<'a>,
    /// Its substeps; all take as many as the one that needs most.
    pub stepping: &'a Stepping,
    /// Its particles.
    pub state: &'a mut ClothState,
    /// Its buffers.
    pub scratch: &'a mut Scratch,
    /// From its frame of simulation to that of the island `[m]`.
    pub offset: Vec3,
    /// Whether other cloths can push it.
    pub moves: bool,
    /// Time that passes by its clock, whether it moves or not `[s]`.
    pub clock: f32,
    /// Whether untangling leaves it where it is.
    pub fixed: bool,
    /// Whether nothing moves it: it stays where it is, whatever speed it had.
    pub still: bool,
    /// Whether it rests on others and itself, or passes through.
    pub contact: bool,
    /// Whether it is to be taken apart at once if it crosses now.
    pub at_load: bool,
    /// What was decided about it in the last frame.
    pub outcome: Outcome,
    /// Time for which it is tangled before it is drawn to its pose `[s]`.
    pub last_resort: f32,
}

/// The cloths of an island, as it asks for them.
pub trait Members {
    /// Cloth `part`, in the order in which the island was made.
    fn member(&mut self, part: usize) -> Option<Member<'_>>;

    /// Is told what the frame of cloth `part` did.
    fn done(&mut self, part: usize, report: StepReport);

    /// Writes the shape that cloth `part` has when nothing else helps `[m]`: its own at rest, laid where it fits best.
    fn pose(&mut self, part: usize, pose: &mut Vec<Vec3>) {
        pose.clear();
        if let Some(m) = self.member(part) {
            fit(m.cloth.rest, &m.state.positions, pose);
        }
    }
}
