//! Poses for tests: an arm that passes through the torso on purpose, and arms held out.

use super::keys::Keys;
use super::{Clip, standing, with};
use crate::rig::{Arm, Rig};

/// Length of `ArmsThrough` [s].
const LENGTH: f32 = 4.0;

/// The `ArmsThrough` clip: the right forearm sweeps through the belly and back, a loop.
pub fn clip() -> Clip {
    let start = standing();
    let before = with(start, |rig| {
        rig.arms[1] = Arm { swing: 35.0, lift: 10.0, twist: 0.0, elbow: 70.0, palm: 10.0, ..Arm::default() };
    });
    let inside = with(start, |rig| {
        rig.arms[1] = Arm { swing: -4.0, lift: -4.0, twist: 72.0, elbow: 88.0, palm: 10.0, ..Arm::default() };
    });
    let keys = Keys::new(vec![
        (0.0, start),
        (0.9, before),
        (1.8, inside),
        (2.3, inside),
        (3.1, before),
        (LENGTH - 0.12, start),
        (LENGTH, start),
    ]);
    Clip::new("ArmsThrough", LENGTH, move |time| keys.at(time))
}

/// The `TPose` clip: arms held out to the sides.
pub fn t_pose() -> Clip {
    const LENGTH: f32 = 1.0;
    Clip::new("TPose", LENGTH, |_| Rig { arms: [Arm { lift: 90.0, ..Arm::default() }; 2], ..Rig::default() })
}
