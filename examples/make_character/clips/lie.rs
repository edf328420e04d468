//! From standing to lying on the back: a squat, hands behind, the seat on the ground, the back down, the legs out.

use glam::vec3;

use super::keys::Keys;
use super::{Clip, standing, with};
use crate::rig::Arm;

/// Length [s].
const LENGTH: f32 = 5.0;
/// Height of the hips in the bind pose [m].
const STANDING: f32 = 0.95;

pub fn clip() -> Clip {
    let rest = standing();
    let squat = with(rest, |rig| {
        rig.hips = vec3(0.0, 0.36 - STANDING, -0.20);
        rig.hips_turn[1] = 30.0;
        rig.spine[1] = 16.0;
        rig.chest[1] = 8.0;
        rig.arms = [Arm { swing: 52.0, lift: 14.0, elbow: 20.0, ..Arm::default() }; 2];
        for foot in &mut rig.feet {
            foot.pitch = -20.0;
            foot.toes = 20.0;
            foot.knee = 8.0;
        }
    });
    let seat = with(squat, |rig| {
        rig.hips = vec3(0.0, 0.135 - STANDING, -0.42);
        rig.hips_turn[1] = -22.0;
        rig.spine[1] = 12.0;
        rig.chest[1] = 8.0;
        rig.level = 0.7;
        rig.arms = [Arm { swing: -34.0, lift: 26.0, twist: -12.0, elbow: 22.0, wrist: -20.0, ..Arm::default() }; 2];
        for foot in &mut rig.feet {
            foot.pitch = 0.0;
            foot.toes = 0.0;
        }
    });
    let leaning = with(seat, |rig| {
        rig.hips.y = 0.130 - STANDING;
        rig.hips_turn[1] = -56.0;
        rig.spine[1] = 14.0;
        rig.chest[1] = 10.0;
        rig.level = 0.45;
        rig.arms = [Arm { swing: -22.0, lift: 38.0, twist: -10.0, elbow: 34.0, wrist: -10.0, ..Arm::default() }; 2];
        for foot in &mut rig.feet {
            foot.at = vec3(foot.at.x, 0.004, 0.14);
            foot.pitch = 8.0;
        }
    });
    let down = with(leaning, |rig| {
        rig.hips.y = 0.126 - STANDING;
        rig.hips_turn[1] = -88.0;
        rig.spine[1] = 2.0;
        rig.chest[1] = -1.0;
        rig.level = 0.05;
        rig.look = [0.0, 13.0, 0.0];
        rig.arms = [Arm { swing: -4.0, lift: 34.0, twist: 0.0, elbow: 18.0, ..Arm::default() }; 2];
        for foot in &mut rig.feet {
            foot.at = vec3(foot.at.x, 0.008, 0.34);
            foot.pitch = 34.0;
        }
    });
    let flat = with(down, |rig| {
        rig.hips_turn[1] = -90.0;
        rig.arms = [Arm { swing: -7.0, lift: 30.0, twist: 0.0, elbow: 12.0, ..Arm::default() }; 2];
        for foot in &mut rig.feet {
            foot.at = vec3(foot.at.x, 0.024, 0.555);
            foot.pitch = 66.0;
        }
    });
    let keys = Keys::new(vec![
        (0.0, rest),
        (0.2, rest),
        (1.1, squat),
        (1.8, seat),
        (2.6, leaning),
        (3.4, down),
        (4.2, flat),
        (LENGTH, flat),
    ]);
    Clip::new("LieDown", LENGTH, move |time| keys.at(time))
}
