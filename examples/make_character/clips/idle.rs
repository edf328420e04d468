//! Standing, breathing, shifting weight.

use std::f32::consts::TAU;

use super::{Clip, standing, with};
use crate::rig::Rig;

/// Length of the loop, in which two breaths are taken [s].
const LENGTH: f32 = 4.0;

pub fn clip() -> Clip {
    Clip::new("Idle", LENGTH, idle)
}

fn idle(time: f32) -> Rig {
    let turn = TAU * time / LENGTH;
    let breath = (2.0 * turn - 0.5).sin();
    let sway = turn.sin();
    let late = (turn - 0.6).sin();
    with(standing(), |rig| {
        rig.hips.x += 0.012 * sway;
        rig.hips.y += -0.002 - 0.002 * (2.0 * turn).cos();
        rig.hips.z += 0.004 * (2.0 * turn).sin();
        rig.hips_turn = [1.5 * late, 0.0, -1.4 * sway];
        rig.spine[2] += 1.0 * sway;
        rig.spine[1] += 0.6 * breath;
        rig.chest[1] -= 1.6 * breath;
        rig.chest[2] += 0.6 * late;
        rig.look = [4.0 * (turn - 1.0).sin(), 1.0 * breath, 1.0 * late];
        for (side, arm) in rig.arms.iter_mut().enumerate() {
            let s = if side == 0 { 1.0 } else { -1.0 };
            arm.lift += 0.8 * breath + 1.0 * s * late;
            arm.shrug += 1.0 * breath;
            arm.swing += 1.4 * (turn - 0.9).sin();
            arm.elbow += 1.5 * (turn - 1.3).sin();
        }
    })
}
