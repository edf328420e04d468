//! Integrate: the cloths of an island side by side, substep by substep.
//!
//! ```text
//! (constrain ─► project provisionally ─► touch ─► project provisionally ─► solve ─► bodies ─► friction ─► restitution ─► CCD
//!    ─► (shorten ─► push apart ─► CCD)* )* ─► finish ─► CCD
//! ```

use glam::Vec3;

use super::particles::StepParticles;
use super::{CROWDED, Island, LONGEST_LOOK, LOOK_AGAIN, Member};
use crate::solver::scales::RESPONSE_TIME;
use crate::solver::settings::Stepping;
use crate::solver::state::StateMut;
use crate::solver::step::{Memory, Stepped, substeps_of};

/// Turns in which what contacts stretched is shortened and kept apart again, at most. Light cloth in gusts, eight seeds at 40²:
/// 105 of 2,400 frames have an edge beyond 1.5 without, one with three, none with six.
const STRAIN_TURNS: u32 = 6;

impl Island {
    /// Steps all cloths by a frame side by side, and keeps apart what touches. A cloth that cannot be stepped stays, and the
    /// others meet it where it is.
    pub(super) fn integrate(&mut self, cloths: &mut [Member<'_>]) {
        let (longest, careful) = self.count_substeps(cloths);
        let count = self.count;
        // Share of the time looked ahead that passes in a substep.
        let each = if self.horizon > 0.0 { longest / (count.max(1) as f32 * self.horizon) } else { 1.0 };
        let gap = (LOOK_AGAIN * count as f32 / longest.max(f32::MIN_POSITIVE)).round().max(1.0) as u32;
        self.begin(longest, cloths);
        for n in 1..=count {
            self.contacts.age_support();
            self.note_start(cloths);
            let lies = self.lies_on_bodies(cloths);
            self.for_each(cloths, |cloth, state, memory| _ = cloth.constrain(state, memory));
            if lies {
                self.project_provisionally(cloths);
            }
            self.keep_apart(cloths, lies);
            self.project(cloths);
            self.apply_friction();
            self.apply_restitution();
            self.clamp_motion();
            self.limit_strain(cloths);
            self.share += each;
            if n < count {
                let often = careful || !self.can_roll_back || self.contacts.len() > CROWDED * self.surface.len();
                self.look_ahead(cloths, each, often || n % gap == 0);
            }
        }
        self.note_start(cloths);
        self.finish(cloths);
        debug_assert!(self.particles.are_whole(&self.surface));
        self.particles.publish(&self.surface, cloths);
    }

    /// Counts the substeps, of which all take as many as the one that needs most. Returns the longest of their frames `[s]`,
    /// and whether stray cloth is to be looked for in every substep.
    fn count_substeps(&mut self, cloths: &mut [Member<'_>]) -> (f32, bool) {
        if self.rollback.stayed() || self.rollback.restored_any() && cloths.iter().all(|m| m.cloth.stands_alone(&m.sim.memory))
        {
            // Twice as many substeps for a while, as in an integrator that rejects a step. Not on bodies where only single
            // particles were rolled back: a character's cape then was twice as often in a bone. Light cloth in gusts, eight
            // seeds each at 40² and 30²: 280 of 4,800 frames cross without it, 51 with this.
            self.refined_for = RESPONSE_TIME;
        }
        let refined = self.refined_for > 0.0;
        let (mut longest, mut fast_body) = (0.0f32, false);
        self.count = 0;
        for m in cloths {
            let count = m.cloth.substeps(m.stepping, &m.sim.state.positions, &mut m.sim.memory);
            let least = if refined { 2 * substeps_of(m.stepping, m.cloth.input.dt) } else { 0 };
            self.count = self.count.max(count).max(least);
            fast_body |= m.sim.memory.meets_fast_body();
            longest = longest.max(m.cloth.input.dt.min(m.stepping.max_frame));
        }
        self.refined_for = (self.refined_for - longest).max(0.0);
        (longest, fast_body || refined)
    }

    /// Begins a frame of `dt` `[s]`: takes all cloths in, and lets each find what it needs once.
    fn begin(&mut self, dt: f32, cloths: &mut [Member<'_>]) {
        self.follow(cloths);
        self.can_roll_back &= self.rollback.knows();
        let most = self.most.times((dt / LONGEST_LOOK).max(1.0));
        (self.within, self.asked, self.share) = (most, most, 0.0);
        let (count, tangled) = (self.count, !self.contours().is_empty());
        self.contacts.set_offsets(cloths.iter().map(|m| m.offset));
        self.particles.take_in(&self.surface, cloths);
        debug_assert!(self.particles.are_whole(&self.surface));
        for (part, m) in self.surface.parts.iter().zip(cloths) {
            // Inner steps would draw back what untangling moves.
            let whole = Stepping { inner_rate: 0.0, ..m.stepping.clone() };
            let stepping = if tangled { &whole } else { m.stepping };
            self.particles.with(part, m, |cloth, state, memory| cloth.begin(stepping, Some(count), state, memory));
            if tangled {
                m.sim.memory.leave_air();
            }
            let own = |p: u32| part.particles.contains(&p).then(|| p - part.particles.start);
            m.sim.memory.lies_on_cloth(self.contacts.pushes().flat_map(|(particles, ..)| particles).filter_map(own));
        }
    }

    /// Calls `act` with each cloth and its particles.
    fn for_each(&mut self, cloths: &mut [Member<'_>], act: impl Fn(&Stepped<'_>, &mut StateMut<'_>, &mut Memory)) {
        for (part, m) in self.surface.parts.iter().zip(cloths) {
            self.particles.with(part, m, &act);
        }
    }

    /// Puts what lies on bodies where they will put it.
    fn project_provisionally(&mut self, cloths: &mut [Member<'_>]) {
        self.for_each(cloths, |cloth, state, memory| {
            cloth.project_provisionally(state, memory);
        });
    }

    /// Keeps all cloths out of bodies, and notes what lies on those.
    fn project(&mut self, cloths: &mut [Member<'_>]) {
        let Self { surface, particles, contacts, .. } = self;
        for (part, m) in surface.parts.iter().zip(cloths) {
            particles.with(part, m, |cloth, state, memory| {
                cloth.project(state, memory);
                cloth.each_on_body(state, memory, |p, bearing| contacts.touch_ground(part.particles.start + p, bearing));
            });
        }
    }

    /// Ends the frame of all cloths. Overlong edges are shortened without heed to what is between them; what would pass through
    /// is stopped on that way. It gave no speed. To be stopped there gives a settling cloth none either. For other cloth the
    /// stop is a brake: without it edges of a strip that is overwound get seven times as long.
    fn finish(&mut self, cloths: &mut [Member<'_>]) {
        let crowded = !self.contacts.is_empty();
        for (part, m) in self.surface.parts.iter().zip(&mut *cloths) {
            m.sim.report = self.particles.with(part, m, |cloth, state, memory| cloth.finish(crowded, state, memory)).flatten();
        }
        if crowded {
            (*self.before).clone_from(&self.particles.positions);
        }
        // Only what was shortened moved.
        if crowded && self.contacts.clamp_motion_of_few(&mut self.particles.positions, &mut self.asked, |_, _| false) {
            let StepParticles { positions: now, previous: old } = &mut *self.particles;
            for p in self.contacts.stopped() {
                let m = &cloths[usize::from(self.surface.part(p as u32))];
                if m.sim.memory.is_settling() {
                    old[p] += now[p] - self.before[p];
                }
            }
        }
    }

    /// Whether cloth that lies on bodies may touch cloth, so that care is to be taken of both at once. Folds of one cloth in
    /// motion cross no less without, and a sheet of 64² on a ball takes an eighth longer with it.
    fn lies_on_bodies(&self, cloths: &[Member<'_>]) -> bool {
        let parts = self.surface.parts.len();
        let lies = |m: &Member<'_>| (parts > 1 || m.sim.memory.is_settling()) && m.sim.memory.grounded().next().is_some();
        !self.contacts.is_empty() && cloths.iter().any(lies)
    }

    /// Notes where everything is, and how fast.
    fn note_start(&mut self, cloths: &[Member<'_>]) {
        if self.contacts.is_empty() {
            return;
        }
        let (StepParticles { positions, previous }, h) = (&*self.particles, Self::substep(cloths));
        self.contacts.note_start(positions, previous, h);
        for (part, m) in self.surface.parts.iter().zip(cloths).filter(|(_, m)| m.moves && m.sim.state.substep != h) {
            let share = if m.sim.state.substep > 0.0 { h / m.sim.state.substep } else { 0.0 };
            self.contacts.scale_motion(part.range(), share);
        }
    }

    /// Keeps apart what touches at the end of a substep; `lies`: cloth on bodies was laid there.
    fn keep_apart(&mut self, cloths: &mut [Member<'_>], lies: bool) {
        if self.contacts.is_empty() {
            return;
        }
        let StepParticles { positions: now, previous: old } = &mut *self.particles;
        self.contacts.touch(Self::substep(cloths), &self.touch, Self::gravity(cloths), now, old);
        if lies {
            // What was pushed into a body lies on it again.
            self.project_provisionally(cloths);
        }
        let StepParticles { positions: now, previous: old } = &mut *self.particles;
        self.contacts.solve(now, old);
    }

    /// Shortens edges that contacts and the CCD hold far beyond the strain limit, and keeps cloth apart again, in turns.
    /// Springs draw cloth together before it touches, and in the next substep would draw it through again.
    fn limit_strain(&mut self, cloths: &mut [Member<'_>]) {
        if self.contacts.is_empty() {
            return;
        }
        for turn in 0..STRAIN_TURNS {
            let mut any = false;
            for (part, m) in self.surface.parts.iter().zip(&mut *cloths) {
                let shorten = |cloth: &Stepped<'_>, state: &mut StateMut<'_>, memory: &mut Memory| {
                    cloth.shorten_overlong(turn > 0, state, memory)
                };
                any |= self.particles.with(part, m, shorten) == Some(true);
            }
            if !any {
                return;
            }
            self.contacts.push_apart(&mut self.particles.positions);
            self.contacts.clamp_motion_again(&mut self.particles.positions, &mut self.asked);
        }
    }

    /// The longest of the last substeps of the cloths that move `[s]`.
    fn substep(cloths: &[Member<'_>]) -> f32 {
        cloths.iter().filter(|m| m.moves).map(|m| m.sim.state.substep).fold(0.0, f32::max)
    }

    /// Sum of what pulls the cloths that move `[m/s²]`, for its direction.
    fn gravity(cloths: &[Member<'_>]) -> Vec3 {
        cloths.iter().map(|m| if m.moves { m.cloth.input.gravity } else { Vec3::ZERO }).sum()
    }

    /// Holds pairs that slip, when bodies have pushed, too.
    fn apply_friction(&mut self) {
        let StepParticles { positions: now, previous: old } = &mut *self.particles;
        self.contacts.apply_friction(now, old);
    }

    /// Gives what met fast in the substep its speed apart, when bodies have pushed, too: they go by where it was when the
    /// substep began.
    fn apply_restitution(&mut self) {
        let StepParticles { positions: now, previous: old } = &mut *self.particles;
        self.contacts.apply_restitution(now, old);
    }

    /// Stops on its way what would have passed through since [`Self::note_start`].
    fn clamp_motion(&mut self) {
        if !self.contacts.is_empty() {
            self.contacts.clamp_motion(&mut self.particles.positions, &mut self.asked);
        }
    }

    /// Looks for pairs again everywhere when the time looked ahead is up. Before that only when it is `due`, and where cloth
    /// will leave the place foreseen for it in the next substep. The next substep takes a share `each` of the time looked
    /// ahead.
    fn look_ahead(&mut self, cloths: &[Member<'_>], each: f32, due: bool) {
        let (next, over) = (self.share + each, self.share + 0.5 * each > 1.0);
        if !over && (!due || self.within.is_spent()) {
            return;
        }
        let mut strayed = over;
        for ((part, m), touch) in self.surface.parts.iter().zip(cloths).zip(&self.touch) {
            if !over && m.is_stepped(part) {
                let [positions, previous] = self.particles.of(part);
                strayed |= self.neighbors.strayed(part.range().start, positions, previous, m.offset, next, touch.thickness);
            }
        }
        if strayed {
            for (part, m) in cloths.iter().enumerate() {
                if m.is_stepped(&self.surface.parts[part]) {
                    self.gather_stepped(part, m);
                } else {
                    self.gather(part, &m.sim.state, m.offset, true);
                    self.hold(part);
                }
            }
            if over {
                self.share = 0.0;
            }
            self.find(!over);
            if over {
                // Not before: the look asks how far the motion since the last time lasts.
                self.neighbors.note(&self.positions);
            }
        }
    }
}
