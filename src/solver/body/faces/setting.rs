//! One part in one substep, and the way of a face in its space.

use glam::{Vec3A, Vec4};

use super::Candidate;
use crate::solver::body::feature_edges::FeatureEdge;
use crate::solver::body::geometry::Geometry;
use crate::solver::body::motion::{Motion, RigidProxy};
use crate::solver::body::nearest::{Convex, Face};
use crate::solver::scales::FARTHEST;

/// Corners at both ends of the substep, in the part's own space `[m]`, and inverse masses `[1/kg]`.
pub(super) struct Way {
    pub(super) from: Face,
    pub(super) to: Face,
    pub(super) masses: [f32; 3],
}

/// Everything that is the same for all faces near one part in one substep.
pub(super) struct Setting<'a> {
    pub(super) part: Convex<'a>,
    pub(super) motion: Motion,
    pub(super) radius: f32,
    pub(super) pierces: bool,
    /// Place of the part among the parts.
    pub(super) number: u32,
    /// Distance kept `[m]`.
    pub(super) keep: f32,
    /// Way that an overlap is recovered in the substep `[m]`.
    pub(super) recovery: f32,
}

/// What a push changes.
pub(super) struct State<'a, 'b> {
    pub(super) candidate: &'a mut Candidate,
    pub(super) positions: &'a mut [Vec4],
    pub(super) previous: &'a mut [Vec4],
    pub(super) rigid: &'a mut Option<RigidProxy<'b>>,
}

impl Setting<'_> {
    /// Looks at a feature edge from now on: a capsule without radius.
    pub(super) fn take(&mut self, feature_edge: Option<&FeatureEdge>) {
        let Some(&FeatureEdge { a, b }) = feature_edge else { return };
        self.part.geometry = Geometry::capsule(a, b, 0.0);
    }

    /// `None` for corners that are left out or not numbers.
    #[inline]
    pub(super) fn way(&self, particles: [u32; 3], positions: &[Vec4], previous: &[Vec4]) -> Option<Way> {
        let mut way = Way { from: [Vec3A::ZERO; 3], to: [Vec3A::ZERO; 3], masses: [0.0; 3] };
        for (i, p) in particles.into_iter().enumerate() {
            let (x, old) = (positions.get(p as usize)?, previous.get(p as usize)?);
            way.from[i] = self.motion.rotation0.transpose() * (Vec3A::from_vec4(*old) - self.motion.translation0);
            way.to[i] = self.motion.rotation1.transpose() * (Vec3A::from_vec4(*x) - self.motion.translation1);
            way.masses[i] = x.w;
            // False for what is not a number.
            let near = way.from[i].abs().max_element() < FARTHEST && way.to[i].abs().max_element() < FARTHEST;
            if !(near && way.from[i].is_finite() && way.to[i].is_finite()) {
                return None;
            }
        }
        Some(way)
    }

    /// Whether no corner has got far enough to touch.
    #[inline]
    pub(super) fn is_clear(&self, candidate: &Candidate, positions: &[Vec4]) -> bool {
        let room = candidate.clear;
        // What touched has to be looked at until it does not.
        room > 0.0
            && candidate.load <= 0.0
            && candidate.particles.iter().zip(candidate.corners).all(|(&p, corner)| {
                // False for what is not a number.
                positions.get(p as usize).is_some_and(|x| {
                    let q = self.motion.rotation1.transpose() * (Vec3A::from_vec4(*x) - self.motion.translation1);
                    q.distance_squared(corner.into()) < room * room
                })
            })
    }
}
