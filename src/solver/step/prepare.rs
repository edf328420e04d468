//! What is derived from the rest shape, the fabric and the pins, before the first frame and when those change.

use super::Scratch;
use crate::solver::anchors::{Anchors, RIGID};
use crate::solver::integrate::{follow_the_leader, tether};
use crate::solver::rest::RestShape;
use crate::solver::settings::Fabric;
use crate::solver::state::ClothState;

/// Sets inverse masses from density and anchors, constraint factors and tethers.
///
/// Call after bind and whenever what [`Fabric::prepared`] tells of the fabric, the set of anchored particles or which of them
/// are held rigidly changed. Keeps positions and velocities.
pub fn prepare(rest: &RestShape, fabric: &Fabric, anchors: &Anchors, state: &mut ClothState, scratch: &mut Scratch) {
    weigh(rest, fabric, anchors, state, scratch);
    if !rigid(anchors, state).eq(scratch.rigid.iter().copied()) || scratch.factors_for == 0.0 {
        scratch.rigid.clear();
        scratch.rigid.extend(rigid(anchors, state));
        scratch.tethers = tether::Tethers::new(rest, &scratch.rigid);
        scratch.coarse.hold(rest, &scratch.rigid);
        scratch.follow_the_leader = follow_the_leader::FollowTheLeader::new(rest, &scratch.rigid);
    }
    let longest =
        |longest: f32, e: &[u32; 2]| rest.positions[e[0] as usize].distance_squared(rest.positions[e[1] as usize]).max(longest);
    scratch.longest_edge = rest.topology.edges.iter().fold(0.0, longest).sqrt();
    scratch.area = rest.areas.iter().sum();
    scratch.along_threads = rest.springs.run_along_threads(fabric.warp_angle);
    scratch.bends.update(&rest.bends, fabric, &rest.areas, &state.positions);
    scratch.factors_for = 0.0;
}

/// Sets inverse masses.
fn weigh(rest: &RestShape, fabric: &Fabric, anchors: &Anchors, state: &mut ClothState, scratch: &mut Scratch) {
    for (x, &area) in state.positions.iter_mut().zip(&rest.areas) {
        x.w = 1.0 / (fabric.density * area).max(1.0e-9);
    }
    scratch.coupling.weigh(anchors);
    for p in pinned(anchors) {
        state.positions[p as usize].w = 0.0;
    }
    for (anchor, w) in scratch.coupling.weights() {
        if let Some(&p) = anchors.particles.get(anchor) {
            state.positions[p as usize].w = w;
        }
    }
    for (x, old) in state.positions.iter().zip(&mut state.previous) {
        old.w = x.w;
    }
}

/// The particles of rigid pins, in the order of pins.
fn pinned(anchors: &Anchors) -> impl Iterator<Item = u32> {
    anchors.particles.iter().zip(&anchors.weights).filter(|(_, w)| **w >= RIGID).map(|(p, _)| *p)
}

/// Those of them that nothing moves.
fn rigid(anchors: &Anchors, state: &ClothState) -> impl Iterator<Item = u32> {
    pinned(anchors).filter(|&p| state.positions[p as usize].w == 0.0)
}
