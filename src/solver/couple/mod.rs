//! What cloth gives bodies: impulses, and how far a body moves by them within a frame.
//!
//! ```text
//!  frame      X(s)     the way of the body as its engine has it: from X(0) to X(1), without cloth
//!  substep    advance  d += u h                     d: shift and turn off that way, u: speed off it; both begin at 0
//!             pins     targets move with d          Δ of a pin  -> body        (`pins`)
//!             contacts X(s) moved by d              push on cloth -> -push on body
//!  frame      given    Σ impulses, d               the engine adds impulse / mass to the velocity, and d to the pose
//! ```
//!
//! A correction of `Δ` between a particle and a body takes the impulse `J = K⁻¹ Δ` (times the substep), so that both together
//! come as far:
//!
//! ```text
//! K = w 1 + 1/M - [r] I⁻¹ [r]                     w: inverse mass of the particle, M, I: mass and inertia of the body
//! Δx = w J,   Δd = -J / M,   Δθ = -I⁻¹ (r × J)    r: from the centre of the body to the particle
//! ```
//!
//! This is XPBD for rigid bodies (Müller et al. 2020, eq. 2 to 9), for a whole vector instead of one direction. The body moves
//! within the substeps, so that one lighter than the cloth is as stable as a heavier one. No momentum is lost: what a particle
//! gains the body loses.
//!
//! All contacts of a body in a substep are solved at once, so that none comes first. Each of the `n` contacts is given a body
//! of `1/n` of the mass. The body moves by the mean of these motions (mass splitting, Tonge et al. 2012). That mean is the sum
//! of the impulses over the whole mass. Several cloths at one body are stepped without knowing of each other, and share it in
//! the same way.

mod pins;

use glam::{Mat3, Quat, Vec3, Vec4};
use parry3d::math::Pose;

use pins::Pins;
pub(crate) use pins::Pull;

use super::anchors::Anchors;

/// A body that takes what cloth gives it, in the cloth's frame of simulation.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Rigid {
    /// Inverse mass along each axis `[1/kg]`; 0: cloth cannot move it that way.
    pub inverse_mass: Vec3,
    /// Inverse inertia about the centre of mass `[1/(kg m²)]`; 0: cloth cannot turn it.
    pub inverse_inertia: Mat3,
    /// Centre of mass at the start of the frame `[m]`.
    pub from: Vec3,
    /// Centre of mass at the end of the frame if no cloth were there `[m]`.
    pub to: Vec3,
    /// Velocity of the centre at the end of the frame if no cloth were there `[m/s]`. `None`: `(to - from) / dt`.
    pub velocity: Option<Vec3>,
}

impl Rigid {
    /// A body that cloth cannot move.
    #[must_use]
    pub fn immovable(from: Vec3, to: Vec3) -> Self {
        Self { inverse_mass: Vec3::ZERO, inverse_inertia: Mat3::ZERO, from, to, velocity: None }
    }

    /// Whether cloth can move or turn it.
    #[must_use]
    pub(crate) fn is_movable(&self) -> bool {
        self.inverse_mass != Vec3::ZERO || self.inverse_inertia != Mat3::ZERO
    }
}

/// What cloth gave a body in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Reaction {
    /// Impulse `[N·s]`.
    pub linear: Vec3,
    /// Angular impulse about the centre of mass `[N·m·s]`.
    pub angular: Vec3,
    /// How far the centre of mass ends from where it would have been `[m]`.
    pub shift: Vec3,
    /// Turn about the centre of mass, off how it would have been turned.
    pub turn: Quat,
}

impl Default for Reaction {
    fn default() -> Self {
        Self { linear: Vec3::ZERO, angular: Vec3::ZERO, shift: Vec3::ZERO, turn: Quat::IDENTITY }
    }
}

/// How far a body is off the way that its engine has it go.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
struct PoseDelta {
    shift: Vec3,
    turn: Quat,
}

impl PoseDelta {
    const NONE: Self = Self { shift: Vec3::ZERO, turn: Quat::IDENTITY };

    /// Moved by `shift` `[m]` and turned by the small rotation vector `turn` `[rad]`.
    fn by(self, shift: Vec3, turn: Vec3) -> Self {
        let turned = Quat::from_vec4((0.5 * turn).extend(1.0)) * self.turn;
        // A turn whose square is beyond all numbers has no direction left; what spins so fast keeps the one it had.
        let turn = if turned.length_squared().is_finite() { turned.normalize() } else { self.turn };
        Self { shift: self.shift + shift, turn }
    }
}

