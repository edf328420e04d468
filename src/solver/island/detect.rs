//! Detect, evaluate and respond: where cloths cross, and what may touch.

use super::{Island, LONGEST_LOOK, Member, RINGS, parts_of_contours};
use crate::solver::body::Touch;
use crate::solver::resolve::Untangler;
use crate::solver::respond::Moment;
use crate::solver::verdict::Verdict;

impl Island {
    /// Takes in where the cloths are after they were stepped. Then looks for crossings, and for pairs that may touch in the
    /// next frame, the longest of the frames that the cloths will take.
    pub(super) fn detect(&mut self, cloths: &[Member<'_>]) {
        core::mem::swap(&mut self.touch, &mut *self.touch_before);
        core::mem::swap(&mut self.takes_part, &mut *self.took_part);
        self.touch.clear();
        self.takes_part.clear();
        self.contacts.set_offsets(cloths.iter().map(|m| m.offset));
        let mut longest = 0.0f32;
        for (part, m) in cloths.iter().enumerate() {
            self.gather_member(part, m);
            self.takes_part.push(m.contact);
            self.touch.push(Touch::of(m.cloth.fabric));
            longest = longest.max(m.clock.min(m.stepping.max_frame));
        }
        self.known &= self.touch == *self.touch_before && self.takes_part == *self.took_part;
        // While no time passes, the length of the next frame is not known.
        if longest > 0.0 {
            self.horizon = self.neighbors.horizon(longest.min(LONGEST_LOOK), longest / self.count.max(1) as f32, &self.touch);
        }
        (self.share, self.looks) = (0.0, 0);
        self.detect_gathered();
    }

    /// Looks for crossings as the cloths lie, and for nothing else: nothing will be moved.
    #[cfg(feature = "lab")]
    pub(crate) fn inspect(&mut self, cloths: &[Member<'_>]) -> Verdict {
        for (part, m) in cloths.iter().enumerate().take(self.surface.parts.len()) {
            self.gather_member(part, m);
        }
        self.detect_gathered()
    }

    /// Finds the pairs that may touch before the next frame, unless [`Self::detect`] found them and nothing moved since. Pairs
    /// of a tangle are left out.
    pub(super) fn respond(&mut self) {
        if self.looks == 0 || self.moved || !self.crossings().is_empty() {
            self.share = 0.0;
            if self.total.is_clean() {
                let Self { contacts, rollback, .. } = self;
                contacts.clear_inverted(|v| rollback.was_restored(v));
            }
            self.find(false);
        }
        self.neighbors.note(&self.positions);
    }

    /// Finds the pairs that may touch until the horizon: all, or those of particles that strayed.
    pub(super) fn find(&mut self, strayed: bool) {
        self.looks += 1;
        self.known &= strayed;
        if self.touch.len() != self.surface.parts.len() || !self.takes_part.contains(&true) {
            self.contacts.clear();
            return;
        }
        let Self { surface, untangler, neighbors, contacts, weights, pinned, .. } = self;
        let clean = untangler.detector.crossings().is_empty();
        let takes_part = &self.takes_part;
        let tangled = |v: u32| if clean { 0.0 } else { weights.get(v as usize).copied().unwrap_or_default() };
        let (positions, previous, substep, touch) = (&self.positions, &self.previous, &self.substep, &self.touch);
        let (most, jobs) = (self.most, self.jobs.as_deref());
        let moment = Moment { positions, previous, substep, touch, takes_part, pinned, most, jobs };
        let tree = untangler.detector.tree();
        if strayed {
            let (share, rest) = (self.share, self.horizon * (1.0 - self.share));
            neighbors.update_strayed(surface, tree, &moment, share, rest, tangled, contacts);
            self.within.spend(neighbors.visits());
        } else {
            neighbors.find(surface, tree, &moment, self.horizon, tangled, contacts);
        }
    }

    /// Looks for crossings in what was gathered.
    pub(super) fn detect_gathered(&mut self) -> Verdict {
        self.moved = false;
        self.iterations = 0;
        if self.touch.len() != self.surface.parts.len() || !self.takes_part.contains(&true) {
            self.contacts.clear();
            (self.stale, self.known) = (false, false);
            self.total = self.untangler.look_again(&self.surface, &self.positions);
            self.sum_up();
        } else if self.crossings().is_empty() {
            if !self.look_where_drifted() {
                self.look_and_find();
            }
        } else {
            // Still tangled, most likely: what may touch is found when nothing moves any more.
            self.look();
        }
        self.total
    }

    /// Looks for crossings and, at the same pairs of faces until something crosses, for what may touch.
    fn look_and_find(&mut self) {
        let Self { surface, untangler, neighbors, contacts, positions, previous, substep, touch, takes_part, pinned, .. } =
            self;
        let (most, jobs) = (self.most, self.jobs.as_deref());
        let moment = Moment { positions, previous, substep, touch, takes_part, pinned, most, jobs };
        let crossings = neighbors.find_and_detect(surface, &mut untangler.detector, &moment, self.horizon, contacts);
        self.total = untangler.resolver.analyse(surface, crossings, positions);
        self.looks = 1;
        self.stale = false;
        // Of a cloth that was left out nothing is known.
        let detector = &untangler.detector;
        let all = detector.is_whole()
            && !neighbors.is_cut()
            && (0..surface.parts.len()).all(|part| !detector.is_quarantined(part as u16));
        self.sum_up();
        self.known = all && self.crossings().is_empty();
    }

    /// The same, where cloth has hardly moved since the last time. Only faces that were close then can cross, and only for
    /// cloth that moved pairs are looked for anew. False where cloth has moved farther, or something crosses.
    fn look_where_drifted(&mut self) -> bool {
        let Self { surface, untangler, neighbors, contacts, positions, previous, substep, touch, takes_part, pinned, .. } =
            self;
        let (most, jobs) = (self.most, self.jobs.as_deref());
        let moment = Moment { positions, previous, substep, touch, takes_part, pinned, most, jobs };
        let detector = &mut untangler.detector;
        if !(self.known && neighbors.refresh(surface, detector.tree(), &moment, self.horizon, |_| 0.0, contacts))
            || neighbors.is_cut()
        {
            return false;
        }
        let crossings = detector.detect_among(surface, positions, contacts.close_faces());
        if !crossings.is_empty() {
            return false;
        }
        self.total = untangler.resolver.analyse(surface, crossings, positions);
        self.looks = 1;
        self.stale = false;
        self.sum_up();
        true
    }

    /// Looks again if something moved, and weighs how much each particle belongs to a tangle.
    pub(super) fn evaluate(&mut self) {
        self.worked = self.untangler.resolver.effort.spent();
        self.untangler.resolver.effort = self.most;
        if self.stale {
            self.look();
        }
        self.weighed = !self.crossings().is_empty();
        if self.weighed {
            let Untangler { detector, resolver } = &mut self.untangler;
            resolver.mark(&self.surface, detector.crossings(), &self.positions, RINGS, &mut self.weights);
        }
        // What starts in the same place has no side yet; what came to touch has one. What no contact keeps apart is not rolled
        // back.
        let touches = self.takes_part.contains(&true);
        let clean = touches && self.total.is_clean() && (self.rollback.knows() || !self.contacts.coincide());
        self.rollback.note(&self.surface, &self.positions, &self.previous, clean);
    }

    pub(super) fn look(&mut self) {
        (self.stale, self.known) = (false, false);
        self.total = self.untangler.look(&self.surface, &self.positions);
        let Untangler { detector, resolver } = &mut self.untangler;
        resolver.effort.spend(self.surface.topology.faces.len() + detector.visits());
        self.sum_up();
    }

    /// Gives each cloth its share of the verdict.
    fn sum_up(&mut self) {
        let elsewhere = self.untangler.detector.elsewhere();
        self.total.elsewhere = elsewhere;
        self.verdicts.fill(Verdict { elsewhere, ..Verdict::default() });
        self.authored.fill(0);
        if self.crossings().is_empty() {
            return;
        }
        let Self { surface, untangler, pinned, held, .. } = self;
        self.total = Verdict { elsewhere, ..untangler.leave_held(surface, |v| pinned[v as usize] || held[v as usize]) };
        for (contour, [a, b]) in parts_of_contours(&self.surface, &self.untangler) {
            for part in [Some(a), (a != b).then_some(b)].into_iter().flatten().map(usize::from) {
                if contour.authored {
                    self.authored[part] += contour.count;
                } else {
                    self.verdicts[part].add(contour);
                }
            }
        }
    }
}
