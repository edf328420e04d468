//! Level of detail of cloth that is far away or unseen.

use bevy::prelude::*;

use super::checked::Checked;

/// Level of detail: what a cloth costs follows from how far it is from the cameras, and whether one of them sees it.
///
/// No cloth has it unless you put it on: without it nothing that happens depends on who looks. Near the nearest active camera a
/// cloth takes all its substeps, farther away half of them, and beyond that a quarter. Far away it stands still, and what it
/// hangs on carries it along rigidly. A skinned cloth fades into its animation there, and the GPU skins it: see
/// [`ClothBlend`](crate::ClothBlend). [`ClothReport::detail`](crate::ClothReport::detail) has its level.
///
/// ```text
/// distance    0 ──── full_within ──── 2 full_within ──── still_beyond ────►
/// detail         Full           Half            Quarter             Still
/// ```
///
/// Distances are from a camera, whatever it magnifies, to the box of the cloth; cameras for 2D do not count. A cloth returns to
/// the next finer level only a tenth nearer, so that nothing flickers at a border. Collisions are looked for in every frame at
/// every level except `Still`; fewer substeps stretch more and let fast bodies push deeper. Cloths that can touch take as many
/// substeps as the one that needs most. A cloth that stands still is an obstacle for the others. It goes along with its
/// carrier, jumps included and without an event; cloth that is pinned nowhere stays where it is. Impulses and grips do nothing
/// to it, and it goes on without the speed it had. Pins that went elsewhere than its carrier draw it there within a frame.
/// Cloth pinned to a body with [`ClothCoupling::TwoWay`](crate::ClothCoupling::TwoWay), or near one, is simulated in full: a
/// body in a net would fall.
///
/// Without an active camera every cloth is simulated in full.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothLod {
    /// Distance up to which the cloth is simulated in full `[m]`. Default 15, range 0.01 to 1e6. Too near: cloth stretches in
    /// plain view; too far: nothing is saved.
    pub full_within: f32,
    /// Distance from which on the cloth stands still `[m]`. Default 150, range 0.01 to 1e6. Too near: it is seen to stop; too
    /// far: cloth of a few pixels is simulated.
    pub still_beyond: f32,
    /// Finest level after half a second in which no camera saw the cloth, nor a light that casts its shadow. Default
    /// [`ClothDetail::Quarter`]; [`ClothDetail::Full`] leaves it to the distance.
    pub unseen: ClothDetail,
}

impl ClothLod {
    pub(crate) fn checked(&self, checked: &mut Checked) -> Self {
        Self {
            full_within: checked.within("lod.full_within", self.full_within, 15.0, 0.01, 1.0e6),
            still_beyond: checked.within("lod.still_beyond", self.still_beyond, 150.0, 0.01, 1.0e6),
            unseen: self.unseen,
        }
    }
}

impl Default for ClothLod {
    fn default() -> Self {
        Self { full_within: 15.0, still_beyond: 150.0, unseen: ClothDetail::Quarter }
    }
}

/// How much of its work is done for a cloth, finest first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub enum ClothDetail {
    /// All substeps of [`ClothSolver::substep_rate`](crate::ClothSolver::substep_rate).
    #[default]
    Full,
    /// Half of them, and no fewer than 30 per second.
    Half,
    /// A quarter of them, and no fewer than 30 per second.
    Quarter,
    /// No substeps: the cloth is carried along rigidly, or the GPU skins it.
    Still,
}

impl ClothDetail {
    /// From the finest to the coarsest.
    pub const ALL: [Self; 4] = [Self::Full, Self::Half, Self::Quarter, Self::Still];

    /// Share of the substeps (dimensionless).
    #[must_use]
    pub const fn share(self) -> f32 {
        match self {
            Self::Full => 1.0,
            Self::Half => 0.5,
            Self::Quarter => 0.25,
            Self::Still => 0.0,
        }
    }
}
