//! Half a turn to the left within half a second, with a wind-up to the other side; a rest; and half a turn back.

use glam::vec3;

use super::keys::Keys;
use super::{Clip, standing, with};
use crate::measures::ANKLE;
use crate::rig::{Foot, Rig};

/// Length [s].
const LENGTH: f32 = 3.0;

pub fn clip() -> Clip {
    let keys = keys();
    Clip::new("Turn", LENGTH, move |time| {
        let mut rig = keys.at(time);
        let half = LENGTH / 2.0;
        // The way back is the way there, mirrored in time about the middle of the rest, but wound up anew.
        let (start, sign, base) = if time < half { (WIND_UP, 1.0, 0.0) } else { (half + WIND_UP, -1.0, 180.0) };
        let turned = |delay: f32| base + sign * 180.0 * eased((time - start - delay) / TURN);
        for (side, foot) in rig.feet.iter_mut().enumerate() {
            // The foot on the outside goes first.
            let first = (side == 1) == (sign > 0.0);
            let delay = if first { -0.05 } else { 0.05 };
            let angle = turned(delay);
            *foot = around(side, angle, lift((time - start - delay) / TURN));
        }
        rig.hips_turn[0] += turned(0.0);
        rig
    })
}

/// Time before the turn begins, and how long it takes [s].
const WIND_UP: f32 = 0.45;
const TURN: f32 = 0.5;

/// From 0 to 1, with no speed at both ends and no jump of acceleration.
fn eased(t: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    t * t * t * (t * (6.0 * t - 15.0) + 10.0)
}

/// How high a foot is on its way [m].
fn lift(t: f32) -> f32 {
    const HEIGHT: f32 = 0.045;
    let t = t.clamp(0.0, 1.0);
    HEIGHT * (16.0 * t * t * (1.0 - t) * (1.0 - t))
}

/// A foot on the circle about the middle of the stance.
fn around(side: usize, angle: f32, height: f32) -> Foot {
    const SPREAD: f32 = 0.03;
    let s = if side == 0 { 1.0 } else { -1.0 };
    let (sin, cos) = angle.to_radians().sin_cos();
    let (x, z) = (s * (ANKLE.x + SPREAD), 0.0);
    let place = vec3(x * cos + z * sin, height, -x * sin + z * cos);
    // The ankle lies behind the middle; it goes around with the foot.
    let back = vec3(ANKLE.z * sin, 0.0, ANKLE.z * cos);
    Foot { at: place + back - vec3(s * ANKLE.x, 0.0, ANKLE.z), yaw: angle + s * 8.0, ..Foot::default() }
}

fn keys() -> Keys {
    let rest = with(standing(), |rig| rig.hips.y = -0.025);
    let wind = |sign: f32| {
        with(rest, |rig| {
            rig.hips.y = -0.060;
            rig.hips_turn = [-10.0 * sign, 3.0, 0.0];
            rig.spine[0] = -10.0 * sign;
            rig.chest[0] = -16.0 * sign;
            rig.look[0] = 22.0 * sign;
            rig.arms[0].swing = if sign > 0.0 { 32.0 } else { -24.0 };
            rig.arms[1].swing = if sign > 0.0 { -24.0 } else { 32.0 };
            rig.arms.iter_mut().for_each(|arm| arm.elbow = 34.0);
        })
    };
    let whirl = |sign: f32| {
        with(rest, |rig| {
            rig.hips.y = -0.035;
            rig.hips_turn = [0.0, 2.0, 0.0];
            rig.spine[0] = 4.0 * sign;
            rig.chest[0] = 10.0 * sign;
            rig.look[0] = 18.0 * sign;
            rig.arms.iter_mut().for_each(|arm| {
                arm.lift = 30.0;
                arm.elbow = 30.0;
            });
        })
    };
    let land = |sign: f32| {
        with(rest, |rig: &mut Rig| {
            rig.hips.y = -0.055;
            rig.spine[0] = 5.0 * sign;
            rig.chest[0] = 9.0 * sign;
            rig.arms[0].swing = -12.0 * sign;
            rig.arms[1].swing = 14.0 * sign;
            rig.arms.iter_mut().for_each(|arm| arm.lift = 20.0);
        })
    };
    let half = LENGTH / 2.0;
    Keys::new(vec![
        (0.0, rest),
        (0.40, wind(1.0)),
        (0.68, whirl(1.0)),
        (1.02, land(1.0)),
        (1.36, rest),
        (half, rest),
        (half + 0.40, wind(-1.0)),
        (half + 0.68, whirl(-1.0)),
        (half + 1.02, land(-1.0)),
        (LENGTH - 0.12, rest),
        (LENGTH, rest),
    ])
}
