//! Shortens edges that are overlong at the end of a frame.

use glam::Vec4;

use super::{FrameInput, Memory, Stepped};
use crate::solver::body::{BodyContext, Projection, Touch};
use crate::solver::integrate::spring;
use crate::solver::state::StateMut;

/// Share of the thickness by which a particle that may touch cloth is moved at most, to shorten edges. Two that are moved
/// farther could pass through each other unseen.
const CROWDED: f32 = 0.5;

/// Passes over edges that are beyond the strain limit at the end of a frame.
const FINISH_PASSES: u32 = 8;

/// Up to this share of the strain limit in its mean edge a cloth is strained in places, not as a whole (dimensionless).
const EVEN: f32 = 0.2;

/// Shortens edges that are beyond the strain limit at the end of a frame. No particle gains speed by it or goes into a body.
pub(super) fn shorten(cloth: &Stepped<'_>, crowded: bool, state: &mut StateMut<'_>, memory: &mut Memory, mean_edge: f32) {
    let Stepped { rest, fabric, input: FrameInput { bodies, .. }, .. } = *cloth;
    let bound = 1.0 + fabric.strain_limit;
    let x = &mut *state.positions;
    let before = &mut *memory.before;
    x.clone_into(before);
    memory.overlong.find(&rest.springs, [bound; 2], x);
    memory.overlong.shorten(&rest.springs, &memory.factors.springs, bound, FINISH_PASSES, x);
    // A cloth that is stretched as a whole would be crumpled.
    if mean_edge < 1.0 + EVEN * fabric.strain_limit && !memory.factors.follow_the_leader.is_empty() {
        let worst = spring::strain(&rest.springs, x).0;
        x.clone_into(&mut memory.displaced);
        memory.factors.follow_the_leader.solve(rest, bound, x);
        // Each particle was drawn to the last of its neighbours: even that out.
        memory.overlong.find(&rest.springs, [bound; 2], x);
        memory.overlong.shorten(&rest.springs, &memory.factors.springs, bound, FINISH_PASSES / 2, x);
        // Where what was drawn to one pin meets what was drawn to another, it does not fit.
        if spring::strain(&rest.springs, x).0 > worst {
            x.copy_from_slice(&memory.displaced);
        }
    }
    // No farther than the distance kept to bodies: nothing can be behind one then. Nor through cloth that was not looked for.
    let farthest = fabric.thickness * if crowded { CROWDED } else { 1.0 };
    limit_ways(x, before, farthest);
    let slip = Touch::frictionless(fabric);
    let mut context = BodyContext { bodies, span: (1.0, 1.0), touch: slip, coupling: &mut memory.coupling };
    memory.contacts.project(&mut context, x, before, &[], Projection::First);
    memory.faces.project(&mut context, x, before);
    for ((old, x), before) in state.previous.iter_mut().zip(x).zip(before) {
        *old += *x - *before;
    }
}

/// Brings particles that went farther than `farthest` `[m]` from where they were `before` back on their way.
pub(super) fn limit_ways(positions: &mut [Vec4], before: &[Vec4], farthest: f32) {
    for (x, before) in positions.iter_mut().zip(before) {
        let way = *x - *before;
        let square = way.length_squared();
        if square > farthest * farthest {
            *x = *before + way * (farthest / square.sqrt());
        }
    }
}
