//! The clips: controls of the rig over time, sampled thirty times a second.

mod dance;
mod fight;
mod gait;
mod idle;
mod jump;
mod keys;
mod lie;
mod sit;
mod through;
mod turn;

use crate::rig::{Arm, Rig};
use crate::skeleton::Pose;

/// Samples a second [Hz].
const RATE: f32 = 30.0;

/// A clip under its name.
pub struct Clip {
    pub name: &'static str,
    /// Length [s].
    seconds: f32,
    motion: Box<dyn Fn(f32) -> Rig>,
}

impl Clip {
    fn new(name: &'static str, seconds: f32, motion: impl Fn(f32) -> Rig + 'static) -> Self {
        Self { name, seconds, motion: Box::new(motion) }
    }

    fn frames(&self) -> usize {
        (self.seconds * RATE).round() as usize
    }

    /// Times of the samples [s]. The last one of a loop repeats the first.
    pub fn times(&self) -> Vec<f32> {
        let frames = self.frames();
        (0..=frames).map(|i| self.seconds * i as f32 / frames as f32).collect()
    }

    /// Poses at these times.
    pub fn poses(&self) -> Vec<Pose> {
        self.times().into_iter().map(|time| (self.motion)(time).pose()).collect()
    }
}

/// All clips.
pub fn all() -> Vec<Clip> {
    vec![
        idle::clip(),
        gait::walk(),
        gait::run(),
        turn::clip(),
        jump::clip(),
        fight::clip(),
        dance::clip(),
        sit::clip(),
        lie::clip(),
        through::clip(),
        through::t_pose(),
    ]
}

/// An arm at ease.
pub fn eased() -> Arm {
    Arm { swing: 2.0, lift: 15.0, twist: 16.0, elbow: 16.0, palm: 8.0, wrist: 6.0, ..Arm::default() }
}

/// Standing at ease: the start of all that is no loop.
pub fn standing() -> Rig {
    let mut rig = Rig { level: 0.9, arms: [eased(); 2], ..Rig::default() };
    rig.hips.y = -0.003;
    rig.spine = [0.0, 1.5, 0.0];
    rig.chest = [0.0, -2.0, 0.0];
    for (side, foot) in rig.feet.iter_mut().enumerate() {
        foot.yaw = if side == 0 { 6.0 } else { -6.0 };
        foot.at.x = if side == 0 { 0.015 } else { -0.015 };
    }
    rig
}

/// A rig, changed.
pub fn with(mut rig: Rig, change: impl Fn(&mut Rig)) -> Rig {
    change(&mut rig);
    rig
}
