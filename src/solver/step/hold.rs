//! What holds the cloth together: its membrane, its folds, and bounds on lengths.

use glam::Vec4;

use super::frame::Frame;
use super::{Memory, Stepped};
use crate::solver::integrate::{bend, membrane, spring};
use crate::solver::rest::RestShape;
use crate::solver::settings::Fabric;

/// Tethers are solved once in this many substeps; in every substep of a settling cloth, which the alternation would keep from
/// rest.
const TETHER_EVERY: u64 = 2;

impl Stepped<'_> {
    /// Keeps the cloth from its pins no farther than it is long, in the substep after `substeps` others. What is strained is
    /// drawn in by its coarse level, too.
    pub(super) fn bound_lengths(&self, frame: &Frame, substeps: u64, memory: &mut Memory, positions: &mut [Vec4]) {
        let Self { rest, fabric, .. } = *self;
        // They are at a bound, which holds for more than one substep.
        if frame.settling || !substeps.is_multiple_of(TETHER_EVERY) {
            memory.factors.tethers.solve(fabric.tether_scale + memory.give, positions);
        }
        if frame.strained {
            memory.factors.coarse.solve(&rest.coarse, fabric.strain_limit, positions);
        }
    }

    /// Finds the folds again where the cloth is now, in the middle of a frame of a settling cloth. Bends turn within a frame,
    /// and what lags behind by a whole one would keep it from rest.
    pub(super) fn fold_again(&self, frame: &Frame, positions: &[Vec4], folds: &mut Vec<Vec4>, bends: &mut bend::BendFactors) {
        let begun = frame.begun - 1;
        if frame.settling && begun > 0 && begun == frame.report.substeps / 2 {
            bends.fold(&self.rest.bends, self.fabric, positions, folds);
        }
    }
}

/// Sweeps the springs or triangles once, as a substep does, without letting time pass. Nothing happens before the first
/// [`step`](super::step()).
pub fn relax(rest: &RestShape, fabric: &Fabric, memory: &Memory, positions: &mut [Vec4]) {
    if positions.len() == rest.positions.len() && memory.factors.substep > 0.0 {
        hold_together(rest, fabric, memory, positions);
    }
}

/// Solves the membrane once, for the substep that the factors were computed for.
pub(super) fn hold_together(rest: &RestShape, fabric: &Fabric, memory: &Memory, positions: &mut [Vec4]) {
    if memory.factors.triangles {
        membrane::solve(&rest.membrane, fabric, memory.factors.substep, positions);
    } else {
        spring::solve(&rest.springs, &memory.factors.springs, fabric.strain_limit, positions);
    }
}
