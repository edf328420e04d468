//! Two punches and a kick to the height of the hip, from a guard and back to it: a loop.

use glam::vec3;

use super::keys::Keys;
use super::{Clip, standing, with};
use crate::rig::{Arm, Rig};

/// Length [s].
const LENGTH: f32 = 4.0;

pub fn clip() -> Clip {
    let keys = keys();
    Clip::new("Fight", LENGTH, move |time| keys.at(time))
}

/// Left foot in front, fists at the chin.
fn guard() -> Rig {
    with(standing(), |rig| {
        rig.hips = vec3(0.0, -0.085, -0.02);
        rig.hips_turn = [-28.0, 4.0, 0.0];
        rig.spine = [-6.0, 5.0, 0.0];
        rig.chest = [-4.0, 6.0, 0.0];
        rig.look = [34.0, 4.0, 0.0];
        rig.arms[0] =
            Arm { swing: 52.0, lift: 30.0, twist: 14.0, elbow: 100.0, palm: 40.0, wrist: 10.0, shrug: 4.0, reach: 8.0 };
        rig.arms[1] =
            Arm { swing: 36.0, lift: 8.0, twist: 24.0, elbow: 124.0, palm: 40.0, wrist: 10.0, shrug: 4.0, reach: 4.0 };
        rig.feet[0].at = vec3(0.01, 0.0, 0.20);
        rig.feet[0].yaw = -12.0;
        rig.feet[1].at = vec3(-0.04, 0.0, -0.22);
        rig.feet[1].yaw = -52.0;
        rig.feet[1].pitch = -8.0;
        rig.feet[1].toes = 8.0;
    })
}

fn keys() -> Keys {
    let guard = guard();
    let bounce = with(guard, |rig| rig.hips.y -= 0.025);
    let jab = with(guard, |rig| {
        rig.hips.z += 0.07;
        rig.hips.y -= 0.015;
        rig.hips_turn[0] = -40.0;
        rig.spine[0] = -12.0;
        rig.chest[0] = -16.0;
        rig.look[0] = 58.0;
        rig.arms[0] = Arm { swing: 86.0, lift: 52.0, twist: 30.0, elbow: 8.0, palm: 85.0, wrist: 0.0, shrug: 8.0, reach: 22.0 };
    });
    let draw = with(guard, |rig| {
        rig.hips.z -= 0.02;
        rig.hips_turn[0] = -38.0;
        rig.chest[0] = -12.0;
        rig.look[0] = 46.0;
    });
    let cross = with(guard, |rig| {
        rig.hips.z += 0.12;
        rig.hips.y -= 0.03;
        rig.hips_turn = [14.0, 8.0, 0.0];
        rig.spine[0] = 12.0;
        rig.chest[0] = 18.0;
        rig.look[0] = -34.0;
        rig.arms[1] = Arm { swing: 88.0, lift: 40.0, twist: 30.0, elbow: 8.0, palm: 85.0, wrist: 0.0, shrug: 8.0, reach: 22.0 };
        rig.feet[1].pitch = -40.0;
        rig.feet[1].toes = 40.0;
        rig.feet[1] = rig.feet[1].pivoted(1, -26.0);
    });
    let chamber = with(guard, |rig| {
        rig.hips = vec3(0.085, -0.045, 0.06);
        rig.hips_turn = [6.0, -8.0, -6.0];
        rig.spine[1] = 8.0;
        rig.chest = [6.0, 4.0, 0.0];
        rig.look[0] = -10.0;
        rig.feet[1].at = vec3(0.03, 0.46, 0.20);
        rig.feet[1].yaw = 4.0;
        rig.feet[1].pitch = -30.0;
        rig.feet[1].toes = 0.0;
        rig.arms[0].lift = 24.0;
        rig.arms[1].swing = 10.0;
        rig.arms[1].lift = 30.0;
        rig.arms[1].elbow = 96.0;
    });
    let kick = with(chamber, |rig| {
        rig.hips = vec3(0.080, -0.040, 0.10);
        rig.hips_turn = [12.0, -22.0, -7.0];
        rig.spine[1] = 4.0;
        rig.chest = [12.0, 10.0, 0.0];
        rig.look[0] = -20.0;
        rig.feet[1].at = vec3(0.06, 0.86, 0.86);
        rig.feet[1].pitch = 40.0;
        rig.arms[1].swing = -20.0;
        rig.arms[1].lift = 48.0;
        rig.arms[1].elbow = 70.0;
        rig.arms[0].swing = 60.0;
    });
    let back = with(chamber, |rig| {
        rig.feet[1].at = vec3(0.0, 0.30, -0.02);
        rig.feet[1].yaw = -30.0;
    });
    Keys::new(vec![
        (0.0, guard),
        (0.30, bounce),
        (0.46, draw),
        (0.62, jab),
        (0.86, guard),
        (0.98, draw),
        (1.18, cross),
        (1.50, bounce),
        (1.78, guard),
        (2.16, chamber),
        (2.40, kick),
        (2.52, kick),
        (2.76, chamber),
        (3.00, back),
        (3.30, guard),
        (3.55, bounce),
        (LENGTH - 0.12, guard),
        (LENGTH, guard),
    ])
}
