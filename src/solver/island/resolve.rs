//! Resolve: takes apart what crosses.
//!
//! ```text
//! roll back what is new ─► (advance ─► springs ─► look)* ─► undo what got worse ─► give back what moved
//!                       ─► bodies ─► stay: put back what they pushed
//! ```

use glam::{Vec3, Vec4};

use super::particles::StepParticles;
use super::{Contacts, Island, MOST_ROUNDS, Member, UntangleSettings, parts_of_contours};
use crate::solver::resolve::{Method, Untangler};
use crate::solver::rollback::{Rollback, Tangle};
use crate::solver::scales::RESPONSE_TIME;
use crate::solver::step::{displace, relax};
use crate::solver::verdict::Escalation;

/// Times [`Member::last_resort`] in which only what lies around a tangle is drawn to the pose (dimensionless). In the next one
/// all of the cloth is.
const AROUND: f32 = 4.0;

impl Island {
    /// Takes the crossings found apart in a frame of `dt` `[s]`, and gives back what moved, kept out of bodies.
    pub(super) fn resolve(&mut self, dt: f32, settings: &UntangleSettings, cloths: &mut [Member<'_>]) {
        self.limit_tangled(dt, cloths);
        self.bound(settings.effort);
        self.untangler.resolver.effort = self.most;
        self.load_in_frame(settings, cloths);
        let escalation = cloths.iter().map(|m| m.sim.display.outcome().escalation).max().unwrap_or_default();
        self.escalate(escalation);
        // What goes on at load is not done with until then.
        if self.loading.is_none() {
            self.take_apart(settings, |part, positions| {
                if let Some(m) = cloths.get_mut(part) {
                    relax(m.cloth.rest, m.cloth.fabric, &m.sim.memory, positions);
                }
            });
        }
        if escalation == Escalation::Blend {
            self.blend_members(dt, cloths);
        }
        self.give_back(cloths);
    }

    /// Draws what nothing could take apart to the animated pose, or to the shape at rest where it is.
    #[cold]
    fn blend_members(&mut self, dt: f32, cloths: &[Member<'_>]) {
        let mut pose = core::mem::take(&mut self.pose);
        for (part, m) in cloths.iter().enumerate() {
            m.pose(&mut pose);
            // First around the tangle, then more and more of the cloth.
            let whole = (m.sim.display.outcome().tangled_for / m.last_resort - AROUND).clamp(0.0, 1.0);
            self.blend(part, &pose, m.offset, dt / RESPONSE_TIME, whole);
        }
        self.pose = pose;
    }

    /// Gives what moved back to the cloths, and keeps it out of bodies.
    fn give_back(&mut self, cloths: &mut [Member<'_>]) {
        if !self.moved {
            return;
        }
        for (part, m) in cloths.iter_mut().enumerate() {
            let (fabric, bodies, offset) = (m.cloth.fabric, m.cloth.input.bodies, m.offset);
            if displace(fabric, bodies, &mut m.sim.state, &mut m.sim.memory, |state| self.scatter(part, state, offset)) {
                self.regather(part, &m.sim.state, offset);
            }
        }
        if self.stay() {
            for (part, m) in cloths.iter_mut().enumerate() {
                self.scatter(part, &mut m.sim.state, m.offset);
            }
        }
    }

    /// Takes the crossings found apart. `relax` sweeps the springs of a cloth, given its number and its positions.
    pub(super) fn take_apart(&mut self, settings: &UntangleSettings, mut relax: impl FnMut(usize, &mut [Vec4])) {
        self.can_roll_back = settings.iterations > 0 && self.total.is_clean() && !self.fixed.contains(&true);
        self.undo.forget();
        if !self.fixed.contains(&false) {
            return;
        }
        if settings.iterations > 0 {
            self.roll_back();
        }
        if self.total.is_clean() {
            self.undo.forget_least();
        }
        // Layers go to their order through whatever lies between.
        let Self { surface, untangler, undo, positions, .. } = self;
        let may_undo = settings.resolve.method == Method::ByEndType && !untangler.resolver.orders_layers();
        if may_undo && !self.total.is_clean() && untangler.detector.is_whole() {
            undo.begin(surface, positions, parts_of_contours(surface, untangler));
        }
        for i in 0..settings.iterations {
            let underway = i > 0 && self.untangler.resolver.carry_on(&mut self.positions, &mut self.previous);
            if i > 0 && !underway {
                self.look();
            }
            let Self { surface, untangler: Untangler { detector, resolver }, positions, previous, .. } = self;
            self.start.clear();
            if !self.total.is_clean() {
                self.start.extend_from_slice(positions);
                self.caught.clear();
                self.caught.resize(positions.len(), false);
                for c in detector.crossings() {
                    let ends = surface.topology.edges[c.edge as usize];
                    let corners = surface.topology.faces[c.face as usize];
                    ends.iter().chain(&corners).for_each(|&v| self.caught[v as usize] = true);
                }
            }
            // Even when clean: memories of contours that are gone are dropped, and layers may lie in the wrong order.
            let moved = underway || resolver.advance(surface, detector, positions, previous, &settings.resolve);
            self.moved |= moved;
            self.stale |= moved;
            if self.total.crossings == 0 && (!moved || settings.resolve.method.remembers_sides()) {
                break;
            }
            self.iterations += 1;
            if settings.relaxations > 0 {
                self.relax(settings.relaxations, &mut relax);
                // Many iterations are much work, however little there is to be taken apart.
                let sweeps = settings.relaxations as usize * self.surface.topology.faces.len();
                self.untangler.resolver.effort.spend(sweeps);
            }
            self.keep_others_apart();
            if self.untangler.resolver.effort.is_spent() {
                break;
            }
        }
        self.undo_what_got_worse();
    }

    fn undo_what_got_worse(&mut self) {
        if !self.undo.is_due() {
            return;
        }
        if self.stale {
            self.look();
        }
        let Self { surface, untangler, undo, positions, previous, .. } = self;
        // A look at a part of the cloth does not tell which cloths got worse.
        if !untangler.detector.is_whole() {
            return;
        }
        let any = undo.end(surface, parts_of_contours(surface, untangler), positions, previous);
        let mut undone = any;
        // One more cloth each time, as long as there may be work. What then crosses one that was put back, the next frame takes
        // apart.
        while undone && !self.untangler.resolver.effort.is_spent() {
            self.look();
            let Self { surface, untangler, undo, positions, previous, .. } = self;
            undone = undo.follow(surface, parts_of_contours(surface, untangler), positions, previous);
        }
        self.stale = undone;
        if any {
            let Self { surface, untangler, undo, .. } = self;
            untangler.resolver.give_up_plans(|v| undo.has_undone(surface.part(v)));
        }
    }

    /// Stops what would pass, on its way out of a tangle, through cloth that has no part in it.
    fn keep_others_apart(&mut self) {
        if self.contacts.is_empty() || self.start.len() != self.positions.len() {
            return;
        }
        let Self { surface, contacts, particles, positions, previous, start, weights, weighed, caught, asked, .. } = self;
        // Pairs know each cloth in its frame of simulation.
        let StepParticles { positions: now, previous: old } = &mut **particles;
        let offset = |contacts: &Contacts, v: usize| contacts.offset(surface.part(v as u32)).extend(0.0);
        for (own, all) in [(&mut *old, &**start), (&mut *now, &*positions)] {
            own.clear();
            own.extend(all.iter().enumerate().map(|(v, x)| *x - offset(contacts, v)));
        }
        contacts.note_start(old, old, 0.0);
        // Weights of a tangle that was taken apart long ago say nothing.
        let weights = if *weighed { weights.as_slice() } else { &[] };
        let tangled =
            |ids: &[u32]| ids.iter().any(|&v| caught[v as usize] || weights.get(v as usize).is_some_and(|&w| w > 0.0));
        if contacts.clamp_motion_of_few(now, asked, |a, b| tangled(a) && tangled(b)) {
            for v in contacts.stopped() {
                let x = now[v] + offset(contacts, v);
                previous[v] += x - positions[v];
                positions[v] = x;
            }
        }
    }

    /// Rolls back what crosses since the last frame, if that ended clean and cloth is to be kept apart.
    fn roll_back(&mut self) {
        if !self.takes_part.contains(&true) || self.total.is_clean() {
            return;
        }
        let Self { surface, rollback, positions, previous, takes_part, count, .. } = self;
        if !rollback.begin(surface, positions, previous, takes_part, *count) {
            return;
        }
        self.put_back(MOST_ROUNDS, true, Rollback::restore_relative);
        // What touched before may cross by rounding.
        self.put_back(MOST_ROUNDS, true, Rollback::restore_exactly);
        self.put_back(MOST_ROUNDS, true, Rollback::follow_pins);
        self.put_back_whole();
    }

    /// Puts crossing cloth back and looks again, until nothing is left to put. It ends after `rounds` rounds, or when the work
    /// of the frame is spent, if it is `bounded`. Returns whether anything was put back.
    fn put_back(
        &mut self,
        rounds: usize,
        bounded: bool,
        put: impl Fn(&mut Rollback, &Tangle<'_>, &mut [Vec4], &mut [Vec4]) -> bool,
    ) -> bool {
        let mut any = false;
        for _ in 0..rounds {
            let Self { surface, untangler, rollback, positions, previous, .. } = self;
            if self.total.is_clean() || bounded && untangler.resolver.effort.is_spent() {
                break;
            }
            let Untangler { detector, resolver } = &*untangler;
            let tangle = Tangle { surface, crossings: detector.crossings(), graph: resolver.graph() };
            if !put(rollback, &tangle, positions, previous) {
                break;
            }
            (any, self.moved) = (true, true);
            self.look();
        }
        any
    }

    /// For the case that bodies pushed what was rolled back, and something crosses again. The crossing particles go to the very
    /// place where they were when nothing crossed, or the cloths that cross as a whole. Bodies take what went into them with its
    /// pins out in the next frame. Returns whether anything was put back, and is to be [scattered](Self::scatter) once more.
    pub(super) fn stay(&mut self) -> bool {
        if !(self.stale && self.rollback.rolls_back()) {
            return false;
        }
        self.look();
        let there = self.put_back(MOST_ROUNDS, true, Rollback::restore_exactly);
        self.put_back_whole() || there
    }

    /// Puts the cloths that cross back as a whole, whatever work that is. A cloth that was put back may be met by one that went
    /// on.
    fn put_back_whole(&mut self) -> bool {
        let rounds = self.surface.parts.len().min(MOST_ROUNDS);
        let any = self.put_back(rounds, false, Rollback::follow_pins_whole);
        self.put_back(rounds, false, Rollback::restore_whole) || any
    }

    /// Uses stronger means from now on; `None` goes back to the ordinary ones.
    pub(super) fn escalate(&mut self, escalation: Escalation) {
        self.untangler.resolver.escalate(escalation);
    }

    /// Looks at the order of layers of all particles in the next iteration, not only of a few.
    pub(super) fn inspect_layers(&mut self) {
        self.untangler.resolver.inspect_layers();
    }

    /// Draws the tangled particles of cloth `part` to a pose `[m]` in the cloth's own frame, by a fraction of the way:
    /// [`Escalation::Blend`]. Weights are those of the last [`Self::evaluate`]; all others weigh at least `least`.
    pub(super) fn blend(&mut self, part: usize, pose: &[Vec3], offset: Vec3, fraction: f32, least: f32) {
        let range = self.range(part);
        if pose.len() != range.len() || self.weights.len() != self.positions.len() || self.total.is_clean() {
            return;
        }
        for (i, &to) in range.zip(pose) {
            let by = (to + offset - self.positions[i].truncate()) * (fraction * self.weights[i].max(least)).clamp(0.0, 1.0);
            if by != Vec3::ZERO && by.is_finite() && self.positions[i].w > 0.0 {
                self.positions[i] += by.extend(0.0);
                self.previous[i] += by.extend(0.0);
                (self.moved, self.stale) = (true, true);
            }
        }
    }

    /// Sweeps the springs of every cloth; previous positions go along, so that no velocity comes of it.
    fn relax(&mut self, sweeps: u32, relax: &mut impl FnMut(usize, &mut [Vec4])) {
        (*self.before).clone_from(&self.positions);
        for part in (0..self.surface.parts.len()).filter(|&part| !self.fixed[part]) {
            let range = self.range(part);
            for _ in 0..sweeps {
                relax(part, &mut self.positions[range.clone()]);
            }
        }
        for ((old, now), before) in self.previous.iter_mut().zip(&self.positions).zip(self.before.iter()) {
            if now != before {
                *old += *now - *before;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{Quat, Vec3, Vec4, vec3};

    use crate::solver::evaluate::EvaluateSettings;
    use crate::solver::island::UntangleSettings;
    use crate::solver::rest::RestShape;
    use crate::solver::scene::{Scene, SceneCloth, Untangling, grid};
    use crate::solver::settings::Fabric;

    const FRAME: f32 = 1.0 / 60.0;

    #[test]
    fn what_a_body_pushes_into_a_crossing_again_stays_with_its_cloth_and_loses_its_speed_against_it() {
        let sheet = |k: f32| {
            let turn = Quat::from_rotation_y(core::f32::consts::FRAC_PI_4 * k);
            let mesh = grid(12, 12, |u, v| turn * vec3(u - 0.5, 0.0, v - 0.5));
            let (rest, _) = RestShape::build(&mesh).expect("a sheet");
            SceneCloth::new(Arc::new(rest), Fabric::default(), vec3(0.004 * k, 0.4 + 0.03 * k, 0.003 * k), &[])
        };
        let scene = Scene::new(vec![sheet(0.0), sheet(1.0)]);
        let scene = scene.untangled(UntangleSettings::default(), EvaluateSettings::default(), true);
        let mut scene = scene.expect("two sheets");
        scene.step(FRAME);
        let upper = usize::from(scene.cloths[0].sim.state.positions[0].y < scene.cloths[1].sim.state.positions[0].y);
        let clean: Vec<_> = scene.cloths.iter().map(|c| c.sim.state.clone()).collect();
        let positions = &clean[upper].positions;
        let centre = positions.iter().map(|x| x.truncate()).sum::<Vec3>() / positions.len() as f32;
        let off = |&v: &usize| positions[v].truncate().distance(centre);
        let v = (0..positions.len()).min_by(|a, b| off(a).total_cmp(&off(b))).expect("particles");
        let gap = (clean[0].positions[0] - clean[1].positions[0]).y.abs();
        // It flies on through the other sheet, is rolled back, and pushed there again.
        let mut crossed = clean.clone();
        crossed[upper].positions[v] += vec3(0.0, -2.0 * gap, 0.0).extend(0.0);
        crossed[upper].previous[v].y = crossed[upper].positions[v].y + gap;
        let Some(Untangling { island, settings, .. }) = &mut scene.untangle else { panic!("it untangles") };
        (0..2).for_each(|part| island.gather(part, &crossed[part], Vec3::ZERO, false));
        assert!(island.detect_gathered().crossings > 0);
        island.take_apart(settings, |_, _| ());
        (0..2).for_each(|part| island.regather(part, &crossed[part], Vec3::ZERO));
        assert!(island.stay());
        let mut after = crossed;
        (0..2).for_each(|part| island.scatter(part, &mut after[part], Vec3::ZERO));
        island.evaluate();
        assert!(island.total().is_clean());
        for (after, clean) in after.iter().zip(&clean) {
            let off = |(a, b): (&Vec4, &Vec4)| a.distance(*b);
            let farthest = after.positions.iter().zip(&clean.positions).map(off).fold(0.0, f32::max);
            assert!(farthest < 1e-5 * gap.max(1.0), "{farthest}");
        }
        assert!(after[upper].velocity(v).length() < 0.1 * gap / after[upper].substep, "{}", after[upper].velocity(v));
    }
}