/// A body in the frame under way.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct RigidState {
    rigid: Rigid,
    movable: bool,
    /// How much its way is curved: `x(s) = from + (to - from) s + bend (s² - s)` `[m]`.
    bend: Vec3,
    /// At the start and at the end of the substep.
    start: PoseDelta,
    now: PoseDelta,
    /// Speed `[m/s]` and spin `[rad/s]` off the way.
    velocity: Vec3,
    spin: Vec3,
    linear: Vec3,
    angular: Vec3,
    /// Pins on it.
    pins: u32,
}

impl RigidState {
    fn new(rigid: Rigid) -> Self {
        let movable = rigid.is_movable();
        let (start, now) = (PoseDelta::NONE, PoseDelta::NONE);
        let (velocity, spin, linear, angular) = (Vec3::ZERO, Vec3::ZERO, Vec3::ZERO, Vec3::ZERO);
        Self { rigid, movable, bend: Vec3::ZERO, start, now, velocity, spin, linear, angular, pins: 0 }
    }

    /// Whether cloth can move it.
    pub(crate) fn is_movable(&self) -> bool {
        self.movable
    }

    /// The pose of a part, at the start of the substep or now. Without cloth its way leads it to `pose` at the share `s` of the
    /// frame.
    pub(crate) fn moved(&self, pose: Pose, s: f32, at_start: bool) -> Pose {
        if !self.movable {
            return pose;
        }
        let off = if at_start { self.start } else { self.now };
        let center = self.rigid.from.lerp(self.rigid.to, s);
        let translation = self.way(s) + off.shift + off.turn * (pose.translation - center);
        Pose::from_parts(translation, (off.turn * pose.rotation).normalize())
    }

    /// Where the centre of mass would be `[m]`.
    fn way(&self, s: f32) -> Vec3 {
        self.rigid.from.lerp(self.rigid.to, s) + self.bend * (s * s - s)
    }

    /// From the centre of mass to a point, at the share `s` of the frame `[m]`.
    pub(crate) fn arm(&self, point: Vec3, s: f32) -> Vec3 {
        point - self.way(s) - self.now.shift
    }

    /// `K` of a particle of inverse mass `w` `[1/kg]` at the end of the arm `r` `[m]`, and one of `several` shares of the body.
    pub(crate) fn compliance(&self, w: f32, r: Vec3, several: f32) -> Mat3 {
        let mut k = Mat3::from_diagonal(self.rigid.inverse_mass * several + Vec3::splat(w));
        if self.movable {
            let cross = Mat3::from_cols(Vec3::new(0.0, r.z, -r.y), Vec3::new(-r.z, 0.0, r.x), Vec3::new(r.y, -r.x, 0.0));
            k -= cross * self.rigid.inverse_inertia * cross * several;
        }
        k
    }

    /// Gives the body what it gained in a substep of `h` `[s]`.
    pub(crate) fn give(&mut self, gain: &BodyImpulse, h: f32) {
        let BodyImpulse { linear, angular, silent_linear, silent_angular } = *gain;
        let (loud, loud_angular) = (linear - silent_linear, angular - silent_angular);
        if self.movable {
            let Rigid { inverse_mass, inverse_inertia, .. } = self.rigid;
            self.now = self.now.by(inverse_mass * linear, inverse_inertia * angular);
            self.velocity += inverse_mass * loud / h;
            self.spin += inverse_inertia * loud_angular / h;
            self.start = self.start.by(inverse_mass * silent_linear, inverse_inertia * silent_angular);
        }
        self.linear += loud / h;
        self.angular += loud_angular / h;
    }
}

/// What a body gains in a substep, times its length.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct BodyImpulse {
    /// `[kg·m]`
    linear: Vec3,
    /// About its centre of mass `[kg·m²]`.
    angular: Vec3,
    /// The part of it that moves the body without giving it speed.
    silent_linear: Vec3,
    silent_angular: Vec3,
}

impl BodyImpulse {
    /// Whether there is something to give, and it is a number.
    pub(crate) fn is_some(&self) -> bool {
        (self.linear != Vec3::ZERO || self.angular != Vec3::ZERO) && self.linear.is_finite() && self.angular.is_finite()
    }

    /// Adds `by` `[kg·m]` at the end of the arm `r` `[m]`, of which `silent` gives no speed.
    pub(crate) fn add(&mut self, r: Vec3, by: Vec3, silent: Vec3) {
        self.linear += by;
        self.angular += r.cross(by);
        if silent != Vec3::ZERO {
            self.silent_linear += silent;
            self.silent_angular += r.cross(silent);
        }
    }
}

/// The bodies that one cloth gives something to, and its pins on them. Buffers are reused: nothing is allocated once they are
/// warm.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Coupling {
    slots: Vec<RigidState>,
    pins: Pins,
}

impl Coupling {
    /// Forgets the bodies of the last frame.
    pub fn clear(&mut self) {
        self.slots.clear();
        self.pins.clear();
    }

