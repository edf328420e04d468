//! Integrate: the cloths of an island side by side, substep by substep.
//!
//! ```text
//! (constrain ─► project provisionally ─► touch ─► project provisionally ─► solve ─► bodies ─► friction ─► restitution ─► CCD
//!    ─► (shorten ─► push apart ─► CCD)* )* ─► finish ─► CCD
//! ```

use glam::{Vec3, Vec3A, Vec4};

use super::{CROWDED, Island, LONGEST_LOOK, LOOK_AGAIN, Member};
use crate::solver::respond::Contacts;
use crate::solver::scales::RESPONSE_TIME;
use crate::solver::settings::Stepping;
use crate::solver::state::ClothState;
use crate::solver::step::substeps_of;

/// Turns in which what contacts stretched is shortened and kept apart again, at most. Light cloth in gusts, eight seeds at 40²:
/// 105 of 2,400 frames have an edge beyond 1.5 without, one with three, none with six.
const STRAIN_TURNS: u32 = 6;

impl Island {
    /// Steps all cloths by a frame side by side, and keeps apart what touches. A cloth that cannot be stepped stays, and the
    /// others meet it where it is.
    pub(super) fn integrate(&mut self, cloths: &mut [Member<'_>]) {
        if self.rollback.stayed() || self.rollback.restored_any() && cloths.iter().all(|m| m.cloth.stands_alone(m.scratch)) {
            // Twice as many substeps for a while, as in an integrator that rejects a step. Not on bodies where only single
            // particles were rolled back: a character's cape then was twice as often in a bone. Light cloth in gusts, eight
            // seeds each at 40² and 30²: 280 of 4,800 frames cross without it, 51 with this.
            self.refined_for = RESPONSE_TIME;
        }
        let refined = self.refined_for > 0.0;
        let (mut count, mut longest, mut fast_body) = (0, 0.0f32, false);
        for (part, m) in cloths.iter_mut().enumerate() {
            count = count.max(m.cloth.substeps(m.stepping, m.state, m.scratch));
            fast_body |= m.scratch.meets_fast_body();
            longest = longest.max(m.cloth.input.dt.min(m.stepping.max_frame));
            if refined {
                count = count.max(2 * substeps_of(m.stepping, m.cloth.input.dt));
            }
            if m.moves {
                self.rollback.forget_if_moved(&self.surface, part, &m.state.positions, m.offset);
            }
        }
        self.refined_for = (self.refined_for - longest).max(0.0);
        self.rolls_back &= self.rollback.knows();
        let most = self.most.times((longest / LONGEST_LOOK).max(1.0));
        (self.within, self.asked) = (most, most);
        self.count = count;
        // Share of the time looked ahead that passes in a substep.
        let each = if self.horizon > 0.0 { longest / (count.max(1) as f32 * self.horizon) } else { 1.0 };
        let gap = (LOOK_AGAIN * count as f32 / longest.max(f32::MIN_POSITIVE)).round().max(1.0) as u32;
        self.share = 0.0;
        let tangled = !self.contours().is_empty();
        for (part, m) in cloths.iter_mut().enumerate() {
            let range = self.surface.parts[part].particles.clone();
            let own = |p: u32| range.contains(&p).then(|| p - range.start);
            // Inner steps would draw back what untangling moves.
            let whole = Stepping { inner_rate: 0.0, ..m.stepping.clone() };
            m.cloth.begin(if tangled { &whole } else { m.stepping }, Some(count), m.state, m.scratch);
            if tangled {
                m.scratch.leave_air();
            }
            m.scratch.lies_on_cloth(self.contacts.pushes().flat_map(|(particles, ..)| particles).filter_map(own));
        }
        for n in 1..=count {
            self.contacts.age_support();
            self.note_start(cloths);
            let lies = self.lies_on_bodies(cloths);
            for m in &mut *cloths {
                m.cloth.constrain(m.state, m.scratch);
            }
            if lies {
                Self::project_provisionally(cloths);
            }
            self.keep_apart(cloths, lies);
            for (part, m) in cloths.iter_mut().enumerate() {
                m.cloth.project(m.state, m.scratch);
                let first = self.surface.parts[part].particles.start;
                let contacts = &mut self.contacts;
                let offset = m.offset.into();
                m.cloth.each_on_body(m.state, m.scratch, |p, bearing| contacts.touch_ground(first + p, bearing, offset));
            }
            self.apply_friction(cloths);
            self.apply_restitution(cloths);
            self.clamp_motion(cloths, false);
            self.limit_strain(cloths);
            self.share += each;
            if n < count {
                let often = fast_body || refined || !self.rolls_back || self.contacts.len() > CROWDED * self.surface.len();
                self.look_ahead(cloths, each, often || n % gap == 0);
            }
        }
        self.note_start(cloths);
        let crowded = !self.contacts.is_empty();
        for m in &mut *cloths {
            *m.report = m.cloth.finish(crowded, m.state, m.scratch);
        }
        // Overlong edges were shortened without heed to what is between them.
        self.clamp_motion(cloths, true);
    }

    /// Whether cloth that lies on bodies may touch cloth, so that care is to be taken of both at once. Folds of one cloth in
    /// motion cross no less without, and a sheet of 64² on a ball takes an eighth longer with it.
    fn lies_on_bodies(&self, cloths: &[Member<'_>]) -> bool {
        let parts = self.surface.parts.len();
        let lies = |m: &Member<'_>| (parts > 1 || m.scratch.is_settling()) && m.scratch.grounded().next().is_some();
        !self.contacts.is_empty() && cloths.iter().any(lies)
    }

    /// Puts what lies on bodies where they will put it.
    fn project_provisionally(cloths: &mut [Member<'_>]) {
        for m in cloths {
            m.cloth.project_provisionally(m.state, m.scratch);
        }
    }

    /// Notes where everything is that may touch, and how fast.
    fn note_start(&mut self, cloths: &[Member<'_>]) {
        if self.contacts.is_empty() {
            return;
        }
        self.contacts.begin_start();
        for (part, Member { state, offset, moves, .. }) in cloths.iter().enumerate() {
            let offset = offset.extend(0.0);
            let per_second = if *moves && state.substep > 0.0 { state.substep.recip() } else { 0.0 };
            self.contacts.note_start(part, |i| match (state.positions.get(i), state.previous.get(i)) {
                (Some(&x), Some(&old)) => (x + offset, Vec3A::from_vec4(x - old) * per_second),
                _ => (Vec4::NAN, Vec3A::ZERO),
            });
        }
    }

    /// Keeps apart what touches at the end of a substep; `lies`: cloth on bodies was laid there.
    fn keep_apart(&mut self, cloths: &mut [Member<'_>], lies: bool) {
        if self.contacts.is_empty() {
            return;
        }
        let h = cloths.iter().filter(|m| m.moves).map(|m| m.state.substep).fold(0.0, f32::max);
        let gravity = Self::gravity(cloths);
        if lies {
            self.on_pairs(cloths, |contacts| contacts.touch(h, gravity));
            // What was pushed into a body lies on it again.
            Self::project_provisionally(cloths);
            self.on_pairs(cloths, Contacts::solve);
        } else {
            self.on_pairs(cloths, |contacts| {
                contacts.touch(h, gravity);
                contacts.solve();
            });
        }
    }

    /// Shortens edges that contacts and the CCD hold far beyond the strain limit, and keeps cloth apart again, in turns.
    /// Springs draw cloth together before it touches, and in the next substep would draw it through again.
    fn limit_strain(&mut self, cloths: &mut [Member<'_>]) {
        if self.contacts.is_empty() {
            return;
        }
        for turn in 0..STRAIN_TURNS {
            let mut any = false;
            for m in cloths.iter_mut().filter(|m| m.moves) {
                any |= m.cloth.shorten_overlong(turn > 0, m.state, m.scratch);
            }
            if !any {
                return;
            }
            self.on_pairs(cloths, Contacts::push_apart);
            self.clamp_motion(cloths, false);
        }
    }

    /// Sum of what pulls the cloths that move `[m/s²]`, for its direction.
    fn gravity(cloths: &[Member<'_>]) -> Vec3 {
        cloths.iter().map(|m| if m.moves { m.cloth.input.gravity } else { Vec3::ZERO }).sum()
    }

    /// Holds pairs that slip, when bodies have pushed, too.
    fn apply_friction(&mut self, cloths: &mut [Member<'_>]) {
        if self.contacts.has_constraints() {
            self.on_pairs(cloths, Contacts::apply_friction);
        }
    }

    /// Gives what met fast in the substep its speed apart, when bodies have pushed, too: they go by where it was when the
    /// substep began.
    fn apply_restitution(&mut self, cloths: &mut [Member<'_>]) {
        if self.contacts.has_impacts() {
            self.on_pairs(cloths, Contacts::apply_restitution);
        }
    }

    /// Gathers the particles of pairs, acts on them, and gives them back to their cloths.
    fn on_pairs(&mut self, cloths: &mut [Member<'_>], act: impl FnOnce(&mut Contacts)) {
        self.gather_pairs(cloths);
        act(&mut self.contacts);
        self.scatter_pairs(cloths);
    }

    /// Takes in where the particles of pairs are and where they were when the substep began.
    fn gather_pairs(&mut self, cloths: &[Member<'_>]) {
        self.contacts.begin_gather();
        for (part, cloth) in cloths.iter().enumerate() {
            self.contacts.gather(part, |i| cloth.particle(i));
        }
    }

    /// Gives back where they are and where they were.
    fn scatter_pairs(&mut self, cloths: &mut [Member<'_>]) {
        for (part, Member { state, offset, .. }) in cloths.iter_mut().enumerate().filter(|(_, m)| m.moves) {
            let offset = offset.extend(0.0);
            self.contacts.scatter(part, |i, now, old| {
                if let (Some(x), Some(was)) = (state.positions.get_mut(i), state.previous.get_mut(i)) {
                    // What nothing touched keeps every bit.
                    if *x + offset != now {
                        *x = now - offset;
                    }
                    if *was + offset != old {
                        *was = old - offset;
                    }
                }
            });
        }
    }

    /// Stops on its way what would have passed through since [`Self::note_start`]; `finished`: on the way that
    /// [`Stepped::finish`] moved it, which gave it no speed. To be stopped there gives a settling cloth none either. For other
    /// cloth the stop is a brake: without it edges of a strip that is overwound get seven times as long.
    fn clamp_motion(&mut self, cloths: &mut [Member<'_>], finished: bool) {
        if self.contacts.is_empty() {
            return;
        }
        for (part, cloth) in cloths.iter().enumerate() {
            self.contacts.gather_end(part, |i| cloth.particle(i)[0]);
        }
        if !self.contacts.clamp_motion(&mut self.asked) {
            return;
        }
        for (part, Member { state, scratch, offset, .. }) in cloths.iter_mut().enumerate().filter(|(_, m)| m.moves) {
            let (offset, silent) = (offset.extend(0.0), finished && scratch.is_settling());
            self.contacts.scatter_clamped(part, |i, now| {
                if let (Some(x), Some(old)) = (state.positions.get_mut(i), state.previous.get_mut(i)) {
                    let to = now - offset;
                    if silent {
                        *old += to - *x;
                    }
                    *x = to;
                }
            });
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
        for ((i, part), touch) in self.surface.parts.iter().enumerate().zip(&self.touch).filter(|_| !over) {
            let Some(m) = cloths.get(i).filter(|m| m.moves) else { continue };
            if m.state.positions.len() == part.particles.len() {
                let first = part.particles.start as usize;
                let ClothState { positions, previous, .. } = &m.state;
                strayed |= self.neighbors.strayed(first, positions, previous, m.offset, next, touch.thickness);
            }
        }
        if strayed {
            for (part, m) in cloths.iter().enumerate() {
                self.gather(part, m.state, m.offset, !m.moves);
                if !m.moves {
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
