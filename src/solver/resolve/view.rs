//! What an iteration looks at.

use glam::{Vec3, Vec4};

use crate::solver::detect::{Crossing, Surface};

/// What an iteration looks at.
#[derive(Clone, Copy)]
pub(super) struct View<'a> {
    pub surface: &'a Surface,
    pub crossings: &'a [Crossing],
    pub positions: &'a [Vec4],
}

impl View<'_> {
    /// Unit normal of a face, or zero.
    pub(super) fn facing(self, face: u32) -> Vec3 {
        let [a, b, c] = self.surface.topology.faces[face as usize].map(|v| self.positions[v as usize].truncate());
        (b - a).cross(c - a).normalize_or_zero()
    }
}
