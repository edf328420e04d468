//! Cloth on bodies, put where they will put it while pairs of cloth are looked at.
//!
//! ```text
//!   constrain   x      springs and gravity draw what lies on a body into it
//!   lay         x + u  out again, along the plane of its last touch            ◄ what lies on it meets it here, and does not follow it in;
//!                                                                                once more when that has pushed it in
//!   take back   x      with what was done to it meanwhile
//!   project            the body bears it, as if nothing had been
//! ```

use glam::{Mat3A, Vec3A, Vec4};

use super::motion::Motion;
use super::respond::Plane;
use super::{Body, Pose, Touch};
use crate::solver::couple::Coupling;

/// Where particles were before they were laid, and where to [m].
#[derive(Clone, Debug, Default)]
pub struct Laid {
    moved: Vec<(u32, Vec4, Vec4)>,
}

impl Laid {
    /// Begins a frame in which at most so many are moved in a substep.
    pub fn begin(&mut self, most: usize) {
        self.moved.clear();
        self.moved.reserve(most);
    }

    /// Moves a particle `by` [m].
    pub(super) fn put(&mut self, particle: u32, by: Vec3A, positions: &mut [Vec4]) {
        if let Some(x) = positions.get_mut(particle as usize) {
            let from = *x;
            *x += by.extend(0.0);
            self.moved.push((particle, from, *x));
        }
    }

    /// Takes all of it back; what nothing else moved has the same bits as before.
    pub fn take_back(&mut self, positions: &mut [Vec4]) {
        for (particle, from, to) in self.moved.drain(..).rev() {
            if let Some(x) = positions.get_mut(particle as usize) {
                *x = if *x == to { from } else { *x - (to - from) };
            }
        }
    }
}

/// What cloth is laid on: bodies at the share `s` of the frame, those of `coupling` where they are by now.
pub struct Grounds<'a> {
    /// The bodies.
    pub bodies: &'a [Body],
    /// Share of the frame that has passed (0 to 1).
    pub s: f32,
    /// How the cloth touches them.
    pub touch: Touch,
    /// What takes part.
    pub coupling: &'a mut Coupling,
}

impl Grounds<'_> {
    /// The part of body `body` at `local` in it, with its farthest point at `radius` [m]; `None` for a body that is not there.
    pub(super) fn part(&mut self, body: u32, local: Pose, radius: f32) -> Option<Ground> {
        let body = self.bodies.get(body as usize)?;
        let motion = Motion::at(body, local, radius, self.s, self.coupling);
        let to_body = motion.rotation1.transpose();
        Some(Ground { motion, to_body, keep: self.touch.kept(body) })
    }
}

/// A part of a body that cloth is laid on.
pub(super) struct Ground {
    motion: Motion,
    to_body: Mat3A,
    /// Distance kept from it [m].
    pub keep: f32,
}

impl Ground {
    /// The way out [m] of what is at `x` [m] to `plane`, which is in the space of the part, if it is below by less than `deepest` [m]: what is deeper
    /// is not where it was when it last touched.
    pub fn way_out(&self, plane: Plane, x: Vec3A, deepest: f32) -> Option<Vec3A> {
        let gap = plane.gap(self.to_body * (x - self.motion.translation1));
        (gap < 0.0 && gap > -deepest).then(|| self.motion.rotation1 * plane.normal * -gap)
    }
}
