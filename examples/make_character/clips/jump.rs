//! A jump on the spot: down, up by 0.4 m, down again, and the knees take the landing.

use super::keys::Keys;
use super::{Clip, standing, with};
use crate::field::step;
use crate::rig::{Arm, Rig};

/// Length [s].
const LENGTH: f32 = 2.4;
/// When the feet leave the ground [s], and how fast the body goes up [m/s].
const LEAVE: f32 = 0.84;
const SPEED: f32 = 2.80;
const GRAVITY: f32 = 9.81;

pub fn clip() -> Clip {
    let keys = keys();
    Clip::new("Jump", LENGTH, move |time| {
        let mut rig = keys.at(time);
        let flight = 2.0 * SPEED / GRAVITY;
        let t = (time - LEAVE).clamp(0.0, flight);
        let high = SPEED * t - GRAVITY * t * t / 2.0;
        rig.hips.y += high;
        // The heels have rolled up when the feet leave, and the balls of the feet land first.
        let tuck = 0.10 * (high / 0.40);
        for foot in &mut rig.feet {
            foot.at.y += high.max(0.0) * 1.0 + tuck * step(0.0, 0.2, t) * step(flight, flight - 0.2, t);
        }
        rig
    })
}

fn keys() -> Keys {
    let rest = standing();
    let arms = |rig: &mut Rig, swing: f32, lift: f32, elbow: f32| {
        rig.arms = [Arm { swing, lift, elbow, twist: 10.0, palm: 10.0, ..Arm::default() }; 2];
    };
    let feet = |rig: &mut Rig, pitch: f32, toes: f32| {
        for foot in &mut rig.feet {
            foot.pitch = pitch;
            foot.toes = toes;
            foot.knee = 5.0;
        }
    };
    let crouch = with(rest, |rig| {
        rig.hips.y = -0.250;
        rig.hips.z = -0.105;
        rig.hips_turn[1] = 26.0;
        rig.spine[1] = 9.0;
        rig.chest[1] = 3.0;
        arms(rig, -52.0, 16.0, 12.0);
        feet(rig, 0.0, 0.0);
    });
    let push = with(rest, |rig| {
        rig.hips.y = 0.085;
        rig.hips.z = 0.030;
        rig.hips_turn[1] = 2.0;
        rig.spine[1] = -3.0;
        rig.chest[1] = -8.0;
        arms(rig, 120.0, 20.0, 34.0);
        feet(rig, -52.0, 52.0);
    });
    let top = with(push, |rig| {
        rig.hips.y = 0.0;
        rig.hips.z = 0.0;
        rig.hips_turn[1] = 6.0;
        arms(rig, 128.0, 34.0, 28.0);
        feet(rig, -34.0, 0.0);
    });
    let reach = with(rest, |rig| {
        rig.hips.y = 0.020;
        rig.hips_turn[1] = 8.0;
        rig.spine[1] = 4.0;
        arms(rig, 66.0, 36.0, 26.0);
        feet(rig, -24.0, 24.0);
    });
    let land = with(crouch, |rig| {
        rig.hips.y = -0.235;
        arms(rig, 18.0, 32.0, 34.0);
    });
    let flight = 2.0 * SPEED / GRAVITY;
    Keys::new(vec![
        (0.0, rest),
        (0.52, crouch),
        (0.60, crouch),
        (LEAVE, push),
        (LEAVE + flight * 0.5, top),
        (LEAVE + flight, reach),
        (LEAVE + flight + 0.24, land),
        (LEAVE + flight + 0.78, rest),
        (LENGTH - 0.1, rest),
        (LENGTH, rest),
    ])
}
