//! Sits down on a chair that is not there, its seat 0.45 m high and behind the figure, and stays.

use glam::vec3;

use super::keys::Keys;
use super::{Clip, standing, with};
use crate::rig::Arm;

/// Length [s].
const LENGTH: f32 = 3.0;
/// Height of the seat [m], and of the hips over it.
const SEAT: f32 = 0.45;
const OVER_SEAT: f32 = 0.105;
/// Height of the hips in the bind pose [m].
const STANDING: f32 = 0.95;

pub fn clip() -> Clip {
    let rest = standing();
    let sink = with(rest, |rig| {
        rig.hips = vec3(0.0, -0.19, -0.22);
        rig.hips_turn[1] = 36.0;
        rig.spine[1] = 14.0;
        rig.chest[1] = 6.0;
        rig.arms = [Arm { swing: 34.0, lift: 21.0, twist: 14.0, elbow: 26.0, ..Arm::default() }; 2];
    });
    let touch = with(sink, |rig| {
        rig.hips = vec3(0.0, SEAT + OVER_SEAT - STANDING, -0.40);
        rig.hips_turn[1] = 20.0;
        rig.spine[1] = 10.0;
        rig.arms = [Arm { swing: 34.0, lift: 21.0, twist: 18.0, elbow: 40.0, palm: 40.0, ..Arm::default() }; 2];
    });
    let seated = with(touch, |rig| {
        rig.hips_turn[1] = -6.0;
        rig.spine[1] = 6.0;
        rig.chest[1] = 0.0;
        rig.arms = [Arm { swing: 22.0, lift: 9.0, twist: 14.0, elbow: 47.0, palm: 66.0, wrist: 4.0, ..Arm::default() }; 2];
    });
    let keys = Keys::new(vec![(0.0, rest), (0.25, rest), (0.95, sink), (1.45, touch), (2.1, seated), (LENGTH, seated)]);
    Clip::new("Sit", LENGTH, move |time| keys.at(time))
}
