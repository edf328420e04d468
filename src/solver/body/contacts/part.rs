//! One part of a body against all particles listed for it, in one substep.

use glam::{Mat3A, Vec3, Vec3A, Vec4};

use super::Candidate;
use crate::solver::body::distance::Sample;
use crate::solver::body::motion::{Motion, RigidProxy};
use crate::solver::body::respond::Projection;
use crate::solver::body::squeeze::Squeezes;
use crate::solver::scales::TOUCHING;

/// Positions at both ends of the substep.
pub(super) struct Particles<'a> {
    pub(super) positions: &'a mut [Vec4],
    pub(super) previous: &'a mut [Vec4],
    /// Last known places, by candidate; empty except for surfaces.
    pub(super) places: &'a mut [Vec3],
    pub(super) squeezes: &'a mut Squeezes,
}

/// Everything that is the same for all candidates of one part in one substep.
pub(super) struct Setting<'a> {
    pub(super) motion: Motion,
    /// The body, if it takes what it does to the cloth.
    pub(super) rigid: Option<RigidProxy<'a>>,
    /// Whether no time passes.
    pub(super) timeless: bool,
    /// Distance kept `[m]`.
    pub(super) keep: f32,
    /// Place of the part among the parts.
    pub(super) number: u32,
    /// How deep a straight path may cut a corner between two points outside `[m]`.
    pub(super) clip: f32,
    /// Which projection of the substep it is.
    pub(super) projection: Projection,
    /// Way that an overlap is recovered in the substep `[m]`.
    pub(super) recovery: f32,
    pub(super) restitution: f32,
    /// Way of an approach from which on it bounces `[m]`.
    pub(super) impact: f32,
    /// Ways in the substep `[m]` if nothing held the cloth together; empty: nothing bounces.
    pub(super) inbound: &'a [Vec4],
}

impl Setting<'_> {
    /// `COSTLY`: a sample is a search in a tree, so remember how far away nothing is.
    #[inline]
    pub(super) fn project<const COSTLY: bool>(
        mut self,
        candidates: &mut [Candidate],
        particles: &mut Particles<'_>,
        sample: impl Fn(Vec3A, f32) -> Sample,
    ) -> u32 {
        let to_body = [self.motion.rotation0, self.motion.rotation1].map(|rotation| rotation.transpose());
        let mut contacts = 0;
        if self.rigid.as_ref().is_some_and(RigidProxy::is_movable) {
            let touches = self.touches::<COSTLY>(candidates, particles.positions, to_body[1], &sample);
            if let Some(rigid) = &mut self.rigid {
                rigid.several = touches.max(1) as f32;
            }
        }
        for (k, kept) in candidates.iter_mut().enumerate().filter(|(_, candidate)| !candidate.left_out) {
            // While no time passes loads stay.
            let mut spare;
            let candidate = if self.timeless {
                spare = *kept;
                &mut spare
            } else {
                kept
            };
            let load = candidate.load;
            let touches = self.meet::<COSTLY>(k, candidate, particles, to_body, &sample);
            if !touches && self.projection == Projection::Relax {
                candidate.load = load;
            }
            contacts += u32::from(touches);
        }
        if let Some(rigid) = self.rigid {
            rigid.finish();
        }
        contacts
    }

    /// How many particles touch a body before any of them is put anywhere.
    #[inline]
    fn touches<const COSTLY: bool>(
        &self,
        candidates: &[Candidate],
        positions: &[Vec4],
        to_body1: Mat3A,
        sample: &impl Fn(Vec3A, f32) -> Sample,
    ) -> usize {
        let band = TOUCHING * self.keep;
        let touches = candidates.iter().filter(|candidate| !candidate.left_out).filter(|candidate| {
            let Some(x) = positions.get(candidate.particle as usize) else { return false };
            let q = to_body1 * (Vec3A::from_vec4(*x) - self.motion.translation1);
            let off = (q - Vec3A::from(candidate.clear_at)).length();
            let clear = COSTLY && candidate.clear - off >= self.keep + band;
            !clear && sample(q, self.keep + band).distance + candidate.inset < self.keep + band
        });
        touches.count()
    }
}
