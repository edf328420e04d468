//! Walking and running in place, over a ground that moves backward at the speed of the gait.

use std::f32::consts::{PI, TAU};

use glam::vec3;

use super::Clip;
use crate::field::{hermite, step};
use crate::rig::{Arm, Foot, Rig};

/// Measures of a gait. Phases are shares of the cycle, from the strike of the heel on.
#[derive(Clone, Copy)]
struct Gait {
    /// Speed of the ground [m/s].
    speed: f32,
    /// Length of the cycle [s].
    cycle: f32,
    /// Share of the cycle in which a foot stands.
    stance: f32,
    /// Where the foot strikes, before its place in the bind pose [m].
    strike: f32,
    /// Pitch of the foot at the strike [degrees].
    strike_pitch: f32,
    /// Phase at which the sole is flat.
    flat: f32,
    /// Phase at which the heel rises.
    rise: f32,
    /// Pitch of the foot when the toes leave the ground [degrees].
    off_pitch: f32,
    /// How high the ankle is carried: early and late in the swing [m].
    carried: [f32; 2],
    /// Distance of the feet from the middle, less than in the bind pose [m].
    narrow: f32,
}

/// How fast the toes come off: a first lift [m].
const OFF: f32 = 0.018;

const WALK: Gait = Gait {
    speed: 1.4,
    cycle: 1.0,
    stance: 0.59,
    strike: 0.365,
    strike_pitch: 20.0,
    flat: 0.11,
    rise: 0.33,
    off_pitch: -62.0,
    carried: [0.070, 0.040],
    narrow: 0.050,
};

const RUN: Gait = Gait {
    speed: 3.5,
    cycle: 0.7,
    stance: 0.34,
    strike: 0.285,
    strike_pitch: 8.0,
    flat: 0.07,
    rise: 0.16,
    off_pitch: -58.0,
    carried: [0.30, 0.13],
    narrow: 0.065,
};

/// The `Walk` clip.
pub fn walk() -> Clip {
    Clip::new("Walk", WALK.cycle, walking)
}

/// The `Run` clip.
pub fn run() -> Clip {
    Clip::new("Run", RUN.cycle, running)
}

impl Gait {
    /// A foot at a phase of its own cycle, 0 to 1.
    fn foot(&self, phase: f32) -> Foot {
        let end = self.strike - self.speed * self.stance * self.cycle;
        let mut foot = Foot::default();
        if phase < self.stance {
            foot.at.z = self.strike - self.speed * phase * self.cycle;
            if phase < self.flat {
                let s = 1.0 - phase / self.flat;
                foot.pitch = self.strike_pitch * s * s;
            } else if phase > self.rise {
                let s = (phase - self.rise) / (self.stance - self.rise);
                foot.pitch = self.off_pitch * s * s * (0.6 + 0.4 * s);
                foot.toes = -foot.pitch;
            }
            return foot;
        }
        let span = 1.0 - self.stance;
        let s = (phase - self.stance) / span;
        // Position and pitch go on with the speed they had, and arrive with the speed they will have.
        let drift = -self.speed * span * self.cycle;
        foot.at.z = hermite(end, self.strike, drift, drift, s);
        let off_rate = self.off_pitch * 2.4 / (self.stance - self.rise) * span;
        let strike_rate = -2.0 * self.strike_pitch / self.flat * span;
        foot.pitch = swing_pitch(s, [self.off_pitch, self.strike_pitch], [off_rate, strike_rate]);
        // The toes lie flat until they have left the ground, and then stretch.
        foot.toes = -foot.pitch.min(0.0) * (1.0 - step(0.05, 0.60, s));
        let bump = |centre: f32, width: f32| {
            let x = ((s - centre) / width).clamp(-1.0, 1.0);
            0.5 + 0.5 * (PI * x).cos()
        };
        let [early, late] = self.carried;
        foot.at.y = OFF * bump(0.13, 0.13) + early * bump(0.32, 0.32) + late * bump(0.66, 0.34);
        foot
    }

    /// Phases of both feet at a time.
    fn phases(&self, time: f32) -> [f32; 2] {
        let phase = time / self.cycle;
        [phase.rem_euclid(1.0), (phase + 0.5).rem_euclid(1.0)]
    }

