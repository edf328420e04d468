//! Clothes that are worn closer to a bone than thickness and margin ask for: a collar, a waistband, a sleeve.
//!
//! ```text
//!   kept from the bone = min(thickness + margin, distance in the bind pose)
//! ```
//!
//! The margin is there for the flesh that sticks out of the bones. Where cloth was made closer than that, nothing sticks out.
//! Pushed out all the same, a whole sleeve would be stretched over its arm, and cloth between arm and chest would have no room.

use glam::{Vec3, Vec3A};

use super::SharedShape;
use super::geometry::for_each_geometry;

/// Particles of a cloth that a bone was made close to.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Snug {
    /// Particles, sorted, and their distances in the bind pose `[m]`; below zero inside the shape.
    particles: Vec<(u32, f32)>,
}

impl Snug {
    /// The particles nearer than `reach` `[m]` to a shape. `points`: all particles of the cloth in the bind pose, in the space
    /// of the shape `[m]`.
    #[must_use]
    pub fn of(shape: &SharedShape, reach: f32, points: &[Vec3]) -> Self {
        let mut nearest = vec![f32::INFINITY; points.len()];
        let mut planes = Vec::new();
        for_each_geometry(&*shape.0, &mut planes, |_, local, _, geometry| {
            for (nearest, point) in nearest.iter_mut().zip(points) {
                let sample = geometry.sample(Vec3A::from(local.inverse_transform_point(*point)), reach);
                *nearest = nearest.min(sample.distance);
            }
        });
        Self { particles: (0..).zip(nearest).filter(|(_, distance)| *distance < reach).collect() }
    }

    /// Whether there are any.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.particles.is_empty()
    }

    /// Distance of a particle in the bind pose `[m]`; none for one that is farther away than was listed.
    #[must_use]
    pub fn distance(&self, particle: u32) -> Option<f32> {
        let at = self.particles.binary_search_by_key(&particle, |(particle, _)| *particle);
        at.ok().map(|at| self.particles[at].1)
    }

    /// By how much nearer than `keep` `[m]` a particle may be.
    #[inline]
    pub(super) fn inset(&self, particle: u32, keep: f32) -> f32 {
        self.distance(particle).map_or(0.0, |distance| (keep - distance).max(0.0))
    }
}

#[cfg(test)]
mod tests {
    use glam::vec3;

    use super::*;

    #[test]
    fn what_was_made_closer_than_is_kept_may_be_as_close() {
        let arm = SharedShape::capsule_y(0.2, 0.05);
        let points = [vec3(0.06, 0.0, 0.0), vec3(0.0, 0.0, 0.1), vec3(0.04, 0.1, 0.0), vec3(0.0, 0.5, 0.0)];
        let snug = Snug::of(&arm, 0.02, &points);
        let insets: Vec<f32> = (0..4).map(|particle| snug.inset(particle, 0.015)).collect();
        for (inset, expected) in insets.iter().zip([0.005, 0.0, 0.025, 0.0]) {
            assert!((inset - expected).abs() < 1.0e-6, "{insets:?}");
        }
        assert!(Snug::of(&arm, 0.0, &points[..2]).is_empty());
    }
}
