//! What is derived from the rest shape, the fabric and the pins, before the first frame and when those change.

use super::Memory;
use super::factors::Factors;
use crate::solver::anchors::{Anchors, RIGID};
use crate::solver::integrate::{follow_the_leader, tether};
use crate::solver::rest::RestShape;
use crate::solver::settings::Fabric;
use crate::solver::state::ClothState;

/// Sets inverse masses from density and anchors, and the factors of constraints. What `memory` holds of a rest shape of other
/// sizes is forgotten.
///
/// Call after bind and whenever what [`Fabric::prepared`] tells of the fabric, the set of anchored particles or which of them
/// are held rigidly changed, or where [`Memory::is_prepared_for`] is false. Keeps positions and velocities.
pub fn prepare(rest: &RestShape, fabric: &Fabric, anchors: &Anchors, state: &mut ClothState, memory: &mut Memory) {
    if memory.factors.sizes.is_some() && !memory.is_prepared_for(rest) {
        memory.forget();
    }
    weigh(rest, fabric, anchors, state, memory);
    if !rigid(anchors, state).eq(memory.factors.rigid.iter().copied()) || memory.factors.substep == 0.0 {
        memory.factors.rigid.clear();
        memory.factors.rigid.extend(rigid(anchors, state));
        memory.factors.tethers = tether::Tethers::new(rest, &memory.factors.rigid);
        memory.factors.coarse.hold(rest, &memory.factors.rigid);
        memory.factors.follow_the_leader = follow_the_leader::FollowTheLeader::new(rest, &memory.factors.rigid);
    }
    let longest =
        |longest: f32, e: &[u32; 2]| rest.positions[e[0] as usize].distance_squared(rest.positions[e[1] as usize]).max(longest);
    memory.factors.longest_edge = rest.topology.edges.iter().fold(0.0, longest).sqrt();
    memory.factors.area = rest.areas.iter().sum();
    memory.factors.along_threads = rest.springs.run_along_threads(fabric.warp_angle);
    memory.factors.bends.update(&rest.bends, fabric, &rest.areas, &state.positions);
    memory.factors.substep = 0.0;
    memory.factors.sizes = Some(Factors::sizes_of(rest));
}

/// Sets inverse masses.
fn weigh(rest: &RestShape, fabric: &Fabric, anchors: &Anchors, state: &mut ClothState, memory: &mut Memory) {
    for (x, &area) in state.positions.iter_mut().zip(&rest.areas) {
        x.w = 1.0 / (fabric.density * area).max(1.0e-9);
    }
    memory.coupling.weigh(anchors);
    for p in pinned(anchors) {
        state.positions[p as usize].w = 0.0;
    }
    for (anchor, w) in memory.coupling.weights() {
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
