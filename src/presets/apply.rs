//! Prepare: cloths take over what their files hold.

use bevy::asset::LoadState;
use bevy::prelude::*;

use super::{ClothPreset, ClothPresetHandle};
use crate::components::{Cloth, ClothCollision, ClothDrive, ClothLimits, ClothMap, ClothMaterial, ClothSolver, ClothWind};
use crate::notices::{Notices, label};

/// What goes over a file: what else the glTF says about the cloth.
#[derive(Component, Clone, Debug, Default, PartialEq)]
pub(crate) struct PresetOverrides {
    /// `[m]`
    pub thickness: Option<f32>,
    /// `[Hz]`
    pub substep_rate: Option<f32>,
    pub self_collision: Option<bool>,
    pub garment_layer: Option<i32>,
    /// `[m]`
    pub max_distance: Option<ClothMap>,
    /// Distance and radius of the backstop `[m]`.
    pub backstop: Option<(ClothMap, Option<f32>)>,
    pub drive: Option<ClothDrive>,
}

impl PresetOverrides {
    /// The limits of a file, except what the glTF says of them.
    fn limits(&self, mut limits: ClothLimits) -> ClothLimits {
        if let Some(max_distance) = &self.max_distance {
            limits.max_distance = max_distance.clone();
        }
        if let Some((distance, radius)) = &self.backstop {
            limits.backstop_distance = distance.clone();
            limits.backstop_radius = radius.unwrap_or(limits.backstop_radius);
        }
        limits
    }
}

/// Gives cloths what their files hold: once loaded, when they change, and when a cloth or its handle is new.
pub(crate) fn apply(
    mut commands: Commands,
    presets: Res<Assets<ClothPreset>>,
    server: Option<Res<AssetServer>>,
    mut notices: ResMut<Notices>,
    mut events: MessageReader<AssetEvent<ClothPreset>>,
    mut arrived: Local<Vec<AssetId<ClothPreset>>>,
    cloths: Query<(Entity, Option<&Name>, Ref<Cloth>, Ref<ClothPresetHandle>, Option<&PresetOverrides>)>,
) {
    arrived.clear();
    arrived.extend(events.read().filter_map(|event| match event {
        AssetEvent::Added { id } | AssetEvent::Modified { id } => Some(*id),
        _ => None,
    }));
    for (entity, name, cloth, handle, overrides) in &cloths {
        if let Some(preset) = presets.get(&handle.0) {
            if cloth.is_added() || handle.is_changed() || arrived.contains(&handle.id()) {
                give(&mut commands, entity, preset, overrides.cloned().unwrap_or_default());
                notices.settle(entity, "preset");
            }
        } else if let Some(LoadState::Failed(error)) = server.as_ref().and_then(|s| s.get_load_state(handle.id()))
            && notices.first(entity, "preset")
        {
            warn!("cloth {} keeps its settings, because its preset failed to load: {error}", label(entity, name));
        }
    }
}

fn give(commands: &mut Commands, entity: Entity, preset: &ClothPreset, overrides: PresetOverrides) {
    let ClothPreset { material, solver, collision, untangle, skip_frame, limits, drive, wind } = preset.clone();
    let mut entity = commands.entity(entity);
    let thickness = overrides.thickness.unwrap_or(material.thickness);
    entity.try_insert(ClothMaterial { thickness, ..material });
    if let Some(solver) = solver {
        let substep_rate = overrides.substep_rate.unwrap_or(solver.substep_rate);
        entity.try_insert(ClothSolver { substep_rate, ..solver });
    }
    if let Some(collision) = collision {
        let self_collision = overrides.self_collision.unwrap_or(collision.self_collision);
        let garment_layer = overrides.garment_layer.unwrap_or(collision.garment_layer);
        entity.try_insert(ClothCollision { self_collision, garment_layer, ..collision });
    }
    if let Some(untangle) = untangle {
        entity.try_insert(untangle);
    }
    if let Some(skip_frame) = skip_frame {
        entity.try_insert(skip_frame);
    }
    if let Some(limits) = limits {
        entity.try_insert(overrides.limits(limits));
    }
    if let Some(drive) = drive.filter(|_| overrides.drive.is_none()) {
        entity.try_insert(drive);
    }
    if let Some(wind) = wind {
        entity.try_insert(ClothWind(wind));
    }
}
