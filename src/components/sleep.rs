//! Cloth that has come to rest costs nothing until something happens to it.

use bevy::prelude::*;

use super::checked::Checked;

/// When a cloth at rest falls asleep: it is then neither stepped nor looked at nor written, until something wakes it.
///
/// A cloth sleeps when no particle went farther than `threshold · delay` for as long as `delay`, and nothing around it changed
/// meanwhile. The same must be true of every cloth it can meet: those fall asleep and wake together. It wakes when the wind,
/// gravity, its settings, its pins or a body near it change or move. It also wakes when another cloth comes near, or when it is
/// pushed, grabbed, teleported or gets another mesh. Gusty wind keeps it awake. So does a body that takes what the cloth gives
/// it ([`ClothCoupling::TwoWay`](crate::ClothCoupling::TwoWay)): a net that slept would let go of what lies in it. All times
/// are those of the cloth: one that is paused (`ClothSolver::time_scale` of 0) does not fall asleep. Nor does one with
/// [`ClothSleepDisabled`].
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothSleep {
    /// Speed below which a particle is at rest `[m/s]`. Default 0.01, range 0 to 1. Too high: cloth stops in mid-swing; 0: it
    /// never sleeps.
    pub threshold: f32,
    /// Time for which all particles have to be at rest `[s]`. Default 0.5, range 0.05 to 60.
    pub delay: f32,
}

impl ClothSleep {
    pub(crate) fn checked(&self, checked: &mut Checked) -> Self {
        Self {
            threshold: checked.within("sleep.threshold", self.threshold, 0.01, 0.0, 1.0),
            delay: checked.within("sleep.delay", self.delay, 0.5, 0.05, 60.0),
        }
    }
}

impl Default for ClothSleep {
    fn default() -> Self {
        Self { threshold: 0.01, delay: 0.5 }
    }
}

/// Keeps a cloth awake: it does not fall asleep at rest, and wakes if it sleeps. Without it, [`ClothSleep`] says when it does.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothSleepDisabled;

/// A cloth came to rest and is not simulated until something wakes it.
#[derive(EntityEvent, Clone, Copy, Debug)]
pub struct ClothSlept {
    /// The cloth.
    pub entity: Entity,
}

/// A cloth that slept is simulated again.
#[derive(EntityEvent, Clone, Copy, Debug)]
pub struct ClothWoke {
    /// The cloth.
    pub entity: Entity,
}
