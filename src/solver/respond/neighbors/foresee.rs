//! Where particles are foreseen to be at the next look.

use glam::Vec3A;

use super::looked::Looked;
use super::{Moment, NeighborList};
use crate::solver::detect::Surface;
use crate::solver::scales::FARTHEST;

/// Mean way of the cloth until the next look that is not worth knowing, in thicknesses (dimensionless).
const HARDLY: f32 = 1.0 / 24.0;

/// How far ahead a particle is looked for, at most, in mean edges plus thicknesses. Boxes swept farther meet half of the cloth.
const FARTHEST_AHEAD: f32 = 4.0;

/// The farthest way that is foreseen `[m]`.
pub(super) fn longest_way(surface: &Surface, thickest: f32) -> f32 {
    FARTHEST_AHEAD * (surface.mean_edge + thickest)
}

impl NeighborList {
    /// Takes the motion of the last substep, as far as it lasts, for that of the next frame, less what all cloths share.
    pub(super) fn foresee(&mut self, surface: &Surface, moment: &Moment<'_>, dt: f32) {
        let substep = moment.substep;
        for (face, t) in self.faces.iter_mut().zip(&surface.topology.faces) {
            *face = Looked::at(t.map(|v| Vec3A::from_vec4(moment.positions[v as usize])), 0.0);
        }
        self.astray.fill(false);
        self.shifted.fill(false);
        let mut mean = Vec3A::ZERO;
        for (part, &h) in surface.parts.iter().zip(substep) {
            let scale = if h > 0.0 { dt / h } else { 0.0 };
            for v in part.range() {
                let motion = limited(foreseen(moment, v, scale, self.before[v], 1.0), FARTHEST);
                self.start[v] = Vec3A::from_vec4(moment.positions[v]);
                self.ahead[v] = self.start[v] + motion;
                mean += motion;
            }
        }
        mean /= surface.len().max(1) as f32;
        // Cloth that hardly moves is looked at as it is, so that the look holds longer.
        let hardly = HARDLY * moment.touch.iter().map(|t| t.thickness).fold(f32::INFINITY, f32::min);
        if mean.length_squared() <= hardly * hardly {
            mean = Vec3A::ZERO;
        }
        self.shared = mean;
        let longest = longest_way(surface, moment.thickest());
        let mut sum = 0.0;
        for (ahead, &start) in self.ahead.iter_mut().zip(&self.start) {
            let motion = *ahead - start - mean;
            sum += motion.length();
            *ahead = start + limited(motion, longest);
        }
        self.haste = if dt > 0.0 { sum / (surface.len().max(1) as f32 * dt) } else { 0.0 };
    }
}

/// The motion of particle `v` until the next look `[m]`: that of the last substep times `scale`, as far as it lasts. How far
/// that is follows from its way since it was `before`, by a least squares fit of the motion. That way is taken times `ahead`,
/// the time until the next look over the time since. Where constraints pull to and fro, little of it lasts. What has come
/// farther than it goes now, as something stopped, turned or carried it, has all of it.
#[inline]
pub(super) fn foreseen(moment: &Moment<'_>, v: usize, scale: f32, before: Vec3A, ahead: f32) -> Vec3A {
    let motion = Vec3A::from_vec4(moment.positions[v] - moment.previous[v]) * scale;
    let way = (Vec3A::from_vec4(moment.positions[v]) - before) * ahead;
    let square = motion.length_squared();
    // Of what has no past, nothing is known: NaN passes no comparison.
    if way.length_squared() < square { motion * (way.dot(motion) / square).max(0.0) } else { motion }
}

/// A motion no longer than `longest` `[m]`: of what goes farther, the rest is looked for when it gets there.
#[inline]
pub(super) fn limited(motion: Vec3A, longest: f32) -> Vec3A {
    let motion = motion.clamp_length_max(longest);
    if motion.is_finite() { motion } else { Vec3A::ZERO }
}

#[cfg(test)]
mod tests {
    use glam::{Vec4, vec3a};

    use super::*;
    use crate::solver::effort::Effort;

    #[test]
    fn as_much_of_a_motion_is_foreseen_as_lasted() {
        let step = vec3a(0.001, 0.0, 0.0);
        let foresee = |before: Vec3A, ahead: f32| {
            let (positions, previous) = ([Vec4::ZERO], [-Vec4::from((step, 0.0))]);
            let (touch, takes_part, pinned, substep) = (&[], &[], &[], &[]);
            let moment = Moment {
                positions: &positions,
                previous: &previous,
                substep,
                touch,
                takes_part,
                pinned,
                most: Effort::UNBOUNDED,
                jobs: None,
            };
            foreseen(&moment, 0, 6.0, before, ahead)
        };
        let close = |a: Vec3A, b: Vec3A| assert!(a.distance(b) < 1.0e-8, "{a} is not {b}");
        close(foresee(-6.0 * step, 1.0), 6.0 * step);
        close(foresee(-3.0 * step, 1.0), 3.0 * step);
        close(foresee(-12.0 * step, 1.0), 6.0 * step);
        close(foresee(vec3a(0.0, -0.005, 0.0), 1.0), Vec3A::ZERO);
        close(foresee(vec3a(0.0, -0.01, 0.0), 1.0), 6.0 * step);
        close(foresee(5.0 * step, 1.0), Vec3A::ZERO);
        close(foresee(-3.0 * step, 2.0), 6.0 * step);
        close(foresee(Vec3A::INFINITY, 1.0), 6.0 * step);
    }
}
