//! Pins on bodies that take what cloth gives them.
//!
//! *On a body that cloth can move* a pin is a particle that carries a share of the body. With `n` pins its inverse mass is
//! `n (1/M + r² |I⁻¹|)`, no less than that of the body there. Springs move it. Then all pins are drawn together into one rigid
//! motion, `Σ J_i` with `J_i = Δx_i / w_i`, as in mass splitting (Tonge et al. 2012). Their momentum stays, and a body lighter
//! than the cloth does not shake.
//!
//! *On a body that nothing moves* a pin has no inverse mass, and its share is what the cloth is lacking. The impulses of
//! springs, bends and tethers add up to zero. So the pins lost all that these gave to the free particles in a substep:
//! `F = -Σ m Δx / h`, and its moment. That is exact for the cloth as a whole. How much of it each pin bears follows the strain
//! of the edges at it, corrected so that force and moment fit.

use glam::{DVec3, Mat3, Quat, Vec3, Vec4};
use parry3d::math::Pose;

use super::{BodyImpulse, RigidState};
use crate::solver::anchors::Anchors;
use crate::solver::anchors::RIGID;
use crate::solver::rest::RestShape;

/// A pin on a body.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
struct Pin {
    anchor: u32,
    slot: u32,
    /// Inverse mass `[1/kg]`; 0: nothing moves it.
    w: f32,
    /// Where it was put `[m]`.
    placed: Vec3,
}

/// The pins of one cloth on bodies.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Pins {
    pins: Vec<Pin>,
    /// Where each particle was when pins had been placed, and all that acts from outside had moved it `[m]`.
    before: Vec<Vec4>,
    /// What each rigid pin bears, in the order of the anchors `[kg m]`.
    borne: Vec<Vec3>,
}

/// What springs did, and to whom.
pub(crate) struct Pull<'a> {
    pub rest: &'a RestShape,
    pub anchors: &'a Anchors,
    /// Share of the frame at the end of the substep.
    pub s: f32,
    /// Length of the substep `[s]`.
    pub h: f32,
    pub gravity: Vec3,
    /// Areal density `[kg/m²]`.
    pub density: f32,
}

impl Pins {
    pub(super) fn clear(&mut self) {
        self.pins.clear();
    }

    pub(super) fn hold(&mut self, anchor: u32, slot: u32) {
        self.pins.push(Pin { anchor, slot, w: 0.0, placed: Vec3::ZERO });
    }

    /// Computes inverse masses for the pins to be given.
    pub(super) fn weigh(&mut self, slots: &mut [RigidState], anchors: &Anchors) {
        let rigid = |pin: &Pin| anchors.weights.get(pin.anchor as usize).is_some_and(|w| *w >= RIGID);
        self.pins.retain(|pin| rigid(pin) && (pin.slot as usize) < slots.len());
        slots.iter_mut().for_each(|slot| slot.pins = 0);
        self.pins.iter().for_each(|pin| slots[pin.slot as usize].pins += 1);
        for pin in &mut self.pins {
            let RigidState { rigid, pins, .. } = &slots[pin.slot as usize];
            let arm = anchors.from.get(pin.anchor as usize).map_or(0.0, |at| (*at - rigid.from).length_squared());
            let turns = rigid.inverse_inertia.to_cols_array().iter().map(|x| x * x).sum::<f32>().sqrt();
            pin.w = *pins as f32 * (rigid.inverse_mass.max_element() + turns * arm);
        }
    }

    /// Begins a frame: pins weigh what their particles were given.
    pub(super) fn begin(&mut self, slots: usize, anchors: &Anchors, positions: &[Vec4]) {
        let particle = |pin: &Pin| anchors.particles.get(pin.anchor as usize).and_then(|&p| positions.get(p as usize));
        let rigid = |pin: &Pin| anchors.weights.get(pin.anchor as usize).is_some_and(|w| *w >= RIGID);
        self.pins.retain(|pin| rigid(pin) && (pin.slot as usize) < slots && particle(pin).is_some());
        for pin in &mut self.pins {
            pin.w = particle(pin).map_or(0.0, |x| x.w);
        }
    }

