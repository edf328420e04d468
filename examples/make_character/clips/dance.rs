//! A dance of ten seconds: steps, kicks to the hip, and turns of the whole figure at 720° a second: a loop.

use glam::vec3;

use super::keys::Keys;
use super::{Clip, standing, with};
use crate::measures::TOES;
use crate::rig::{Arm, Rig};

/// Length [s].
const LENGTH: f32 = 10.0;
/// Fastest turn [degrees/s].
const WHIRL: f32 = 720.0;
/// Full turns of each whirl, and when they begin [s].
const WHIRLS: [(f32, f32); 2] = [(3.0, 2.0), (7.15, -2.0)];
/// Time to get up to speed, and to slow down again [s].
const RAMP: f32 = 0.5;

pub fn clip() -> Clip {
    let keys = keys();
    Clip::new("Dance", LENGTH, move |time| {
        let mut rig = keys.at(time);
        rig.spin = WHIRLS.iter().map(|&(start, turns)| whirled(time - start, turns)).sum();
        rig
    })
}

/// Angle of a whirl that speeds up, goes on and slows down [degrees].
fn whirled(t: f32, turns: f32) -> f32 {
    let even = 360.0 * turns.abs() / WHIRL - RAMP; // as long as it goes at full speed
    let ramp = |t: f32| {
        // Speed grows as a smooth step: its integral is t³ − t⁴ / 2 over the unit interval.
        let s = (t / RAMP).clamp(0.0, 1.0);
        RAMP * (s * s * s - s * s * s * s / 2.0) + (t - RAMP).max(0.0)
    };
    let angle = if t <= 0.0 { 0.0 } else { ramp(t) - ramp(t - RAMP - even) };
    turns.signum() * WHIRL * angle
}

fn open(swing: f32, lift: f32, elbow: f32) -> Arm {
    Arm { swing, lift, twist: -10.0, elbow, palm: -10.0, wrist: -6.0, shrug: lift * 0.08, ..Arm::default() }
}

