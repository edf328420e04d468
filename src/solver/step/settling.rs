//! Whether a cloth is settling, and what moves less than it seems to.

use glam::Vec4;

use super::Memory;
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

impl Memory {
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

#[cfg(test)]
mod tests {
    use glam::{Vec3, vec3};

    use super::*;
    use crate::solver::state::ClothState;

    const DT: f32 = 1.0 / 64.0;

    #[test]
    fn a_cloth_settles_once_it_was_slow_for_a_while_and_until_it_is_twice_as_fast() {
        // Speeds in settling speeds, for so many frames; whether it settles after them. A quarter of a second is 16 frames.
        let rows = [
            (0.9, 15, false),
            (0.9, 1, true),
            (1.9, 40, true),
            (2.1, 1, false),
            (1.1, 40, false),
            (1.0, 15, false),
            (1.1, 1, false),
            (0.0, 15, false),
            (0.0, 1, true),
            (f32::NAN, 1, false),
            (0.5, 16, true),
            (f32::INFINITY, 1, false),
        ];
        let mut memory = Memory::default();
        for (row, (speed, frames, settles)) in rows.into_iter().enumerate() {
            let speed = speed * SETTLING_SPEED;
            (0..frames).for_each(|_| memory.note_speed(speed * speed, DT));
            assert_eq!(memory.is_settling(), settles, "row {row}: slow for {} s", memory.slow_for);
        }
        (0..1000).for_each(|_| memory.note_speed(0.0, DT));
        assert_eq!(memory.slow_for, 1.0, "no more is counted");
    }

    #[test]
    fn what_got_less_far_than_a_quarter_of_its_speed_is_given_the_speed_with_which_it_got_there() {
        let at = vec3(1.0, 2.0, 3.0);
        // In a frame of 8 substeps: its way in the frame, that in the last substep, and what it then has [mm].
        let rows = [
            (8.0 * Vec3::X, 3.9 * Vec3::X, 3.9 * Vec3::X),
            (8.0 * Vec3::X, 4.1 * Vec3::X, Vec3::X),
            (8.0 * Vec3::X, 4.1 * Vec3::Y, Vec3::X),
            (8.0 * Vec3::X, -4.1 * Vec3::X, Vec3::X),
            (Vec3::ZERO, 0.1 * Vec3::Z, Vec3::ZERO),
            (8.0 * Vec3::Z, Vec3::ZERO, Vec3::ZERO),
            (Vec3::ZERO, Vec3::ZERO, Vec3::ZERO),
        ];
        for w in [2.0, 0.0] {
            let place = |off: Vec3| (at - 1.0e-3 * off).extend(w);
            let mut state = ClothState {
                positions: vec![place(Vec3::ZERO); rows.len()],
                previous: rows.iter().map(|row| place(row.1)).collect(),
                ..ClothState::default()
            };
            let before: Vec<Vec4> = rows.iter().map(|row| place(row.0)).collect();
            damp_oscillation(&before, 1.0 / 8.0, &mut state.as_mut());
            for (row, old) in rows.iter().zip(&state.previous) {
                let left = 1.0e3 * (at - old.truncate());
                assert!(left.distance(row.2) < 1.0e-3 && old.w == w, "{row:?}: {left}");
            }
            assert!(state.positions.iter().all(|x| *x == place(Vec3::ZERO)));
        }
    }

    #[test]
    fn the_mean_square_of_speeds_is_that_of_free_particles_over_the_frame() {
        let before = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let way = [vec3(0.03, 0.0, 0.04), Vec3::ZERO, vec3(0.0, 0.0, -0.1), 9.0 * Vec3::X];
        let speed2 = |w: [f32; 4]| {
            let before: Vec<Vec4> = before.iter().zip(w).map(|(x, w)| x.extend(w)).collect();
            let now: Vec<Vec4> = before.iter().zip(way).map(|(x, way)| *x + way.extend(0.0)).collect();
            mean_square_speed(&now, &before, 0.5)
        };
        for (w, expected) in [
            ([1.0, 1.0, 1.0, 0.0], (0.0025 + 0.01) / 3.0 / 0.25),
            ([5.0, 0.0, 0.0, 0.0], 0.01),
            ([0.0, 2.0, 0.0, 0.0], 0.0),
            ([0.0; 4], 0.0),
        ] {
            let speed2 = speed2(w);
            assert!((speed2 - expected).abs() < 1.0e-6, "{w:?}: {speed2}, {expected} expected");
        }
    }
}
