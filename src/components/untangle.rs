//! How cloth that crosses itself or another cloth is untangled.

use bevy::prelude::*;

use super::checked::Checked;
use crate::solver::island::UntangleSettings;
use crate::solver::resolve::{Method, ResolveSettings};

/// How cloth that crosses itself or another cloth is untangled.
///
/// Cloths that can meet form an island and are untangled together, by the settings with the most iterations. Ties go to the
/// lowest entity index, as a rule the cloth that was spawned first. A cloth with [`ClothUntanglingDisabled`] is not moved.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "presets", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothUntangling {
    /// The method. Default [`ClothUntanglingMethod::ByEndType`].
    pub method: ClothUntanglingMethod,
    /// Most iterations per frame, taken only while something crosses. Default 4, range 0 to 64; 0 only measures. More gets done
    /// sooner and costs in proportion.
    pub iterations: u32,
    /// Largest displacement of a particle per iteration, as a fraction of the mean edge (dimensionless). Default 0.1, range
    /// 0.001 to 1. Smaller is slower; much larger overshoots and folds triangles over.
    pub step: f32,
    /// Largest growth of the step of a contour that keeps moving in one direction (dimensionless). Default 5, range 1 to 50.
    /// More is faster on deep tangles and tears at the edges around them.
    pub pace: f32,
    /// How far the motion spreads into the cloth around a contour, as a fraction of the contour's length (dimensionless).
    /// Default 0.5, range 0 to 10. 0 moves only the particles at the contour, which the rest of a fine cloth holds back.
    pub spread: f32,
    /// Iterations without progress after which another strategy is tried. Default 10, range 1 to 1000.
    pub stall_iterations: u32,
    /// Sweeps of the springs after each iteration. Default 2, range 0 to 16.
    pub relaxations: u32,
    /// Work budget of looks and of untangling in a frame: visits of particles, crossings and pairs of faces for each face.
    /// Default 512, range 16 to 1,000,000. The rest goes on in the next frame, and
    /// [`ClothReport::deferred`](crate::ClothReport::deferred) reports it. Too low: heaps stay tangled for longer, and piles
    /// that land hard cross; too high: a frame in which cloth crosses all over takes long. It is counted and not timed, so that
    /// every machine stops at the same place.
    pub effort: u32,
    /// Whether a cloth that is tangled in its first frame is taken apart at once, in 300 iterations at most. Much work spreads
    /// over several frames. Default false: it comes apart before the eyes of the player. While no time passes, nothing is taken
    /// apart and the mesh is shown as it is. That is so in the very first frame of an app, and while virtual time is paused.
    pub at_load: bool,
}

/// Untangling leaves a cloth with this marker as it is, and moves others off it. Contacts stay on, except where the cloth
/// crosses. Crossings are still counted. Without it, [`ClothUntangling`] says how it comes apart.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothUntanglingDisabled;

/// Untangling methods. Methods of other papers need the feature `research`; they are for comparison.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[cfg_attr(feature = "presets", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Default, Clone, Debug, PartialEq, Hash)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub enum ClothUntanglingMethod {
    /// The traditional method (1995): remember on which side of each other particles and faces were, and push them back there.
    #[cfg(feature = "research")]
    History,
    /// Each crossing on its own follows the gradient of the contour's length (Volino and Magnenat-Thalmann 2006).
    #[cfg(feature = "research")]
    LocalGradient,
    /// One summed gradient per contour (Wen et al. 2009).
    #[cfg(feature = "research")]
    GlobalGradient,
    /// By the end type of each contour; another strategy when one makes no progress.
    #[default]
    ByEndType,
}

impl ClothUntanglingMethod {
    /// All methods, oldest first.
    pub const ALL: &[Self] = &[
        #[cfg(feature = "research")]
        Self::History,
        #[cfg(feature = "research")]
        Self::LocalGradient,
        #[cfg(feature = "research")]
        Self::GlobalGradient,
        Self::ByEndType,
    ];
}

impl From<ClothUntanglingMethod> for Method {
    fn from(method: ClothUntanglingMethod) -> Self {
        match method {
            #[cfg(feature = "research")]
            ClothUntanglingMethod::History => Self::History,
            #[cfg(feature = "research")]
            ClothUntanglingMethod::LocalGradient => Self::LocalGradient,
            #[cfg(feature = "research")]
            ClothUntanglingMethod::GlobalGradient => Self::GlobalGradient,
            ClothUntanglingMethod::ByEndType => Self::ByEndType,
        }
    }
}

impl Default for ClothUntangling {
    fn default() -> Self {
        Self {
            method: ClothUntanglingMethod::ByEndType,
            iterations: 4,
            step: 0.1,
            pace: 5.0,
            spread: 0.5,
            stall_iterations: 10,
            relaxations: 2,
            effort: 512,
            at_load: false,
        }
    }
}

impl ClothUntangling {
    /// With another method.
    #[must_use]
    pub fn with_method(mut self, method: ClothUntanglingMethod) -> Self {
        self.method = method;
        self
    }

    pub(crate) fn settings(&self, checked: &mut Checked) -> UntangleSettings {
        UntangleSettings {
            resolve: ResolveSettings {
                method: self.method.into(),
                step: checked.within("untangle.step", self.step, 0.1, 0.001, 1.0),
                pace: checked.within("untangle.pace", self.pace, 5.0, 1.0, 50.0),
                spread: checked.within("untangle.spread", self.spread, 0.5, 0.0, 10.0),
                stall_iterations: checked.count("untangle.stall_iterations", self.stall_iterations, 1, 1000),
            },
            iterations: checked.count("untangle.iterations", self.iterations, 0, 64),
            relaxations: checked.count("untangle.relaxations", self.relaxations, 0, 16),
            effort: checked.count("untangle.effort", self.effort, 16, 1_000_000),
        }
    }
}