fn keys() -> Keys {
    let rest = with(standing(), |rig| {
        rig.hips.y = -0.03;
        rig.arms = [open(12.0, 38.0, 24.0); 2];
    });
    // A step to one side: hips over it, the other heel up.
    let sway = |side: usize| {
        with(rest, |rig| {
            let s = if side == 0 { 1.0 } else { -1.0 };
            rig.hips = vec3(0.085 * s, -0.075, 0.0);
            rig.hips_turn = [-10.0 * s, 4.0, 7.0 * s];
            rig.spine = [5.0 * s, 2.0, -6.0 * s];
            rig.chest = [12.0 * s, -4.0, -6.0 * s];
            rig.look = [6.0 * s, 0.0, 5.0 * s];
            let other = 1 - side;
            rig.feet[other].pitch = -30.0;
            rig.feet[other].toes = 30.0;
            rig.feet[other].knee = -8.0;
            rig.arms[side] = open(10.0, 96.0, 34.0);
            rig.arms[other] = open(44.0, 26.0, 70.0);
        })
    };
    let passing = |side: usize| {
        // Both feet near each other, one of them lifted.
        with(rest, |rig| {
            rig.hips.y = -0.045;
            rig.feet[side].at.y = 0.06;
            rig.feet[side].pitch = -18.0;
            rig.arms = [open(26.0, 50.0, 44.0); 2];
        })
    };
    let kick = |side: usize| {
        with(rest, |rig| {
            let s = if side == 0 { 1.0 } else { -1.0 };
            rig.hips = vec3(-0.085 * s, -0.030, 0.0);
            rig.hips_turn = [-10.0 * s, -20.0, 5.0 * s];
            rig.spine[1] = 6.0;
            rig.chest = [16.0 * s, 12.0, 0.0];
            rig.look[0] = -8.0 * s;
            rig.feet[side].at = vec3(-0.03 * s, 0.84, 0.80);
            rig.feet[side].pitch = -8.0;
            rig.feet[side].yaw = 0.0;
            rig.arms[side] = open(-22.0, 62.0, 22.0);
            rig.arms[1 - side] = open(72.0, 30.0, 18.0);
        })
    };
    let raise = |side: usize| {
        with(rest, |rig| {
            let s = if side == 0 { 1.0 } else { -1.0 };
            rig.hips = vec3(-0.080 * s, -0.045, 0.0);
            rig.hips_turn[2] = 4.0 * s;
            rig.feet[side].at = vec3(-0.02 * s, 0.34, 0.16);
            rig.feet[side].pitch = -36.0;
            rig.feet[side].yaw = 0.0;
            rig.arms[side] = open(10.0, 50.0, 30.0);
            rig.arms[1 - side] = open(40.0, 44.0, 34.0);
        })
    };
    // The whirl: on one ball, the other foot at the ankle, arms first wide, then in.
    let whirl = |wide: f32| {
        with(rest, |rig| {
            rig.hips = vec3(-0.018, 0.034, -0.040);
            rig.hips_turn[1] = 0.0;
            // The ball of the foot is where the root turns.
            rig.feet[0].yaw = 0.0;
            rig.feet[0].at = vec3(-TOES.x, 0.0, -TOES.z);
            rig.feet[0].pitch = -38.0;
            rig.feet[0].toes = 38.0;
            rig.feet[1].at = vec3(0.025, 0.20, -0.02);
            rig.feet[1].pitch = -46.0;
            rig.feet[1].knee = 34.0;
            rig.arms = [open(38.0 - 16.0 * wide, 40.0 + 42.0 * wide, 70.0 - 46.0 * wide); 2];
        })
    };
    let hop = with(whirl(1.0), |rig| {
        rig.hips.y = -0.02;
        rig.feet[0].at = vec3(-TOES.x / 2.0, 0.035, -TOES.z / 2.0);
        rig.feet[0].pitch = -24.0;
        rig.feet[0].toes = 10.0;
        rig.feet[1].at = vec3(0.0, 0.0, 0.0);
        rig.feet[1].pitch = -4.0;
        rig.feet[1].toes = 4.0;
        rig.feet[1].knee = 8.0;
    });
    let dip = with(rest, |rig| {
        rig.hips = vec3(0.0, -0.21, -0.06);
        rig.hips_turn[1] = 16.0;
        rig.spine[1] = 6.0;
        rig.feet.iter_mut().for_each(|foot| foot.knee = 16.0);
        rig.arms = [open(34.0, 64.0, 26.0); 2];
    });
    let hips = |side: f32| {
        with(rest, |rig: &mut Rig| {
            rig.hips = vec3(0.055 * side, -0.085, 0.0);
            rig.hips_turn = [18.0 * side, 4.0, 9.0 * side];
            rig.spine = [-8.0 * side, 2.0, -8.0 * side];
            rig.chest = [-10.0 * side, -3.0, -3.0 * side];
            rig.arms = [open(20.0, 118.0, 62.0), open(20.0, 118.0, 62.0)];
        })
    };
    Keys::new(vec![
        (0.0, rest),
        (0.40, sway(0)),
        (0.68, passing(0)),
        (0.98, sway(1)),
        (1.28, raise(0)),
        (1.54, kick(0)),
        (1.66, kick(0)),
        (1.94, raise(0)),
        (2.22, rest),
        (2.62, dip),
        (2.84, hop),
        (3.05, whirl(1.0)),
        (3.35, whirl(0.2)),
        (3.95, whirl(0.2)),
        (4.46, whirl(1.0)),
        (4.62, hop),
        (4.80, rest),
        (5.04, hips(1.0)),
        (5.36, hips(-1.0)),
        (5.68, hips(1.0)),
        (5.98, raise(1)),
        (6.24, kick(1)),
        (6.36, kick(1)),
        (6.60, raise(1)),
        (6.84, rest),
        (7.02, hop),
        (7.22, whirl(1.0)),
        (7.45, whirl(0.2)),
        (8.05, whirl(0.2)),
        (8.56, whirl(1.0)),
        (8.74, hop),
        (8.94, dip),
        (9.20, sway(1)),
        (9.52, passing(1)),
        (LENGTH - 0.14, rest),
        (LENGTH, rest),
    ])
}
