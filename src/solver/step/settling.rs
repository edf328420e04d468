//! Whether a cloth is settling, and what moves less than it seems to.

use glam::Vec4;

use super::Scratch;
use crate::solver::scales::RESPONSE_TIME;
use crate::solver::state::StateMut;

/// Root mean square of the speeds over a frame below which a cloth begins to settle `[m/s]`; at twice that it no longer does.
const SETTLING_SPEED: f32 = 0.03;

/// What a settling cloth loses of its velocities on top of drag `[1/s]`. What one sweep over constraints in a row leaves over
/// keeps going around for ever otherwise.
pub(super) const SETTLING_DRAG: f32 = 6.0;

/// What got less far within a frame than this share of the way its speed would take it is stuck (dimensionless). Constraints
/// pull it to and fro between them. In a settling cloth it has the speed of its mean motion.
const OSCILLATING: f32 = 0.25;

impl Scratch {
    /// Whether the cloth has been slow for a while.
    #[must_use]
    pub fn is_settling(&self) -> bool {
        self.slow_for >= RESPONSE_TIME
    }

    /// Notes for how long the cloth has been slow, after a frame of `dt` `[s]` in which its mean square of speeds was `speed2`
    /// `[m²/s²]`.
    pub(super) fn note_speed(&mut self, speed2: f32, dt: f32) {
        let bound = if self.is_settling() { 2.0 * SETTLING_SPEED } else { SETTLING_SPEED };
        // False for what is not a number.
        self.slow_for = if speed2 <= bound * bound { (self.slow_for + dt).min(1.0) } else { 0.0 };
    }
}

/// Gives particles that hardly moved [`OSCILLATING`] since they were `before`, a substep being the `share` of that time, the
/// speed with which they did.
pub(super) fn damp_oscillation(before: &[Vec4], share: f32, state: &mut StateMut<'_>) {
    for ((x, old), before) in state.positions.iter().zip(&mut *state.previous).zip(before) {
        let (motion, mean) = (*x - *old, (*x - *before) * share);
        if mean.length_squared() < OSCILLATING * OSCILLATING * motion.length_squared() {
            *old = *x - mean;
        }
    }
}

/// Mean square of speeds `[m²/s²]`: of free particles that were `before` and are where they are after a frame of `dt` `[s]`.
/// Where constraints pull against each other within it, they only tremble.
pub(super) fn mean_square_speed(positions: &[Vec4], before: &[Vec4], dt: f32) -> f32 {
    let (mut sum, mut count) = (0.0, 0u32);
    for (x, before) in positions.iter().zip(before) {
        if x.w > 0.0 {
            sum += (*x - *before).truncate().length_squared();
            count += 1;
        }
    }
    sum / (count.max(1) as f32 * dt * dt)
}
