//! One particle against one part of a body in one substep: where it may be, and how it gets there.

use glam::{Mat3A, Vec3A};

use super::Candidate;
use super::part::{Particles, Setting};
use crate::solver::body::distance::Sample;
use crate::solver::body::respond::{Plane, Projection, mean_load, push_out};
use crate::solver::body::squeeze::Squeezes;
use crate::solver::body::sweep::{Swept, plane_at, sweep};
use crate::solver::scales::TOUCHING;

/// A particle that was moved farther than `MOVED` between substeps has to be looked at. One that was moved `TELEPORTED` or
/// farther was put where it is, and is not looked at. Both are in units of the distance kept (dimensionless).
const MOVED: f32 = 0.1;
const TELEPORTED: f32 = 16.0;

impl Setting<'_> {
    /// Resolves the contact of the particle of candidate number `k`; whether it has one.
    #[inline]
    pub(super) fn meet<const COSTLY: bool>(
        &mut self,
        k: usize,
        candidate: &mut Candidate,
        particles: &mut Particles<'_>,
        [to_body0, to_body1]: [Mat3A; 2],
        sample: &impl Fn(Vec3A, f32) -> Sample,
    ) -> bool {
        let inset = candidate.inset;
        let sample = &|q: Vec3A, reach: f32| sample(q, reach).deeper(inset);
        let band = TOUCHING * self.keep;
        let i = candidate.particle as usize;
        let (Some(position), Some(before)) = (particles.positions.get_mut(i), particles.previous.get_mut(i)) else {
            return false;
        };
        let x1 = Vec3A::from_vec4(*position);
        let x0 = Vec3A::from_vec4(*before);
        // The path relative to the body is no longer than this.
        let way = (x1 - x0).length();
        let path_bound = way + self.motion.way;
        let q1 = to_body1 * (x1 - self.motion.translation1);
        let place = if COSTLY { particles.places.get_mut(k) } else { None };
        let last = place.as_ref().map_or(Vec3A::INFINITY, |place| Vec3A::from(**place));
        if let Some(place) = place {
            *place = q1.into();
        }
        if COSTLY {
            let off = (q1 - Vec3A::from(candidate.clear_at)).length();
            // Every point of the path is within `path_bound` of its end.
            if candidate.clear - off - path_bound >= self.keep + band {
                candidate.load = 0.0;
                return false;
            }
        }
        // False for a particle that is not a number.
        let finite = way < f32::MAX;
        if !finite {
            return false;
        }
        let reach = self.keep + band + if COSTLY { (4.0 * path_bound).max(self.keep) } else { path_bound };
        let s1 = sample(q1, reach);
        let (clear_at, clear) = (Vec3A::from(candidate.clear_at), candidate.clear);
        if COSTLY {
            candidate.clear_at = q1.into();
            candidate.clear = s1.distance;
        }
        let gap1 = s1.distance - self.keep;
        if gap1 >= path_bound && gap1 >= band {
            candidate.load = 0.0;
            return false;
        }
        let keep =
            if gap1 < band && s1.normal != Vec3A::ZERO { self.room_for(candidate, s1, particles.squeezes) } else { self.keep };
        let gap1 = s1.distance - keep;
        let q0 = to_body0 * (x0 - self.motion.translation0);
        if COSTLY
            && self.projection == Projection::First
            && let Some(Swept { end, plane }) = self.strayed(sample, last, q0, q1)
        {
            // Without velocity into the surface.
            let n = self.motion.rotation1 * plane.normal();
            let by = self.motion.rotation1 * (end - q1);
            let approach = n * n.dot(x1 - x0).min(0.0);
            *position += by.extend(0.0);
            *before += (by + approach).extend(0.0);
            (candidate.plane, candidate.floor, candidate.load) = (plane, 0.0, mean_load(candidate.load, 0.0));
            (candidate.start, candidate.previous) = ((q0 + to_body0 * (by + approach)).into(), before.truncate());
            if let Some(place) = particles.places.get_mut(k) {
                *place = end.into();
            }
            return true;
        }
        // What is known of the distance at the start without asking for it: at rest it is enough.
        let least = if COSTLY { (clear - (q0 - clear_at).length()).max(0.0) } else { 0.0 };
        let swept = if s1.distance < 0.0 || path_bound >= least + self.clip {
            self.crossed(sample, [q0, q1], s1.distance, reach, keep)
        } else {
            None
        };
        let (end, plane) = match swept {
            Some(swept) => (swept.end, swept.plane),
            None if gap1 < band && s1.normal != Vec3A::ZERO => (q1, plane_at(q1, s1, keep)),
            None => {
                candidate.load = 0.0;
                return false;
            }
        };
        if swept.is_none() && gap1 >= 0.0 && candidate.load <= 0.0 {
            return false;
        }
        let rise = self.rise(i, x0, [q0, q1], plane, to_body1);
        let pushed = push_out(plane, q0, q1, end, self.recovery, rise);
        if !pushed.end.is_finite() {
            return false;
        }
        candidate.load = self.projection.load(candidate.load, pushed.push);
        // Friction acts within a band over the plane: only what bounces is kept higher.
        let height = plane.gap(pushed.end);
        (candidate.plane, candidate.floor) = (plane, if rise > 0.0 { height } else { height.min(0.0) });
        candidate.start = q0.into();
        // As differences: a particle that stays keeps its bits.
        let mut by = self.motion.rotation1 * (pushed.end - q1);
        let mut silent = Vec3A::ZERO;
        if pushed.shift != Vec3A::ZERO {
            silent = self.motion.rotation0 * pushed.shift;
        }
        if let Some(rigid) = &mut self.rigid
            && by != Vec3A::ZERO
        {
            let at = self.motion.rotation1 * pushed.end + self.motion.translation1;
            (by, silent) = rigid.split(position.w, at, by, silent);
        }
        *position += by.extend(0.0);
        if silent != Vec3A::ZERO {
            *before += silent.extend(0.0);
        }
        candidate.previous = before.truncate();
        if COSTLY && let Some(place) = particles.places.get_mut(k) {
            *place = pushed.end.into();
        }
        true
    }

    /// Distance to keep, less where another part leaves no room for all of it.
    #[inline]
    fn room_for(&self, candidate: &mut Candidate, s1: Sample, squeezes: &mut Squeezes) -> f32 {
        let normal = self.motion.rotation1 * s1.normal;
        let keep = squeezes.keep(candidate.particle, self.number, normal, s1.distance, self.keep);
        if keep < self.keep {
            // Squeezed, which is a load.
            candidate.load = candidate.load.max(0.25 * (self.keep - keep));
        }
        keep
    }

    /// Where a particle belongs that went into a body or through it, to end at a `distance` from it.
    #[inline]
    fn crossed(
        &self,
        sample: &impl Fn(Vec3A, f32) -> Sample,
        [q0, q1]: [Vec3A; 2],
        distance: f32,
        reach: f32,
        keep: f32,
    ) -> Option<Swept> {
        let s0 = sample(q0, reach);
        // Outside before; inside now, or far enough to have come out on the other side.
        let crossed = s0.distance > 0.0 && (distance < 0.0 || (q1 - q0).length() >= s0.distance + self.clip);
        if crossed { sweep(sample, (q0, s0), q1, keep) } else { None }
    }

    /// How far particle `i` leaves the plane in the substep after it struck it `[m]`.
    #[inline]
    fn rise(&self, i: usize, x0: Vec3A, [q0, q1]: [Vec3A; 2], plane: Plane, to_body1: Mat3A) -> f32 {
        self.inbound.get(i).map_or(0.0, |way| {
            let foreseen = to_body1 * (x0 + Vec3A::from_vec4(*way) - self.motion.translation1);
            let approach = plane.normal().dot(q0 - foreseen).min(plane.normal().dot(q0 - q1));
            if approach > self.impact { self.restitution * approach } else { 0.0 }
        })
    }

    /// Where a particle belongs that was moved through a surface since it was last known at `last`. Contacts of cloth with
    /// cloth, or untangling, may have moved it.
    fn strayed(&self, sample: &impl Fn(Vec3A, f32) -> Sample, last: Vec3A, q0: Vec3A, q1: Vec3A) -> Option<Swept> {
        let off = last.distance(q0);
        // False for a place that is not known: infinity.
        if !(off > MOVED * self.keep && off < TELEPORTED * self.keep) {
            return None;
        }
        let from = (last, sample(last, self.keep + off));
        if !(from.1.distance > 0.0 && off >= from.1.distance) {
            return None;
        }
        sweep(sample, from, q0, MOVED * self.keep)?;
        sweep(sample, from, q1, self.keep)
    }
}
