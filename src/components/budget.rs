//! How much time all cloths together may take.

use bevy::prelude::*;

use super::checked::Checked;

/// Budget: the time that all cloths together may take in a frame, as a resource. Without it there is no bound.
///
/// Where they take more, cloths lose [detail](crate::ClothDetail). The first are those that matter least for what that saves:
/// small on the screen, unseen, of low [`ClothPriority`]. Where they take clearly less, detail comes back. The cost of a cloth
/// is measured over a quarter of a second, so the result depends on the machine. A cloth changes at most once a second, unless
/// it falls again, and cloths that can touch change together. [`ClothLod`](crate::ClothLod) counts, too: the coarser of both is
/// taken. Cloth that a body hangs on or lies in is never lowered.
///
/// [`ClothReport::by_budget`](crate::ClothReport::by_budget) says what it left of each cloth.
///
/// A large cloth may not fit even by itself, with a quarter of its substeps. Then its frames run on Bevy's
/// `AsyncComputeTaskPool`, in full detail, and no frame of the app waits for them. The cloth is shown as it was until one is
/// done. The next one covers the time since then: such cloth moves in fewer, longer frames. It begins there, too, until its cost
/// is known, so that its first untangling holds no frame. Large is what [`ClothLoading`](crate::ClothLoading) prepares in the
/// background; cloths that can meet count together. [`ClothReport::in_background`](crate::ClothReport::in_background) says so.
///
/// What the app does to a cloth meanwhile is done. Where it teleports, what is under way is dropped. Cloth on a skin or with
/// [`ClothInertia`](crate::ClothInertia) is never stepped there, nor is one that a two-way body hangs on or lies in. Without
/// threads, as on the web, none is.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # fn add(app: &mut App) {
/// app.insert_resource(ClothBudget { ms: 2.0 });
/// # }
/// ```
#[derive(Resource, Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Resource, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothBudget {
    /// Time of a frame, summed over threads and stages `[ms]`. Default 4, range 0.01 to 1000. Too low: cloth that is looked at
    /// stands still; too high: frames are late.
    pub ms: f32,
}

impl ClothBudget {
    pub(crate) fn checked(&self, checked: &mut Checked) -> f32 {
        checked.within("budget.ms", self.ms, Self::default().ms, 0.01, 1000.0)
    }
}

impl Default for ClothBudget {
    fn default() -> Self {
        Self { ms: 4.0 }
    }
}

/// Priority: how much a cloth matters to [`ClothBudget`], beside its size on the screen (dimensionless). Default 1, range 0 to
/// 1e6. A hero of 100 keeps its detail until everything a hundredth of its size has lost it.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothPriority(pub f32);

impl Default for ClothPriority {
    fn default() -> Self {
        Self(1.0)
    }
}

impl ClothPriority {
    pub(crate) fn checked(self, checked: &mut Checked) -> f32 {
        checked.within("priority", self.0, 1.0, 0.0, 1.0e6)
    }
}
