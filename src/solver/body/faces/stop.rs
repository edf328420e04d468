//! Nothing passes: a face stops where it first touches, and one that was moved onto a part goes back to its side.

use glam::Vec3A;

use super::setting::{Setting, State, Way};
use crate::solver::body::advance::first_touch;
use crate::solver::body::nearest::{Face, Near, at};
use crate::solver::body::respond::Plane;
use crate::solver::body::sweep::{SLIDES, plane_at};

/// How far back a face that was moved onto a part is looked for along its last normal: this many times twice as far, beginning
/// with the distance kept.
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
        if self.pierces && first_touch(nearest, &start, &way.to, keep).is_some() {
            // Wedged: it stays at the last place known to be outside. What is rounder than that gets no farther than particles
            // let it.
            for (i, &p) in state.candidate.piece.of(&state.candidate.particles).iter().enumerate() {
                if way.masses[i] > 0.0
                    && let Some(x) = state.positions.get_mut(p as usize)
                {
                    let by = self.motion.rotation1 * (start[i] - way.to[i]);
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
        touched
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
            if nearest(&before).is_some_and(|near| near.sample.distance > 0.0 && near.sample.normal.dot(side) > 0.0) {
                return first_touch(nearest, &before, &way.to, self.keep).is_some_and(|(face, near)| {
                    let mut way = Way { ..*way };
                    // Back the way it came, not off the surface: it may be steep.
                    let plane = Plane { normal: side, offset: side.dot(at(&face, &near.weights)) };
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