    /// Adds a body; returns the number by which [`Body::rigid`](super::body::Body::rigid) and [`Self::hold`] name it.
    pub fn add(&mut self, rigid: Rigid) -> u32 {
        self.slots.push(RigidState::new(rigid));
        (self.slots.len() - 1) as u32
    }

    /// Says that pin `anchor` (its place in [`Anchors`]) is on body `slot`. Pins that are not rigid give it nothing.
    pub fn hold(&mut self, anchor: u32, slot: u32) {
        self.pins.hold(anchor, slot);
    }

    /// What the cloth gave body `slot` in the last frame.
    #[must_use]
    pub fn given(&self, slot: u32) -> Reaction {
        self.slots.get(slot as usize).map_or_else(Reaction::default, |slot| Reaction {
            linear: slot.linear,
            angular: slot.angular,
            shift: slot.now.shift,
            turn: slot.now.turn,
        })
    }

    /// Mass of body `slot` `[kg]` along the axis along which it is least, or the cloth's share of that on a body of several
    /// cloths. Infinite if cloth cannot move the body.
    pub(crate) fn mass(&self, slot: u32) -> f32 {
        self.slots.get(slot as usize).map_or(f32::INFINITY, |slot| slot.rigid.inverse_mass.max_element().recip())
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.slots.is_empty()
    }

    pub(crate) fn slot_mut(&mut self, slot: u32) -> Option<&mut RigidState> {
        self.slots.get_mut(slot as usize)
    }

    /// Begins a frame of `dt` `[s]`.
    pub(crate) fn begin(&mut self, dt: f32, anchors: &Anchors, positions: &[Vec4]) {
        self.pins.begin(self.slots.len(), anchors, positions);
        for slot in &mut self.slots {
            *slot = RigidState::new(slot.rigid);
            let Rigid { from, to, velocity, .. } = slot.rigid;
            let bend = velocity.map_or(Vec3::ZERO, |velocity| velocity * dt - (to - from));
            slot.bend = if slot.movable && bend.is_finite() { bend } else { Vec3::ZERO };
        }
    }

    /// Begins a substep of `h` `[s]`.
    pub(crate) fn advance(&mut self, h: f32) {
        for slot in self.slots.iter_mut().filter(|slot| slot.movable) {
            slot.start = slot.now;
            slot.now = slot.now.by(slot.velocity * h, slot.spin * h);
        }
    }
}

/// Positions of one cloth with what they are pinned to.
impl Coupling {
    /// Inverse masses `[1/kg]` that pins on bodies are to have, by their place in the anchors; the others are rigid.
    pub(crate) fn weigh(&mut self, anchors: &Anchors) {
        self.pins.weigh(&mut self.slots, anchors);
    }

    /// Anchors of the pins that something moves, and their inverse masses `[1/kg]`.
    pub(crate) fn weights(&self) -> impl Iterator<Item = (usize, f32)> + '_ {
        self.pins.weights()
    }

    /// Particles that are pinned to bodies that cloth can move.
    pub(crate) fn pinned_to_bodies<'a>(&'a self, anchors: &'a Anchors) -> impl Iterator<Item = u32> + 'a {
        self.pins.pinned_to_bodies(anchors)
    }

    /// Puts pins where their bodies are at the share `s` of the frame.
    pub(crate) fn place(&mut self, anchors: &Anchors, s: f32, positions: &mut [Vec4]) {
        self.pins.place(&self.slots, anchors, s, positions);
    }

    /// Notes where the particles are when pins were [placed](Self::place) and all that acts from outside has moved the others.
    pub(crate) fn note(&mut self, positions: &[Vec4]) {
        self.pins.note(positions);
    }

    /// Gives bodies what moved their pins since [`Self::note`].
    pub(crate) fn react(&mut self, pull: &Pull<'_>, positions: &mut [Vec4]) {
        self.pins.react(&mut self.slots, pull, positions);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_body_that_is_spun_faster_than_numbers_reach_keeps_a_rotation() {
        for angular in [1.0e-3, 1.0, 1.0e10, 1.0e25, 1.0e38] {
            let rigid = Rigid {
                inverse_mass: Vec3::ONE,
                inverse_inertia: Mat3::from_diagonal(Vec3::splat(10.0)),
                ..Rigid::immovable(Vec3::ZERO, Vec3::ZERO)
            };
            let mut coupling = Coupling::default();
            coupling.add(rigid);
            let slot = coupling.slot_mut(0).expect("a body");
            let mut gain = BodyImpulse::default();
            gain.add(angular * Vec3::X, Vec3::Y, Vec3::ZERO);
            slot.give(&gain, 1.0 / 360.0);
            for _ in 0..2 {
                coupling.advance(1.0 / 360.0);
                let turn = coupling.given(0).turn;
                assert!(turn.is_normalized(), "{angular}: {turn}");
            }
        }
    }
}
