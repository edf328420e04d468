//! `.cloth.ron` files: a material, and settings if the file has them, that cloths take over when the file is loaded and again
//! when it changes.
//!
//! ```ron
//! (
//!     material: (density: 0.15, stretch_stiffness: 12000.0),
//!     solver: (substep_rate: 600.0),
//!     wind: (velocity: (2.0, 0.0, 0.0)),
//! )
//! ```
//!
//! Fields that are not given have defaults. A file may also hold the fields of a material alone:
//! `(density: 0.15, stretch_stiffness: 12000.0)`. Errors in a file are named by file, line, column and field. A number that is
//! out of range is used clamped, as anywhere.

mod apply;
mod loader;
mod place;

pub use loader::{ClothPresetError, ClothPresetLoader};

#[cfg(feature = "gltf")]
pub(crate) use apply::PresetOverrides;
pub(crate) use apply::apply;

use bevy::ecs::template::FromTemplate;
use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::components::{
    ClothCollision, ClothDrive, ClothGlobalWind, ClothLimits, ClothMaterial, ClothSkipFrame, ClothSolver, ClothUntangling,
};

/// A fabric in a file: what a cloth with [`ClothPresetHandle`] takes over. See the [module](self) for how a file is written.
///
/// The built-in fabrics lie in `assets/fabrics` of the repository, one file for each of [`ClothMaterial::PRESETS`].
#[derive(Asset, Clone, Debug, Default, PartialEq, Reflect, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[reflect(Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothPreset {
    /// What the cloth is made of. Default [`ClothMaterial::default`].
    pub material: ClothMaterial,
    /// How exactly it is simulated. Default `None`: the cloth keeps its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub solver: Option<ClothSolver>,
    /// How it meets itself and others. Default `None`: the cloth keeps its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub collision: Option<ClothCollision>,
    /// How it is taken apart. Default `None`: the cloth keeps its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub untangle: Option<ClothUntangling>,
    /// What is shown while it is tangled. Default `None`: the cloth keeps its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub skip_frame: Option<ClothSkipFrame>,
    /// How far it may be from the animated skin. Default `None`: the cloth keeps its own, or has none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limits: Option<ClothLimits>,
    /// How firmly it is drawn to the animated skin. Default `None`: the cloth keeps its own, or has none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drive: Option<ClothDrive>,
    /// Wind at the cloth, as [`ClothWind`](crate::ClothWind). Default `None`: it keeps its own, or the [`ClothGlobalWind`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wind: Option<ClothGlobalWind>,
}

impl From<ClothMaterial> for ClothPreset {
    fn from(material: ClothMaterial) -> Self {
        Self { material, ..Self::default() }
    }
}

/// The file that a cloth takes its material and settings from: once it is loaded, again when it changes, and when the handle
/// changes.
///
/// Until then the cloth has its own. A file that fails to load changes nothing and is one warning.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::{prelude::*, ClothPresetHandle};
/// # fn setup(mut commands: Commands, assets: Res<AssetServer>, mesh: Handle<Mesh>) {
/// commands.spawn((Mesh3d(mesh), Cloth, ClothPresetHandle(assets.load("fabrics/silk.cloth.ron"))));
/// # }
/// ```
#[derive(Component, FromTemplate, Clone, Debug, Default, Deref, DerefMut, PartialEq, Eq, Reflect)]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
pub struct ClothPresetHandle(pub Handle<ClothPreset>);

impl From<Handle<ClothPreset>> for ClothPresetHandle {
    fn from(handle: Handle<ClothPreset>) -> Self {
        Self(handle)
    }
}

/// Brings the asset and its loader. Part of [`ClothPlugin`](crate::ClothPlugin), never added by users.
#[derive(Debug, Default)]
pub(crate) struct ClothPresetPlugin;

impl Plugin for ClothPresetPlugin {
    fn build(&self, _: &mut App) {}

    fn finish(&self, app: &mut App) {
        // Not in `build`, so that this plugin may come before the one that brings assets.
        if app.world().contains_resource::<AssetServer>() {
            app.init_asset::<ClothPreset>().register_asset_reflect::<ClothPreset>().register_asset_loader(ClothPresetLoader);
        }
    }
}
