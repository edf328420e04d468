//! What an island takes in of its cloths between the stages, and gives back. Each cloth lives in a frame of its own; `offset`
//! brings it into that of the island. It is 0 for the only cloth of an island, and changes no bit.

use glam::{Vec3, Vec4};

use super::{Island, Member};
use crate::solver::state::ClothState;

impl Island {
    pub(super) fn gather_member(&mut self, part: usize, m: &Member<'_>) {
        self.gather(part, &m.sim.state, m.offset, m.fixed);
        let range = self.range(part);
        match m.cloth.input.skinned.filter(|skinned| skinned.limits(range.len())) {
            Some(skinned) => {
                let thickness = self.surface.parts[part].thickness;
                for (i, held) in self.held[range].iter_mut().enumerate() {
                    *held = m.sim.memory.tangled_limits.distance(skinned, i) < thickness;
                }
            }
            None => self.held[range].fill(false),
        }
        if m.still {
            self.hold(part);
        }
    }

    /// Takes over the state of cloth `part`, moved by `offset` `[m]`. A `fixed` cloth is an obstacle for the others and never
    /// moved.
    pub(super) fn gather(&mut self, part: usize, state: &ClothState, offset: Vec3, fixed: bool) {
        let range = self.range(part);
        if state.positions.len() != range.len() || state.previous.len() != range.len() {
            return;
        }
        self.substep[part] = state.substep;
        self.fixed[part] = fixed;
        self.untangler.detector.set_moving(part, fixed && state.positions.iter().any(|x| x.w > 0.0));
        let to = [&mut self.positions[range.clone()], &mut self.previous[range.clone()]];
        put(to, &mut self.pinned[range], [&state.positions, &state.previous], offset, fixed);
    }

    /// Takes over a cloth that is being stepped.
    pub(super) fn gather_stepped(&mut self, part: usize, m: &Member<'_>) {
        self.substep[part] = m.sim.state.substep;
        self.fixed[part] = false;
        self.untangler.detector.set_moving(part, false);
        let Self { surface, particles, positions, previous, pinned, .. } = self;
        let (of, range) = (&surface.parts[part], surface.parts[part].range());
        let to = [&mut positions[range.clone()], &mut previous[range.clone()]];
        put(to, &mut pinned[range], particles.of(of), m.offset, false);
    }

    /// Says that cloth `part`, as gathered, stays where it is, whatever speed it had when it was stopped.
    pub(super) fn hold(&mut self, part: usize) {
        self.substep[part] = 0.0;
        self.untangler.detector.set_moving(part, false);
    }

    /// Gives what was moved back to cloth `part`; the inverse of [`Self::gather`]. Particles that did not move keep every bit.
    pub(super) fn scatter(&self, part: usize, state: &mut ClothState, offset: Vec3) {
        let range = self.range(part);
        if !self.moved || state.positions.len() != range.len() || state.previous.len() != range.len() {
            return;
        }
        let put = |states: &mut [Vec4], mine: &[Vec4]| {
            for (to, from) in states.iter_mut().zip(mine) {
                if to.truncate() + offset != from.truncate() && from.is_finite() {
                    *to = (from.truncate() - offset).extend(to.w);
                }
            }
        };
        put(&mut state.positions, &self.positions[range.clone()]);
        put(&mut state.previous, &self.previous[range]);
    }

    /// Takes over again what was [scattered](Self::scatter) and moved on.
    pub(super) fn regather(&mut self, part: usize, state: &ClothState, offset: Vec3) {
        self.gather(part, state, offset, self.fixed[part]);
        (self.moved, self.stale) = (true, true);
    }
}

/// Puts the particles of a cloth, moved by `offset` `[m]`, and notes which are pinned. What is `fixed` gets an infinite mass.
fn put(to: [&mut [Vec4]; 2], pinned: &mut [bool], from: [&[Vec4]; 2], offset: Vec3, fixed: bool) {
    let ([positions, previous], [now, old], offset) = (to, from, offset.extend(0.0));
    for ((to, pinned), from) in positions.iter_mut().zip(pinned).zip(now) {
        *to = *from + offset;
        *pinned = from.w == 0.0;
        if fixed {
            to.w = 0.0;
        }
    }
    for (to, from) in previous.iter_mut().zip(old) {
        *to = *from + offset;
    }
}
