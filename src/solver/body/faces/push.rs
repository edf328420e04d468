//! Pushes the nearest point of a face out, shared out by mass to its corners.

use glam::Vec3A;

use super::piece::Piece;
use super::setting::{Setting, State, Way};
use crate::solver::body::nearest::{Near, at};
use crate::solver::body::respond::{Plane, mean_load, push_out};

/// Least mobility of the nearest point, as a share of that of the lightest corner. A face of which two corners are held is not
/// levered by the third.
const LEVERED: f32 = 0.05;

impl Setting<'_> {
    /// Pushes the nearest point of a face out, and shares that out by mass; whether anything could.
    pub(super) fn push(&self, near: &Near, plane: Plane, way: &mut Way, state: &mut State<'_, '_>) -> bool {
        let State { candidate, positions, previous, rigid } = state;
        if !self.takes(candidate.piece, &near.weights, &way.to) {
            return false;
        }
        let w = near.weights;
        let Some(mobility) = mobility(&w, &way.masses) else { return false };
        let (start, end) = (at(&way.from, &w), at(&way.to, &w));
        let place = |q: Vec3A| self.motion.rotation1 * q + self.motion.translation1;
        let pushed = push_out(plane, start, end, end, self.recovery, 0.0);
        let mut by = self.motion.rotation1 * (pushed.end - end);
        let mut silent = self.motion.rotation0 * pushed.shift;
        if !(by.is_finite() && silent.is_finite()) {
            return false;
        }
        if let Some(rigid) = rigid
            && by != Vec3A::ZERO
        {
            // Faces share particles: one after the other, and the body moves with each.
            (by, silent) = rigid.split(mobility, place(pushed.end), by, silent);
            rigid.give_now();
        }
        candidate.load = mean_load(candidate.load, pushed.push);
        (candidate.plane, candidate.weights, candidate.floor) = (plane, w, plane.gap(pushed.end).min(0.0));
        let mut most = 0.0;
        for (i, &p) in candidate.particles.iter().enumerate() {
            let share = w[i] * way.masses[i] / mobility;
            let (Some(x), Some(old)) = (positions.get_mut(p as usize), previous.get_mut(p as usize)) else { continue };
            *x += (by * share).extend(0.0);
            *old += (silent * share).extend(0.0);
            way.to[i] += self.motion.rotation1.transpose() * (by * share);
            way.from[i] += self.motion.rotation0.transpose() * (silent * share);
            if w[i] > most && way.masses[i] > 0.0 {
                // M C = m c: the same impulse from the corner alone.
                (most, candidate.corner, candidate.share) = (w[i], p, way.masses[i] / mobility);
            }
        }
        if let Piece::Edge(_) = candidate.piece {
            (way.to[2], way.from[2]) = (way.to[1], way.from[1]);
        }
        true
    }
}

/// How far a unit push moves the point with these weights `[1/kg]`; nothing where that is too little for it to be pushed.
pub(super) fn mobility(weights: &[f32; 3], masses: &[f32; 3]) -> Option<f32> {
    let mobility: f32 = weights.iter().zip(masses).map(|(weight, mass)| weight * weight * mass).sum();
    let lightest = masses.iter().copied().fold(0.0, f32::max);
    // NaN passes no comparison.
    (mobility > LEVERED * lightest).then_some(mobility)
}
