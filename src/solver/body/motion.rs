//! How a part of a body moves within a substep, and what it takes of what it does to the cloth.

use glam::{Mat3A, Quat, Vec3, Vec3A, Vec4};
use parry3d::bounding_volume::{Aabb, BoundingVolume};
use parry3d::math::Pose;
use parry3d::shape::Shape;

use super::Body;
use crate::solver::couple::{BodyImpulse, Coupling, RigidState};

/// World to body at the start and end of one substep.
pub(super) struct Motion {
    pub(super) rotation0: Mat3A,
    pub(super) translation0: Vec3A,
    pub(super) rotation1: Mat3A,
    pub(super) translation1: Vec3A,
    /// Farthest that a point of the body moves in the substep `[m]`; infinite for a half-space that turns.
    pub(super) way: f32,
    /// The poses that its own way leads it to, and when.
    planned: (Pose, Pose),
    s: (f32, f32),
}

impl Motion {
    /// Motion of the part of a body at `local`, from the share `s0` to the share `s1` of the frame. The part reaches `radius`
    /// `[m]` from its origin.
    pub(super) fn new(body: &Body, local: Pose, radius: f32, s0: f32, s1: f32) -> Self {
        let start = blend(&body.from, &body.to, s0) * local;
        let end = blend(&body.from, &body.to, s1) * local;
        let mut motion = Self {
            rotation0: Mat3A::IDENTITY,
            translation0: Vec3A::ZERO,
            rotation1: Mat3A::IDENTITY,
            translation1: Vec3A::ZERO,
            way: 0.0,
            planned: (start, end),
            s: (s0, s1),
        };
        motion.set(&start, &end, radius);
        motion
    }

    /// The same, where cloth has moved it to by then.
    pub(super) fn so_far(body: &Body, local: Pose, radius: f32, (s0, s1): (f32, f32), coupling: &mut Coupling) -> Self {
        let mut motion = Self::new(body, local, radius, s0, s1);
        if let Some(slot) = body.rigid.and_then(|slot| coupling.slot_mut(slot)) {
            motion.follow(slot, radius);
        }
        motion
    }

    fn set(&mut self, start: &Pose, end: &Pose, radius: f32) {
        let turn = chord(start.rotation, end.rotation);
        let turning = if turn > 0.0 { turn * radius } else { 0.0 };
        self.rotation0 = Mat3A::from_quat(start.rotation);
        self.translation0 = start.translation.into();
        self.rotation1 = Mat3A::from_quat(end.rotation);
        self.translation1 = end.translation.into();
        self.way = (end.translation - start.translation).length() + turning;
    }

    /// Follows a body that cloth moves.
    pub(super) fn follow(&mut self, slot: &RigidState, radius: f32) {
        if slot.is_movable() {
            let (start, end) = self.planned;
            self.set(&slot.moved(start, self.s.0, true), &slot.moved(end, self.s.1, false), radius);
        }
    }
}

/// A body that takes what it does to the cloth.
pub(super) struct RigidProxy<'a> {
    pub(super) slot: &'a mut RigidState,
    /// Share of the frame at the end of the substep.
    s: f32,
    /// Length of the substep `[s]`.
    h: f32,
    /// Contacts that share the body.
    pub(super) several: f32,
    gain: BodyImpulse,
}

impl<'a> RigidProxy<'a> {
    /// A body at the share `s` of the frame, at the end of a substep of `h` `[s]`.
    pub(super) fn new(slot: &'a mut RigidState, s: f32, h: f32) -> Self {
        Self { slot, s, h, several: 1.0, gain: BodyImpulse::default() }
    }

    pub(super) fn is_movable(&self) -> bool {
        self.slot.is_movable()
    }

    /// Gives the body what all contacts had for it.
    pub(super) fn finish(mut self) {
        self.give_now();
    }

    /// Takes what moved mass at `at` `[m]`, which the body did not yield to: `by` is mass times way `[kg·m]`.
    pub(super) fn react(&mut self, at: Vec3A, by: Vec3A) {
        self.gain.add(self.slot.arm(at.into(), self.s), -Vec3::from(by), Vec3::ZERO);
    }

