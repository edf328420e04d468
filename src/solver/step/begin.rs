//! Begins a frame: everything that is found out once, before the first substep.

use super::frame::Frame;
use super::settling::SETTLING_DRAG;
use super::tighten::SETTLING_SWEEPS;
use super::{Memory, StepReport, Stepped, count};
use crate::solver::body::{Approach, Sheet};
use crate::solver::integrate::{air, bend, damp};
use crate::solver::settings::{MembraneModel, Stepping};
use crate::solver::skinned::{FASTEST, Skinned};
use crate::solver::state::StateMut;

/// Wind forces are evaluated at least this often `[Hz]`.
const WIND_RATE: f32 = 60.0;

impl Stepped<'_> {
    /// Prepares a frame of as many substeps as asked for, or as `stepping` says. None begins when no time passes or the
    /// state does not fit.
    pub(crate) fn begin(&self, stepping: &Stepping, count: Option<u32>, state: &mut StateMut<'_>, memory: &mut Memory) {
        memory.frame = None;
        let Self { rest, fabric, input, .. } = *self;
        // NaN fails the comparison; `min` alone would let it pass as a whole frame.
        let fits = [state.positions.len(), state.previous.len()] == [rest.positions.len(); 2];
        if !(input.dt > 0.0 && fits) {
            return;
        }
        let dt = input.dt.min(stepping.max_frame);
        let substeps = count.unwrap_or_else(|| self.substeps(stepping, state.positions, memory)).max(1);
        let h = dt / substeps as f32;
        // A time that is hardly a number has no parts.
        if !(h > 0.0) {
            return;
        }
        self.begin_coupling(dt, state, memory);
        // Bodies that pins move go along in substeps, and a first frame may be tangled.
        let steps =
            if memory.pinned_to_bodies.is_empty() && memory.worst_edge > 0.0 { self.inner_steps(stepping, h) } else { 1 };
        self.factor(h / steps as f32, state, memory);
        self.choose_membrane(stepping, memory);
        let settling = memory.is_settling();
        memory.factors.bends.fold(&rest.bends, fabric, state.positions, state.folds);
        self.damp(dt, state, memory);
        let Memory { pierced, tangled_limits, worst_edge, .. } = &mut *memory;
        let skinned = input.skinned.map(|skinned| (skinned, &*tangled_limits));
        pierced.find(input.bodies, skinned, fabric, &rest.springs, *worst_edge, state.positions);
        self.gather_bodies(dt, state, memory);
        let (strained, taut) = memory.judge(fabric);
        self.take_air(settling || strained, state, memory);
        if taut {
            self.find_tight(settling, state, memory);
        }
        self.make_room(memory);
        state.positions.clone_into(&mut memory.before);
        memory.contacts.leave_out(&memory.pinned_to_bodies);
        memory.faces.leave_out(&memory.pinned_to_bodies);
        memory.pinches.find(input.bodies, fabric.thickness, state.positions);
        memory.contacts.leave_out(memory.pinches.particles());
        memory.faces.leave_out(memory.pinches.particles());
        memory.contacts.let_through(&memory.pierced);
        memory.faces.let_through(&memory.pierced);
        memory.frame = Some(Frame {
            dt,
            h,
            begun: 0,
            gusts: count::substeps(dt, WIND_RATE).min(substeps),
            steps,
            strained,
            taut,
            settling,
            drag: fabric.drag + if settling && fabric.damping > 0.0 { SETTLING_DRAG } else { 0.0 },
            report: StepReport { substeps, inner_steps: steps, lost_time: input.dt - dt, ..StepReport::default() },
        });
    }

    /// Begins the frame of `dt` `[s]` for the bodies that cloth moves, and lists the particles that are pinned to them.
    fn begin_coupling(&self, dt: f32, state: &StateMut<'_>, memory: &mut Memory) {
        memory.coupling.begin(dt, self.anchors, state.positions);
        memory.pinned_to_bodies.clear();
        memory.pinned_to_bodies.extend(memory.coupling.pinned_to_bodies(self.anchors));
        memory.pinned_to_bodies.sort_unstable();
    }

    /// Computes the factors of springs and of the coarse level for a `step` `[s]`, if they are for another.
    fn factor(&self, step: f32, state: &StateMut<'_>, memory: &mut Memory) {
        if memory.factors.substep != step {
            memory.factors.springs.update(&self.rest.springs, self.fabric, state.positions, step);
            memory.factors.coarse.update(&self.rest.coarse, state.positions);
            memory.factors.substep = step;
        }
    }

    /// Chooses what holds the cloth together in its plane.
    fn choose_membrane(&self, stepping: &Stepping, memory: &mut Memory) {
        memory.factors.triangles = !self.rest.membrane.is_empty()
            && match stepping.membrane {
                MembraneModel::Auto => !memory.factors.along_threads,
                MembraneModel::Springs => false,
                MembraneModel::Triangles => true,
            };
    }

    /// Takes from velocities what damping and the friction of yarns take in `dt` `[s]`.
    fn damp(&self, dt: f32, state: &mut StateMut<'_>, memory: &mut Memory) {
        let Self { rest, fabric, .. } = *self;
        if fabric.damping > 0.0 {
            let Memory { motion, .. } = memory;
            damp::note(state.positions, state.previous, motion);
            bend::rub(&rest.bends, fabric, dt, *state.substep, motion);
            damp::solve(&rest.springs, fabric.damping, dt, state.positions, motion);
            damp::apply(state.positions, motion, state.previous);
        }
    }

    /// Lists the particles and faces that may meet a body within `dt` `[s]`.
    fn gather_bodies(&self, dt: f32, state: &StateMut<'_>, memory: &mut Memory) {
        let Self { rest, fabric, anchors, input } = *self;
        let drawn = if memory.pierced.drawn().is_empty() { 0.0 } else { FASTEST * dt };
        let skin = input.skinned.map_or(0.0, Skinned::longest_way) + drawn;
        let approach = Approach {
            dt,
            substep: *state.substep,
            gravity: input.gravity,
            thickness: fabric.thickness,
            extra: anchors.longest_way().max(skin) + input.wind.fastest() * dt + memory.pulls.reach(dt, state.positions),
        };
        memory.contacts.gather(input.bodies, state.positions, state.previous, &approach);
        let sheet = Sheet {
            topology: &rest.topology,
            longest_edge: memory.factors.longest_edge,
            positions: state.positions,
            thickness: fabric.thickness,
        };
        memory.faces.gather(input.bodies, &sheet, memory.contacts.way(), dt);
    }

    /// Begins to carry air along, if there is any use in it: where `none` is, little moves or something is drawn back.
    fn take_air(&self, none: bool, state: &StateMut<'_>, memory: &mut Memory) {
        let Self { rest, fabric, input, .. } = *self;
        // Where little moves the air does nothing, and what is drawn back to its length must get there.
        let air = if none { 0.0 } else { air::share(fabric, memory.factors.area, input.gravity.length(), input.wind.density) };
        memory.carried.begin(air, rest, state.positions);
    }

    /// Makes room for all that may be laid on bodies in a substep.
    fn make_room(&self, memory: &mut Memory) {
        let topology = &self.rest.topology;
        let lie = memory.contacts.candidates() + 3 * memory.faces.candidates().min(topology.faces.len() + topology.edges.len());
        // Before pairs and after their first pass; or in each sweep of skinned cloth, which may begin to settle in any frame.
        let times = if self.input.skinned.is_some() { SETTLING_SWEEPS } else { 2 };
        memory.provisional.begin(lie * times as usize);
    }
}

