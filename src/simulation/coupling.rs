//! Which bodies take what a cloth gives them, by slot of the solver.

use bevy::math::Mat3;
use bevy::prelude::*;

use super::bodies::WorldRigid;

/// The bodies that take what one cloth gives, by slot of the solver. Buffers are reused.
#[derive(Clone, Debug, Default)]
pub(crate) struct Coupled {
    /// Place of each body in the world's list.
    pub rigids: Vec<u32>,
    /// How many cloths share each.
    pub shares: Vec<f32>,
    /// Pin sets on bodies: number of the set and slot.
    pub pinned: Vec<(u32, u32)>,
    /// Bodies that this cloth gave something to: in the last frame until `couple` has asked, in this one from `give` on.
    pub gave: Vec<Entity>,
    /// Pin sets on movable bodies, and the inverse masses, inverse inertias and centres of mass of those, when the solver was
    /// prepared.
    weighed: Vec<(u32, Vec3, Mat3, Vec3)>,
}

impl Coupled {
    /// Forgets which bodies those of the last frame were.
    pub(crate) fn begin(&mut self) {
        self.rigids.clear();
        self.shares.clear();
        self.pinned.clear();
    }

    /// Whether the cloth gave a body something in this frame. Asked after `give`.
    pub(crate) fn gives(&self) -> bool {
        !self.gave.is_empty()
    }

    /// Whether it is pinned to a body that takes what it gives. Asked before `couple`: as of the last frame.
    pub(crate) fn is_pinned(&self) -> bool {
        !self.pinned.is_empty()
    }

    /// The slot of a body of the world's list.
    pub(crate) fn slot_of(&mut self, index: u32) -> u32 {
        let known = self.rigids.iter().position(|&rigid| rigid == index);
        known.unwrap_or_else(|| {
            self.rigids.push(index);
            self.rigids.len() - 1
        }) as u32
    }

    /// Whether pins lie on other bodies, or on lighter or heavier ones, than when this was last asked.
    pub(crate) fn pins_changed(&mut self, rigids: &[WorldRigid]) -> bool {
        let Self { rigids: own, shares, pinned, weighed, .. } = self;
        let now = pinned.iter().map(|&(set, slot)| {
            let slot = slot as usize;
            let WorldRigid { inverse_mass, own_inertia, center_of_mass, .. } = rigids[own[slot] as usize];
            (set, inverse_mass * shares[slot], own_inertia * shares[slot], center_of_mass)
        });
        if now.clone().eq(weighed.iter().copied()) {
            return false;
        }
        weighed.clear();
        weighed.extend(now);
        true
    }
}
