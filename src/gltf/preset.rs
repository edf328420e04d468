//! `.cloth.ron`: a material in a file.

use bevy::asset::io::Reader;
use bevy::asset::{AssetLoader, LoadContext, LoadState};
use bevy::prelude::*;

use crate::components::ClothMaterial;
use crate::notices::{Notices, label};

/// A material from a `.cloth.ron` file, such as `(density: 0.3, bend_stiffness: 1e-4)`; fields that are not given have defaults.
#[derive(Asset, Clone, Debug, PartialEq, Reflect)]
pub struct ClothPreset(pub ClothMaterial);

/// Loads [`ClothPreset`].
#[derive(Debug, Default, TypePath)]
pub struct ClothPresetLoader;

/// Why a preset could not be loaded.
#[derive(Debug, thiserror::Error)]
pub enum ClothPresetError {
    /// The file could not be read.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// The file is not a material.
    #[error("{0}")]
    Ron(#[from] ron::error::SpannedError),
}

impl AssetLoader for ClothPresetLoader {
    type Asset = ClothPreset;
    type Settings = ();
    type Error = ClothPresetError;

    async fn load(&self, reader: &mut dyn Reader, (): &(), _: &mut LoadContext<'_>) -> Result<ClothPreset, ClothPresetError> {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await?;
        Ok(ClothPreset(ron::de::from_bytes(&bytes)?))
    }

    fn extensions(&self) -> &[&str] {
        &["cloth.ron"]
    }
}

/// The file that a cloth takes its material from, and what goes over it.
#[derive(Component, Clone, Debug)]
pub(crate) struct PresetOf {
    pub preset: Handle<ClothPreset>,
    /// Thickness over that of the file [m].
    pub thickness: Option<f32>,
}

/// Gives cloths the material of their file once it is loaded, and again when it is reloaded.
pub(crate) fn apply(
    presets: Res<Assets<ClothPreset>>,
    server: Option<Res<AssetServer>>,
    mut notices: ResMut<Notices>,
    mut events: MessageReader<AssetEvent<ClothPreset>>,
    mut cloths: Query<(Entity, Option<&Name>, Ref<PresetOf>, &mut ClothMaterial)>,
) {
    let arrived: Vec<AssetId<ClothPreset>> = events
        .read()
        .filter_map(|event| match event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => Some(*id),
            _ => None,
        })
        .collect();
    for (entity, name, of, mut material) in &mut cloths {
        if let Some(ClothPreset(loaded)) = presets.get(&of.preset) {
            if of.is_added() || arrived.contains(&of.preset.id()) {
                *material = loaded.clone();
                if let Some(thickness) = of.thickness {
                    material.thickness = thickness;
                }
            }
        } else if let Some(LoadState::Failed(error)) = server.as_ref().and_then(|s| s.get_load_state(of.preset.id()))
            && notices.first(entity, "preset")
        {
            let path = of.preset.path().map(ToString::to_string).unwrap_or_default();
            warn!("cloth {} keeps the default material, because `{path}` failed to load: {error}", label(entity, name));
        }
    }
}