    /// Both feet at a time.
    fn feet(&self, time: f32) -> [Foot; 2] {
        let mut feet = self.phases(time).map(|phase| self.foot(phase));
        for (side, foot) in feet.iter_mut().enumerate() {
            let s = if side == 0 { 1.0 } else { -1.0 };
            foot.at.x = -s * self.narrow;
            foot.yaw = s * 4.0;
        }
        feet
    }
}

/// Pitch in the swing: on from the push-off, past a level foot, to toes up.
fn swing_pitch(s: f32, [from, to]: [f32; 2], [leave, arrive]: [f32; 2]) -> f32 {
    const MIDDLE: f32 = 0.55;
    let middle = -4.0;
    let slope = (to - from) * 0.9;
    if s < MIDDLE {
        hermite(from, middle, leave * MIDDLE, slope * MIDDLE, s / MIDDLE)
    } else {
        let rest = 1.0 - MIDDLE;
        hermite(middle, to, slope * rest, arrive * rest, (s - MIDDLE) / rest)
    }
}

fn walking(time: f32) -> Rig {
    let turn = TAU * time / WALK.cycle; // the left heel strikes at 0
    let forth = turn.cos(); // left leg in front
    let late = (turn - 0.45).cos();
    let later = (turn - 0.8).cos();
    let bob = (2.0 * turn - 0.35).cos();
    let over_left = (turn - 0.95).sin();
    let mut rig = Rig { level: 0.85, ..Rig::default() };
    rig.feet = WALK.feet(time);
    rig.hips = vec3(0.020 * over_left, -0.042 - 0.018 * bob, 0.008 * (2.0 * turn + 0.6).sin());
    rig.hips_turn = [-7.0 * forth, 4.0 + 1.0 * (2.0 * turn).cos(), -3.4 * (turn - 0.5).sin()];
    rig.spine = [5.0 * late, 1.0, 2.6 * (turn - 0.7).sin()];
    rig.chest = [8.0 * late, -2.0 + 1.2 * (2.0 * turn - 0.8).cos(), 1.8 * (turn - 0.9).sin()];
    rig.look = [-5.0 * late, 0.8 * (2.0 * turn - 1.2).cos(), 0.0];
    rig.arms = [-1.0, 1.0].map(|s| Arm {
        swing: 3.0 + 22.0 * s * late,
        lift: 13.0 + 1.5 * s * late,
        twist: 18.0 + 6.0 * s * later,
        elbow: 20.0 + 11.0 * s * later,
        palm: 10.0,
        wrist: 5.0 - 4.0 * s * (turn - 1.3).cos(),
        shrug: 0.6 * bob,
        reach: 3.0 * s * late,
    });
    rig
}

fn running(time: f32) -> Rig {
    let turn = TAU * time / RUN.cycle;
    let middle = turn - TAU * RUN.stance * 0.5; // 0 in the middle of the left stance
    let forth = (turn + 0.1).cos();
    let late = (turn - 0.3).cos();
    let bob = (2.0 * middle).cos();
    let mut rig = Rig { level: 0.92, ..Rig::default() };
    rig.feet = RUN.feet(time);
    rig.hips = vec3(0.010 * middle.cos(), -0.078 - 0.038 * bob, -0.02 + 0.012 * (2.0 * middle).sin());
    rig.hips_turn = [-9.0 * forth, 12.0 + 2.0 * (2.0 * middle + 0.8).cos(), 3.2 * (middle - 0.2).cos()];
    rig.spine = [7.0 * late, 2.0, -2.4 * (middle - 0.4).cos()];
    rig.chest = [13.0 * late, 1.0 + 2.0 * (2.0 * middle - 0.6).cos(), -1.6 * (middle - 0.5).cos()];
    rig.look = [-9.0 * late, -2.0 + 1.2 * (2.0 * middle - 1.0).cos(), 0.0];
    rig.arms = [-1.0, 1.0].map(|s| Arm {
        swing: -4.0 + 40.0 * s * late,
        lift: 21.0 - 5.0 * s * late,
        twist: 26.0 + 14.0 * s * late,
        elbow: 88.0 + 14.0 * s * (turn - 0.6).cos(),
        palm: 20.0,
        wrist: 4.0,
        shrug: 1.0 - 2.0 * bob,
        reach: 8.0 * s * late,
    });
    rig
}
