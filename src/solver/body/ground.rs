//! Bodies as cloth that lies on them has them at the end of a substep.

use glam::{Mat3A, Vec3, Vec3A};

use super::friction::{Friction, slip};
use super::motion::{Motion, RigidProxy};
use super::respond::Plane;
use super::{Body, Pose, Touch};
use crate::solver::couple::Coupling;
use crate::solver::scales::TOUCHING;

/// Depth below its plane down to which a contact still counts, in distances kept (dimensionless). What is deeper comes out as
/// an overlap does, at its speed. The worst edge of a sheet of 40² on needles is 1.38 of its length with 1, 1.30 with 2 and 4
/// **`[measured]`**.
const DEEPEST: f32 = 2.0;

/// What contact with bodies needs in a substep: the bodies, those of `coupling` where they are by now, and how cloth touches
/// them.
pub(crate) struct BodyContext<'a> {
    /// The bodies.
    pub bodies: &'a [Body],
    /// Shares of the frame at which the substep begins and ends (0 to 1).
    pub span: (f32, f32),
    /// How the cloth touches them.
    pub touch: Touch,
    /// What takes part.
    pub coupling: &'a mut Coupling,
}

impl BodyContext<'_> {
    /// The part of body `body` at `local` in it, with its farthest point at `radius` `[m]`; `None` for a body that is not
    /// there.
    pub(super) fn part(&mut self, body: u32, local: Pose, radius: f32) -> Option<Ground> {
        let body = self.bodies.get(body as usize)?;
        let motion = Motion::so_far(body, local, radius, self.span, self.coupling);
        let to_body = [motion.rotation0.transpose(), motion.rotation1.transpose()];
        let (friction, gives_way, keep) = (self.touch.friction(body), body.rigid.is_some(), self.touch.kept(body));
        Some(Ground { motion, to_body, radius, friction, gives_way, keep })
    }

    /// Body `body`, if it is one of `coupling` and time passes. `contacts` share it in a frame of `dt` `[s]`.
    pub(super) fn rigid(&mut self, body: u32, dt: f32, contacts: usize) -> Option<RigidProxy<'_>> {
        let slot = self.coupling.slot_mut(self.bodies.get(body as usize)?.rigid?)?;
        let (s0, s1) = self.span;
        if s1 <= s0 {
            return None;
        }
        let mut rigid = RigidProxy::new(slot, s1, (s1 - s0) * dt);
        rigid.several = contacts as f32;
        Some(rigid)
    }
}

/// A body that bears a particle at the end of a substep, whatever pushes that.
pub(crate) struct Bearing {
    /// Where it put the particle `[m]`.
    pub at: Vec3A,
    /// Unit normal of its surface there.
    pub normal: Vec3A,
    /// Way of its surface there in the substep `[m]`.
    pub way: Vec3A,
}

/// A part of a body that cloth lies on.
pub(super) struct Ground {
    motion: Motion,
    /// At the start and the end of the substep.
    to_body: [Mat3A; 2],
    /// Farthest point of the part `[m]`.
    radius: f32,
    friction: Friction,
    /// Whether cloth moves the body.
    gives_way: bool,
    /// Distance kept from it `[m]`.
    pub keep: f32,
}

impl Ground {
    /// Follows a body that cloth moves.
    pub(super) fn follow(&mut self, rigid: &RigidProxy<'_>) {
        self.motion.follow(rigid.slot, self.radius);
        self.to_body = [self.motion.rotation0.transpose(), self.motion.rotation1.transpose()];
    }

    /// How the part bears a particle that it put `at` `[m]`, on a `plane` in its space; `None` if it gives way.
    pub(super) fn bearing(&self, plane: Plane, at: Vec3A) -> Option<Bearing> {
        if self.gives_way {
            return None;
        }
        let local = self.to_body[1] * (at - self.motion.translation1);
        let way = at - (self.motion.rotation0 * local + self.motion.translation0);
        Some(Bearing { at, normal: self.motion.rotation1 * plane.normal(), way })
    }

    /// A way `[m]` in the space of the part at the end of the substep.
    pub(super) fn to_part_space(&self, way: Vec3A) -> Vec3 {
        (self.to_body[1] * way).into()
    }

    /// The way `[m]` from `now` `[m]` out to `floor` `[m]` over a `plane` in the space of the part; `kept`: distance kept
    /// `[m]`. `None` above that, and deeper than [`DEEPEST`].
    pub(super) fn way_to(&self, plane: Plane, floor: f32, now: Vec3A, kept: f32) -> Option<Vec3A> {
        let gap = plane.gap(self.to_body[1] * (now - self.motion.translation1));
        (gap < floor && gap > -DEEPEST * kept).then(|| self.motion.rotation1 * (plane.normal() * (floor - gap)))
    }

    /// In the space of the part, what was at `old` when the substep began `[m]`.
    pub(super) fn start(&self, old: Vec3A) -> Vec3A {
        self.turned_back(old - self.motion.translation0)
    }

    /// A way `[m]` in the space of the part when the substep began.
    pub(super) fn turned_back(&self, way: Vec3A) -> Vec3A {
        self.to_body[0] * way
    }

    /// What friction takes back of the way of a contact in the substep `[m]`. The contact moved from `start` `[m]`, in the
    /// space of the part, to `now` `[m]`. It was put `floor` `[m]` over `plane` under a mean push of `load` `[m]`. `mobility`:
    /// how far a unit push moves it `[1/kg]`; `kept`: distance kept `[m]`; `rigid`: the body, if it takes its share. `None`: it
    /// was pushed off, or moves with the body.
    pub(super) fn hold(
        &self,
        (plane, floor, load): (Plane, f32, f32),
        (start, now): (Vec3A, Vec3A),
        (mobility, kept): (f32, f32),
        rigid: &mut Option<RigidProxy<'_>>,
    ) -> Option<Vec3A> {
        let Motion { rotation1, translation1, .. } = self.motion;
        let end = self.to_body[1] * (now - translation1);
        let movable = rigid.as_ref().filter(|rigid| rigid.is_movable());
        // A body that contacts share is where their mean has put it, no more than a push away. What was pushed off otherwise is
        // off: under what is left of its load, cloth would jam on the edge of a table **`[measured]`**.
        let reach = floor.max(0.0) + TOUCHING * kept + if movable.is_some() { load } else { 0.0 };
        // NaN passes no comparison.
        if !(plane.gap(end) < reach) {
            return None;
        }
        let slipped = slip(plane.normal(), end - start);
        let mut friction = self.friction;
        if let Some(rigid) = movable {
            friction = friction.times(rigid.slide(mobility, now, rotation1 * plane.normal()));
        }
        let mut by = rotation1 * -friction.hold(slipped, load);
        if by == Vec3A::ZERO || !by.is_finite() {
            return None;
        }
        if let Some(rigid) = rigid {
            by = rigid.split(mobility, now, by, Vec3A::ZERO).0;
        }
        Some(by)
    }
}