    /// Gives the body what it has so far, and begins anew.
    pub(super) fn give_now(&mut self) {
        let gain = core::mem::take(&mut self.gain);
        if gain.is_some() {
            self.slot.give(&gain, self.h);
        }
    }

    /// How much more readily particle and body give way along the surface than across it (dimensionless).
    pub(super) fn slide(&self, w: f32, at: Vec3A, normal: Vec3A) -> f32 {
        let k = self.slot.compliance(w, self.slot.arm(at.into(), self.s), self.several);
        let normal = Vec3::from(normal);
        let across = normal.dot(k * normal);
        let along = 0.5 * (k.x_axis.x + k.y_axis.y + k.z_axis.z - across);
        if across > 0.0 { along / across } else { 1.0 }
    }

    /// Splits a correction `by` of a particle at `at`, of which `silent` gives no speed, between it and the body. Returns the
    /// particle's parts of both.
    pub(super) fn split(&mut self, w: f32, at: Vec3A, by: Vec3A, silent: Vec3A) -> (Vec3A, Vec3A) {
        let r = self.slot.arm(at.into(), self.s);
        let inverse = self.slot.compliance(w, r, self.several).inverse();
        let (push, quiet) = (inverse * Vec3::from(by), inverse * Vec3::from(silent));
        if !(push.is_finite() && quiet.is_finite()) {
            return (by, silent);
        }
        self.gain.add(r, -push, -quiet);
        ((push * w).into(), (quiet * w).into())
    }
}

/// Longest translation of a body in the frame `[m]`.
pub(super) fn farthest_push(bodies: &[Body]) -> f32 {
    let ways = bodies.iter().map(|body| (body.to.translation - body.from.translation).length());
    ways.filter(|way| way.is_finite()).fold(0.0, f32::max)
}

/// A pose with finite numbers and a unit rotation.
pub(super) fn valid(pose: Pose) -> Option<Pose> {
    let length2 = pose.rotation.length_squared();
    if !(pose.is_finite() && length2 > 1.0e-6 && length2 < 1.0e6) {
        return None;
    }
    Some(Pose::from_parts(pose.translation, pose.rotation.normalize()))
}

/// Pose at the fraction `s` of the frame. Rotations are blended linearly and normalized. Within a frame the difference from
/// constant angular speed is small. The blend has no transcendental function, so every machine gives the same bits.
pub(super) fn blend(from: &Pose, to: &Pose, s: f32) -> Pose {
    Pose::from_parts(from.translation.lerp(to.translation, s), from.rotation.lerp(to.rotation, s).normalize())
}

/// Angle between two unit quaternions over the chord between them, at most, and 3 % to spare: `θ = 4 asin(d / 2)` is within
/// `π d / √2` up to half a turn.
const ANGLE_PER_CHORD: f32 = 2.3;

/// Bound of the angle between two rotations `[rad]`, without transcendental functions.
fn chord(a: Quat, b: Quat) -> f32 {
    let near = if a.dot(b) < 0.0 { -b } else { b };
    let difference = Vec4::from(a) - Vec4::from(near);
    ANGLE_PER_CHORD * difference.length()
}

/// Box around a shape in both poses `[m]`. Then how much farther the shape may bulge between them `[m]`, and how far it reaches
/// from its own origin `[m]`.
pub(super) fn swept_box(shape: &dyn Shape, from: &Pose, to: &Pose) -> (Aabb, f32, f32) {
    let local = shape.compute_local_aabb();
    let radius = local.mins.abs().max(local.maxs.abs()).length();
    // Between its two poses a turning shape bulges out of both boxes, by less than r θ² / 8.
    let turn = chord(from.rotation, to.rotation);
    // A half-space reaches infinitely far.
    let bulge = if turn > 0.0 { 0.125 * turn * turn * radius } else { 0.0 };
    (shape.compute_aabb(from).merged(&shape.compute_aabb(to)), bulge, radius)
}

/// What is not a number or negative counts as 0.
pub(super) fn finite_or_zero(x: f32) -> f32 {
    if x.is_finite() { x.max(0.0) } else { 0.0 }
}
