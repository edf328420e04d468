//! Provisional projection: cloth on bodies is put where they will put it while pairs of cloth are looked at.
//!
//! ```text
//!   constrain   x      springs and gravity draw what lies on a body into it
//!   provisional x + u  out again, along the plane of its last touch,           ◄ what lies on it meets it here, and does not follow it in;
//!                      and back as far as friction holds it                      once more when that has pushed it in
//!   restore     x      with what was done to it meanwhile
//!   project            the body bears it, as if nothing had been
//! ```
//!
//! Without friction here a sheet that lies on another would rub on what springs have drawn along and the body is going to pull
//! back: of 730 pairs of two sheets over a box 10 stick, with it 130, and the upper one stays **`[measured]`**.

use glam::{Mat3A, Vec3A, Vec4};

use super::motion::Motion;
use super::respond::{BAND, Friction, Plane};
use super::{Body, Pose, Touch};
use crate::solver::couple::Coupling;

/// What slips by less than this share of what static friction holds is let be (dimensionless): pairs stick all the same, and
/// are held again when bodies have pushed. Two sheets on a floor go on creeping by 0.15 mm in a second with 0, by 0.08 with
/// this; over a box they shake longer with more.
const LET_BE: f32 = 0.6;

/// Deepest that cloth is laid from, in distances kept (dimensionless): with one, what hangs on a corner and was drawn deeper
/// would be too deep to be laid and too stretched to get out.
const DEEPEST: f32 = 2.0;

/// Where particles were before they were laid, and where to `[m]`.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Provisional {
    moved: Vec<(u32, Vec4, Vec4)>,
}

impl Provisional {
    /// Begins a frame in which at most so many are moved in a substep.
    pub fn begin(&mut self, most: usize) {
        self.moved.clear();
        self.moved.reserve(most);
    }

    /// Moves a particle `by` `[m]`.
    pub(super) fn put(&mut self, particle: u32, by: Vec3A, positions: &mut [Vec4]) {
        if let Some(x) = positions.get_mut(particle as usize) {
            let from = *x;
            *x += by.extend(0.0);
            self.moved.push((particle, from, *x));
        }
    }

    /// Takes all of it back; what nothing else moved has the same bits as before.
    pub fn restore(&mut self, positions: &mut [Vec4]) {
        for (particle, from, to) in self.moved.drain(..).rev() {
            if let Some(x) = positions.get_mut(particle as usize) {
                *x = if *x == to { from } else { *x - (to - from) };
            }
        }
    }
}

/// What cloth is laid on: bodies at the end of a substep, those of `coupling` where they are by now.
pub struct Grounds<'a> {
    /// The bodies.
    pub bodies: &'a [Body],
    /// Shares of the frame at which the substep begins and ends (0 to 1).
    pub span: (f32, f32),
    /// How the cloth touches them.
    pub touch: Touch,
    /// Whether friction holds it there, too: where it touches other cloths. Folds of a single one creep more with it: crumpled
    /// ones on a floor 0.07 to 0.18 mm in a second instead of 0.02 to 0.05 **`[measured]`**.
    pub rubs: bool,
    /// What takes part.
    pub coupling: &'a mut Coupling,
}

impl Grounds<'_> {
    /// The part of body `body` at `local` in it, with its farthest point at `radius` `[m]`; `None` for a body that is not
    /// there.
    pub(super) fn part(&mut self, body: u32, local: Pose, radius: f32) -> Option<Ground> {
        let body = self.bodies.get(body as usize)?;
        let motion = Motion::so_far(body, local, radius, self.span, self.coupling);
        let to_body = [motion.rotation0.transpose(), motion.rotation1.transpose()];
        let friction = self.rubs.then(|| self.touch.friction(body));
        Some(Ground { motion, to_body, friction, keep: self.touch.kept(body) })
    }
}

/// A part of a body that cloth is laid on.
pub(super) struct Ground {
    motion: Motion,
    /// At the start and the end of the substep.
    to_body: [Mat3A; 2],
    friction: Option<Friction>,
    /// Distance kept from it `[m]`.
    pub keep: f32,
}

impl Ground {
    /// The way `[m]` to where a touch will be: out to its plane, which is in the space of the part, and back as far as friction
    /// holds what slips under its `load` `[m]`. `old` and `now`: where it was when the substep began and is now `[m]`; `kept`:
    /// its distance from the part `[m]`. `None`: it touches no more, or is so deep that it is not where it was when it last
    /// touched.
    pub(super) fn way_out(&self, plane: Plane, load: f32, [old, now]: [Vec3A; 2], kept: f32) -> Option<Vec3A> {
        let Motion { rotation1, translation0, translation1, .. } = &self.motion;
        let end = self.to_body[1] * (now - *translation1);
        let gap = plane.gap(end);
        let reach = if self.friction.is_some() { BAND * kept } else { 0.0 };
        (gap < reach && gap > -DEEPEST * kept).then(|| {
            let n = plane.normal;
            let held = self.friction.map_or(Vec3A::ZERO, |friction| {
                let moved = end - self.to_body[0] * (old - *translation0);
                let slip = moved - n * n.dot(moved);
                let least = LET_BE * friction.fixed * load;
                if slip.length_squared() > least * least { friction.hold(slip, load).0 } else { Vec3A::ZERO }
            });
            *rotation1 * (n * (-gap).max(0.0) - held)
        })
    }
}
