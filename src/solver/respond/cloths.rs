//! What pairs ask of their cloths.

use glam::Vec3;

use crate::solver::body::{Friction, Touch};

/// The cloths of an island, by number.
#[derive(Clone, Copy)]
pub(super) struct Cloths<'a> {
    /// From the frame of simulation of each to that of the island `[m]`.
    pub offsets: &'a [Vec3],
    /// Friction and restitution of each.
    pub touch: &'a [Touch],
}

impl Cloths<'_> {
    /// Friction between two cloths.
    pub(super) fn friction(&self, parts: [u16; 2]) -> Friction {
        let [first, second] = parts.map(|part| self.touch(part)).map(|touch| (touch.static_friction, touch.dynamic_friction));
        Friction::between(first, second)
    }

    /// Speed of two cloths apart after an impact over that of approach before (dimensionless).
    pub(super) fn restitution(&self, parts: [u16; 2]) -> f32 {
        let [first, second] = parts.map(|part| self.touch(part).restitution);
        first.max(second)
    }

    fn touch(&self, part: u16) -> Touch {
        self.touch.get(usize::from(part)).copied().unwrap_or_default()
    }
}

/// From the frame of simulation of the first cloth to that of the second `[m]`, by the `offsets` of all.
#[inline]
pub(super) fn offset_between([first, second]: [u16; 2], offsets: &[Vec3]) -> Vec3 {
    if first == second { Vec3::ZERO } else { offset_of(first, offsets) - offset_of(second, offsets) }
}

/// From the frame of simulation of a cloth to that of the island `[m]`.
#[inline]
pub(super) fn offset_of(part: u16, offsets: &[Vec3]) -> Vec3 {
    offsets.get(usize::from(part)).copied().unwrap_or_default()
}
