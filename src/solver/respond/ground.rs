//! Which particles of pairs lie on bodies in a substep, and on which side of them.

use glam::{Vec3, Vec3A};

use crate::solver::topology::NONE;

/// Cosine of the angle within which two normals are one.
const SAME: f32 = 0.999;

/// Unit normals of the bodies that particles lie on.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Ground {
    /// Last normal of each particle, or [`NONE`].
    last: Vec<u32>,
    /// Each with how far along it the body put the particle in the substep `[m]`, and the one before it
    /// of its particle, or [`NONE`].
    normals: Vec<(Vec3A, f32, u32)>,
    /// Sum of the ways of what they lie on in the substep `[m]`.
    ways: Vec3A,
}

impl Ground {
    /// Begins with nothing on anything, among `particles`, of which `paired` are in pairs.
    pub(super) fn begin(&mut self, particles: usize, paired: usize) {
        self.ways = Vec3A::ZERO;
        self.normals.clear();
        self.last.clear();
        self.last.resize(particles, NONE);
        // Corners of boxes have three, and what lies flat has one.
        self.normals.reserve(2 * paired);
    }

    /// A body that went `way` `[m]` pushes a particle along `normal`, and has put it so far from where it was `[m]`.
    pub(super) fn add(&mut self, particle: u32, normal: Vec3A, way: Vec3A, put: Vec3A) {
        let floor = normal.dot(put);
        if self.of(particle).any(|(known, above)| known.dot(normal) > SAME && above >= floor) {
            return;
        }
        if let Some(last) = self.last.get_mut(particle as usize) {
            self.normals.push((normal, floor, *last));
            self.ways += way;
            *last = self.normals.len() as u32 - 1;
        }
    }

    /// Mean way of what particles lie on `[m]`; `None` where nothing does.
    pub(super) fn mean_way(&self) -> Option<Vec3> {
        let mean = self.ways / self.normals.len() as f32;
        mean.is_finite().then_some(mean.into())
    }

    /// The normals of a particle, and how far along them bodies put it in the substep `[m]`.
    pub(super) fn of(&self, particle: u32) -> impl Iterator<Item = (Vec3A, f32)> + '_ {
        let known = |at: u32| self.normals.get(at as usize);
        let last = self.last.get(particle as usize).and_then(|&at| known(at));
        core::iter::successors(last, move |(.., before)| known(*before)).map(|(normal, floor, _)| (*normal, *floor))
    }
}
