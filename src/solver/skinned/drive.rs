//! The spring to the skin.

use core::f32::consts::TAU;

use glam::Vec4;

use super::Skinned;

impl Skinned {
    /// Draws particles to their targets, in a step of `h` `[s]` from the share `s0` of the frame to `s1`. `start`: where they
    /// were before they were predicted `[m]`. It is implicit in the position and in the speed, so that no frequency is too
    /// high.
    pub fn drive(&self, [s0, s1]: [f32; 2], h: f32, start: &[Vec4], positions: &mut [Vec4]) {
        if self.frequency.is_empty() || !self.fits(positions.len()) {
            return;
        }
        let particles = positions.iter_mut().zip(start).zip(&self.frequency).enumerate();
        for (i, ((x, start), &frequency)) in particles.filter(|(_, ((x, _), frequency))| **frequency > 0.0 && x.w > 0.0) {
            let target = self.target(i, s1);
            let along = target - self.target(i, s0);
            let turn = TAU * frequency * h;
            let (stiff, damp) = (turn * turn, 2.0 * self.damping_ratio * turn);
            let at = x.truncate();
            let pull = (target - at) * stiff + (start.truncate() + along - at) * damp;
            *x += (pull / (1.0 + damp + stiff)).extend(0.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{Vec3, Vec4};

    use super::*;

    /// Where a particle is that was 1 m from its target at rest, after `time` `[s]` of steps of `h` `[s]`.
    fn response(frequency: f32, ratio: f32, h: f32, time: f32) -> f32 {
        let skinned = Skinned {
            from: vec![Vec3::ZERO],
            to: vec![Vec3::ZERO],
            frequency: vec![frequency],
            damping_ratio: ratio,
            scale: 1.0,
            ..Skinned::default()
        };
        let (mut x, mut old) = ([Vec4::new(1.0, 0.0, 0.0, 1.0)], [Vec4::new(1.0, 0.0, 0.0, 1.0)]);
        for _ in 0..(time / h).round() as u32 {
            let start = x;
            x[0] += (x[0] - old[0]) * Vec4::new(1.0, 1.0, 1.0, 0.0);
            old = start;
            skinned.drive([0.0, 1.0], h, &start, &mut x);
        }
        x[0].x
    }

    #[test]
    fn a_step_is_answered_as_the_closed_form_says_at_any_rate() {
        for rate in [240.0, 360.0, 960.0] {
            for time in [0.05, 0.1, 0.2, 0.4f32] {
                let turn = TAU * 4.0 * time;
                let exact = (1.0 + turn) * (-turn).exp();
                let got = response(4.0, 1.0, 1.0 / rate, time);
                assert!((got - exact).abs() < 0.02, "{rate} Hz, {time} s: {got} in place of {exact}");
            }
        }
    }

    #[test]
    fn no_frequency_and_no_step_is_too_much() {
        for (frequency, h) in [(60.0, 1.0 / 30.0), (60.0, 1.0e-5), (0.01, 1.0)] {
            let got = response(frequency, 1.0, h, 200.0 * h);
            assert!((0.0..=1.0).contains(&got), "{frequency} Hz, {h} s: {got}");
        }
    }

    #[test]
    fn a_target_that_moves_evenly_is_followed_without_lag() {
        let mut skinned =
            Skinned { frequency: vec![4.0], damping_ratio: 1.0, scale: 1.0, from: vec![Vec3::ZERO], ..Skinned::default() };
        let (mut x, mut old) = ([Vec4::W], [Vec4::new(-0.01, 0.0, 0.0, 1.0)]);
        for frame in 1..200 {
            skinned.to = vec![Vec3::X * (0.01 * frame as f32)];
            let start = x;
            x[0] += (x[0] - old[0]) * Vec4::new(1.0, 1.0, 1.0, 0.0);
            old = start;
            skinned.drive([0.0, 1.0], 1.0 / 360.0, &start, &mut x);
            assert!((x[0].truncate() - skinned.to[0]).length() < 1.0e-5, "frame {frame}: {}", x[0]);
            skinned.from = skinned.to.clone();
        }
    }
}