    pub(super) fn weights(&self) -> impl Iterator<Item = (usize, f32)> + '_ {
        self.pins.iter().filter(|pin| pin.w > 0.0).map(|pin| (pin.anchor as usize, pin.w))
    }

    pub(super) fn pinned_to_bodies<'a>(&'a self, anchors: &'a Anchors) -> impl Iterator<Item = u32> + 'a {
        let moving = self.pins.iter().filter(|pin| pin.w > 0.0);
        moving.filter_map(|pin| anchors.particles.get(pin.anchor as usize).copied())
    }

    fn put(&mut self, slots: &[RigidState], anchors: &Anchors, s: f32, positions: &mut [Vec4]) {
        for pin in self.pins.iter_mut().filter(|pin| pin.w > 0.0) {
            let (a, slot) = (pin.anchor as usize, &slots[pin.slot as usize]);
            let target = anchors.from[a].lerp(anchors.to[a], s);
            pin.placed = slot.moved(Pose::from_parts(target, Quat::IDENTITY), s, false).translation;
            let x = &mut positions[anchors.particles[a] as usize];
            *x = pin.placed.extend(x.w);
        }
    }

    pub(super) fn place(&mut self, slots: &[RigidState], anchors: &Anchors, s: f32, positions: &mut [Vec4]) {
        self.put(slots, anchors, s, positions);
    }

    /// Notes where the particles are when all that acts from outside has moved them.
    pub(super) fn note(&mut self, positions: &[Vec4]) {
        if self.pins.iter().any(|pin| pin.w == 0.0) {
            self.before.clear();
            self.before.extend_from_slice(positions);
        }
    }

    pub(super) fn react(&mut self, slots: &mut [RigidState], pull: &Pull<'_>, positions: &mut [Vec4]) {
        if self.pins.is_empty() {
            return;
        }
        if self.pins.iter().any(|pin| pin.w == 0.0) {
            self.share(pull, positions);
        }
        for (i, slot) in (0..).zip(slots.iter_mut()) {
            let mut gain = BodyImpulse::default();
            for pin in self.pins.iter().filter(|pin| pin.slot == i) {
                let at = positions[pull.anchors.particles[pin.anchor as usize] as usize].truncate();
                if pin.w > 0.0 {
                    gain.add(slot.arm(pin.placed, pull.s), (at - pin.placed) / pin.w, Vec3::ZERO);
                } else {
                    gain.add(slot.arm(at, pull.s), self.borne[pin.anchor as usize], Vec3::ZERO);
                }
            }
            if gain.is_some() {
                slot.give(&gain, pull.h);
            }
        }
        self.put(slots, pull.anchors, pull.s, positions);
    }

    /// Shares what the cloth is lacking among the pins that nothing moves.
    fn share(&mut self, pull: &Pull<'_>, positions: &[Vec4]) {
        let Pull { rest, anchors, .. } = *pull;
        let pinned = |k: &usize| anchors.weights[*k] >= RIGID && positions[anchors.particles[*k] as usize].w == 0.0;
        let at = |k: usize| positions[anchors.particles[k] as usize].truncate();
        self.borne.clear();
        self.borne.resize(anchors.particles.len(), Vec3::ZERO);
        let (mut sum, mut count, mut middle) = (Vec3::ZERO, 0, Vec3::ZERO);
        for k in (0..anchors.particles.len()).filter(pinned) {
            let p = anchors.particles[k];
            for &(q, _) in rest.topology.around(p) {
                let d = (positions[q as usize] - positions[p as usize]).truncate();
                let length = rest.positions[p as usize].distance(rest.positions[q as usize]);
                let now = d.length();
                if positions[q as usize].w > 0.0 && now > length && now.is_finite() {
                    self.borne[k] += d * ((now - length) / (length * now).max(f32::MIN_POSITIVE));
                }
            }
            sum += self.borne[k];
            middle += at(k);
            count += 1;
        }
        if count == 0 || self.before.len() != positions.len() {
            return;
        }
        let each = 1.0 / count as f32;
        middle *= each;

        let (mut force, mut moment) = (DVec3::ZERO, DVec3::ZERO);
        for (x, old) in positions.iter().zip(&self.before).filter(|(x, _)| x.w > 0.0) {
            let lost = (old.truncate() - x.truncate()).as_dvec3() / f64::from(x.w);
            force += lost;
            moment += (old.truncate() - middle).as_dvec3().cross(lost);
        }
        let (force, mut moment) = (force.as_vec3(), moment.as_vec3());
        if !(force.is_finite() && moment.is_finite()) {
            self.borne.fill(Vec3::ZERO);
            return;
        }
        let square = sum.length_squared();
        let scale = if square > 0.0 { (force.dot(sum) / square).max(0.0) } else { 0.0 };
        let rest_of_force = (force - sum * scale) * each;
        let mut spread = Mat3::ZERO;
        for k in (0..anchors.particles.len()).filter(pinned) {
            self.borne[k] = self.borne[k] * scale + rest_of_force;
            let r = at(k) - middle;
            moment -= r.cross(self.borne[k]);
            spread += Mat3::from_diagonal(Vec3::splat(r.length_squared())) - Mat3::from_cols(r * r.x, r * r.y, r * r.z);
        }
        // Pins on a line bear no moment along it.
        let least = 1.0e-3 * (spread.x_axis.x + spread.y_axis.y + spread.z_axis.z);
        let turn = if least > 0.0 { (spread + Mat3::from_diagonal(Vec3::splat(least))).inverse() * moment } else { Vec3::ZERO };
        for k in (0..anchors.particles.len()).filter(pinned) {
            self.borne[k] += turn.cross(at(k) - middle);
            // What the pinned particle weighs itself.
            let mass = pull.density * rest.areas[anchors.particles[k] as usize];
            self.borne[k] += pull.gravity * (mass * pull.h * pull.h);
        }
    }
}
