//! What is shown while a cloth is tangled.

use bevy::prelude::*;

use super::checked::Checked;
use crate::solver::evaluate::{self, EvaluateSettings};

/// What is shown while a cloth is tangled. The simulation goes on: the drawn shape is held, and only for so long.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "presets", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothSkipFrame {
    /// What to do about tangled frames. Default [`ClothSkipPolicy::Bounded`].
    pub policy: ClothSkipPolicy,
    /// Most frames held in a row under [`ClothSkipPolicy::Bounded`]. Default 2, range 0 to 30. More hides longer tangles, and
    /// the cloth visibly sticks.
    pub max_held_frames: u32,
    /// Most time held in any second under [`ClothSkipPolicy::Bounded`] `[s]`. Default 0.1, range 0 to 1.
    pub max_held_time: f32,
    /// Time over which what was held fades into the live shape when the bound is reached `[s]`. Default 0.1, range 0 to 10.
    pub fade: f32,
}

/// What to do about frames in which a cloth is still tangled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "presets", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub enum ClothSkipPolicy {
    /// Hold the tangled part in its last clean shape for a few frames at most, then show the best there is.
    #[default]
    Bounded,
    /// As Wen et al. 2009: keep the whole last clean shape until the cloth is clean again, for `max` frames at most.
    UntilClean {
        /// Most frames held in a row (number); any number goes.
        max: u32,
    },
    /// Always show the live shape.
    Off,
}

impl Default for ClothSkipFrame {
    fn default() -> Self {
        Self { policy: ClothSkipPolicy::Bounded, max_held_frames: 2, max_held_time: 0.1, fade: 0.1 }
    }
}

impl ClothSkipFrame {
    /// Never holds anything.
    pub const OFF: Self = Self { policy: ClothSkipPolicy::Off, max_held_frames: 0, max_held_time: 0.0, fade: 0.0 };

    pub(crate) fn settings(&self, checked: &mut Checked) -> EvaluateSettings {
        EvaluateSettings {
            policy: match self.policy {
                ClothSkipPolicy::Bounded => evaluate::SkipPolicy::Bounded,
                ClothSkipPolicy::UntilClean { max } => evaluate::SkipPolicy::UntilClean { max },
                ClothSkipPolicy::Off => evaluate::SkipPolicy::Off,
            },
            max_held_frames: checked.count("max_held_frames", self.max_held_frames, 0, 30),
            max_held_time: checked.within("max_held_time", self.max_held_time, 0.1, 0.0, 1.0),
            fade: checked.within("fade", self.fade, 0.1, 0.0, 10.0),
            ..EvaluateSettings::default()
        }
    }
}
