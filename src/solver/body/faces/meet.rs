//! One face against one part in one substep: passed over, stopped, brought back or pushed.

use glam::Vec3A;

use super::Candidate;
use super::memory::normal;
use super::pass::Look;
use super::setting::{Setting, State};
use crate::solver::body::geometry::Geometry;
use crate::solver::body::nearest::{Face, Near};
use crate::solver::body::squeeze::Squeezes;
use crate::solver::body::sweep::plane_at;
use crate::solver::scales::TOUCHING;

impl Setting<'_> {
    /// Whether the face touched.
    pub(super) fn meet(&self, state: &mut State<'_, '_>, squeezes: &mut Squeezes) -> bool {
        let Some(look) = self.look(state) else { return false };
        let clear = look.is_clear();
        let Look { mut way, end, towards } = look;
        let nearest = |face: &Face| self.part.nearest(face, towards);
        let keep = end.map_or(self.keep, |Near { sample, .. }| {
            let normal = self.motion.rotation1 * sample.normal;
            squeezes.keep(state.candidate.piece.place(state.candidate.face), self.number, normal, sample.distance, self.keep)
        });
        if !clear && nearest(&way.from).as_ref().is_some_and(Near::is_outside) {
            if let Some(touched) = self.stop(&nearest, keep, &mut way, state) {
                return touched;
            }
        } else if !clear {
            // What went into it within goes out through it, however it lies now.
            let Candidate { side, over, .. } = *state.candidate;
            let within = end.is_none() && over != 0.0;
            let side = if within { normal(&way.to) * over } else { Vec3A::from(side) };
            let known = side != Vec3A::ZERO;
            // Where the nearest point lies on its own side it is pushed out from there, and from round parts wherever it lies.
            let is_round = matches!(self.part.geometry, Geometry::Ball { .. } | Geometry::Capsule { .. });
            if known && end.is_none_or(|near| !is_round && near.sample.normal.dot(side) <= 0.0) {
                return self.bring_back(&nearest, side, &way, state);
            }
        }
        let Some(near) = end else { return false };
        if near.is_outside() {
            state.candidate.lies(&near, &way.to);
        }
        let gap = near.sample.distance - keep;
        let touches = gap < 0.0 || (state.candidate.load > 0.0 && gap < TOUCHING * keep);
        touches && self.push(&near, plane_at(near.point, near.sample, keep), &mut way, state)
    }
}