#[cfg(test)]
mod tests {
    use glam::{Vec3, vec3};

    use super::*;
    use crate::solver::anchors::Anchors;
    use crate::solver::rest::RestShape;
    use crate::solver::scene::grid;
    use crate::solver::settings::Fabric;
    use crate::solver::state::ClothState;
    use crate::solver::step::{FrameInput, prepare};
    use crate::solver::wind::Wind;

    #[test]
    fn a_time_that_has_no_parts_and_a_state_that_does_not_fit_begin_no_frame() {
        let (rest, _) = RestShape::build(&grid(4, 4, |u, v| vec3(u, 0.0, v))).expect("a sheet");
        let (fabric, anchors, stepping) = (Fabric::default(), Anchors::default(), Stepping::default());
        let positions: Vec<_> = rest.positions.iter().map(|x| x.extend(1.0)).collect();
        let begins = |dt: f32, missing: usize| {
            let previous = positions[missing..].to_vec();
            let mut state = ClothState { positions: positions.clone(), previous, ..ClothState::default() };
            let mut memory = Memory::default();
            prepare(&rest, &fabric, &anchors, &mut state, &mut memory);
            let input = FrameInput { dt, gravity: Vec3::NEG_Y, bodies: &[], wind: &Wind::STILL, skinned: None };
            let cloth = Stepped { rest: &rest, fabric: &fabric, anchors: &anchors, input };
            cloth.begin(&stepping, Some(4), &mut state.as_mut(), &mut memory);
            memory.frame.is_some()
        };
        assert!(begins(1.0 / 60.0, 0));
        assert!(!begins(f32::from_bits(1), 0), "a quarter of the shortest time is none");
        assert!(!begins(1.0 / 60.0, 1), "a particle without a position before");
        assert!(!begins(f32::NAN, 0) && !begins(0.0, 0));
    }
}
