//! Cloth that is simulated before it is shown.

use bevy::prelude::*;

use super::checked::Checked;

/// Warm-up: how long a cloth is simulated before it is shown. A curtain hangs in its folds, and a skirt has fallen from its
/// skin, when it is first seen. The plugin removes it when that is done.
///
/// Until then the plugin sets the [`Visibility`] of the cloth, its [pieces](crate::ClothPiece) and its
/// [render mesh](crate::ClothRenderMesh) to [`Visibility::Hidden`], and then to what it was. Where the app sets another
/// meanwhile, the cloth is seen. A scene that is saved meanwhile says `Hidden`.
///
/// A frame of a warm-up is as long as [`ClothSolver::max_frame`](crate::ClothSolver::max_frame), or as takes 40,000 steps of a
/// particle, of all cloths that warm up: about 2 ms where nothing touches. In a pile it takes up to thirty times as long. It is
/// never shorter than a frame of the app, so a second of 1,000 particles takes ten frames or more at 60 Hz. Work is counted, not
/// timed.
///
/// A warm-up is no faster than the clock near a body that cloth moves
/// ([`ClothCoupling::TwoWay`](crate::ClothCoupling::TwoWay)), or beside cloth that is shown. Otherwise bodies and skins, which
/// move once in a frame, are slower than they will be. Bounds of [`ClothSkipFrame`](crate::ClothSkipFrame) go by the clock. A
/// cloth that comes to rest is done. Nothing warms up while no time passes. [`ClothLod`](crate::ClothLod) and
/// [`ClothBudget`](crate::ClothBudget) take substeps from a cloth that warms up, and never stop it.
/// [`ClothReset`](crate::ClothReset) begins the warm-up anew.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # fn curtain(mut commands: Commands, mesh: Handle<Mesh>) {
/// commands
///     .spawn((Mesh3d(mesh), Cloth, ClothPins::vertices([0, 10, 20]), ClothWarmUp { seconds: 2.0 }))
///     .observe(|_: On<Remove, ClothWarmUp>| info!("the curtain hangs"));
/// # }
/// ```
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothWarmUp {
    /// Time to simulate `[s]`. Default 1, range 0 to 60. Too short, cloth is seen to fall into place.
    pub seconds: f32,
}

impl Default for ClothWarmUp {
    fn default() -> Self {
        Self { seconds: 1.0 }
    }
}

impl ClothWarmUp {
    pub(crate) fn checked(self, checked: &mut Checked) -> f32 {
        checked.within("warm_up.seconds", self.seconds, 1.0, 0.0, 60.0)
    }
}
