//! Nothing passes: a face stops where it first touches, and one that was moved onto a part goes back to its side.

use glam::Vec3A;

use super::pass::Look;
use super::project::{PUTS, STOPS};
use super::setting::{Setting, State, Way};
use crate::solver::body::advance::first_touch;
use crate::solver::body::distance::Sample;
use crate::solver::body::nearest::{Face, Near, at};
use crate::solver::body::respond::Plane;
use crate::solver::body::sweep::{SLIDES, plane_at};

/// How far back a face that was moved onto a part is looked for along its last normal. The search begins with twice the
/// distance that faces keep, and doubles this many times, or until it is beyond the part.
const DOUBLINGS: u32 = 8;

impl Setting<'_> {
    /// Stops a face that starts outside where it touches, and lets it slide on from there. `None`: it touches nothing.
    pub(super) fn stop(
        &self,
        nearest: &impl Fn(&Face) -> Option<Near>,
        keep: f32,
        way: &mut Way,
        state: &mut State<'_, '_>,
    ) -> Option<bool> {
        let mut start = way.from;
        let mut touched = None;
        for _ in 0..SLIDES {
            let Some((face, near)) = first_touch(nearest, &start, &way.to, keep) else { return touched };
            if !self.takes(state.candidate.piece, &near.weights, &face) {
                return touched;
            }
            state.candidate.lies(&near, &face);
            touched = Some(self.push(&near, plane_at(near.point, near.sample, keep), way, state));
            start = face;
        }
        touched
    }

    /// Stops a face again that still goes into the part, or has gone through it. After [`STOPS`] turns its corners are kept in
    /// front of the plane that divided them from the part when the substep began. In the last turn they are put back to where
    /// they were then. Returns whether it did.
    pub(super) fn stop_again(&self, turn: u32, state: &mut State<'_, '_>) -> bool {
        let Some(look) = self.look(state) else { return false };
        // What can not go through it lies outside wherever it ends outside.
        if look.is_clear() || (!self.pierces && look.end.as_ref().is_some_and(Near::is_outside)) {
            return false;
        }
        let Look { mut way, towards, .. } = look;
        let nearest = |face: &Face| self.part.nearest(face, towards);
        let Some(near) = nearest(&way.from).filter(Near::is_outside) else { return false };
        if turn < STOPS {
            return self.stop(&nearest, self.keep, &mut way, state).is_some();
        }
        let is_own = |(face, near): &(Face, Near)| self.takes(state.candidate.piece, &near.weights, face);
        let goes_in = first_touch(&nearest, &way.from, &way.to, 0.5 * self.keep).as_ref().is_some_and(is_own);
        if goes_in {
            let Sample { distance, normal } = near.sample;
            let floor = normal.dot(near.point) - distance + distance.min(0.5 * self.keep);
            let to =
                if turn == STOPS + PUTS - 1 { way.from } else { way.to.map(|x| x + normal * (floor - normal.dot(x)).max(0.0)) };
            self.put(&to, &way, state);
        }
        goes_in
    }

    /// Puts the corners of a face at `to`.
    fn put(&self, to: &Face, way: &Way, state: &mut State<'_, '_>) {
        for (i, &p) in state.candidate.piece.of(&state.candidate.particles).iter().enumerate() {
            if way.masses[i] > 0.0
                && let Some(x) = state.positions.get_mut(p as usize)
            {
                let by = self.motion.rotation1 * (to[i] - way.to[i]);
                *x += by.extend(0.0);
                if let Some(rigid) = &mut *state.rigid {
                    rigid.react(Vec3A::from_vec4(*x), by / way.masses[i]);
                }
            }
        }
        if let Some(rigid) = &mut *state.rigid {
            rigid.give_now();
        }
    }

    /// Brings a face back to the side that it was on, from wherever something moved it to.
    pub(super) fn bring_back(
        &self,
        nearest: &impl Fn(&Face) -> Option<Near>,
        side: Vec3A,
        way: &Way,
        state: &mut State<'_, '_>,
    ) -> bool {
        let mut off = 2.0 * self.keep;
        for _ in 0..DOUBLINGS {
            let before = way.to.map(|x| x + side * off);
            if nearest(&before).is_some_and(|near| near.is_outside() && near.sample.normal.dot(side) > 0.0) {
                return first_touch(nearest, &before, &way.to, self.keep).is_some_and(|(face, near)| {
                    let mut way = Way { ..*way };
                    // Back the way it came, not off the surface: it may be steep.
                    let plane = Plane::new(side, side.dot(at(&face, &near.weights)));
                    self.push(&near, plane, &mut way, state)
                });
            }
            off *= 2.0;
            if off > 4.0 * self.radius {
                break;
            }
        }
        false
    }
}
