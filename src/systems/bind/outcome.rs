//! How binding ends: the cloth is active, waits, or has failed.

use bevy::math::Mat3;
use bevy::prelude::*;

use super::BindableItem;
use crate::bind::{Placement, Sources};
use crate::components::{ClothDecimation, ClothError, ClothFailed, ClothStatus, ClothWaitingFor};
use crate::notices::{Notices, PATIENCE, label};
use crate::simulation::{Binding, Change, WaitingSince};
use crate::systems::release::take_apart;

pub(super) fn activate(commands: &mut Commands, cloth: &mut BindableItem) {
    if *cloth.status != ClothStatus::Active {
        *cloth.status = ClothStatus::Active;
        commands.entity(cloth.entity).try_remove::<(ClothError, WaitingSince)>();
    }
}

/// Class C: silent at first, then one warning.
pub(super) fn wait(
    commands: &mut Commands,
    notices: &mut Notices,
    cloth: &mut BindableItem,
    reason: ClothWaitingFor,
    now: f64,
) {
    if let Some(inputs) = &mut cloth.inputs {
        inputs.active = false;
    }
    cloth.status.set_if_neq(ClothStatus::Waiting(reason));
    if cloth.error.is_some() {
        // It no longer fails but waits; when that is over it is tried from the start.
        if let Some(binding) = &mut cloth.binding {
            binding.pending = Change::Mesh;
        }
        commands.entity(cloth.entity).try_remove::<ClothError>();
    }
    let since = WaitingSince { reason, at: now, told: false };
    match &mut cloth.waiting {
        None => {
            commands.entity(cloth.entity).try_insert(since);
        }
        Some(old) if old.reason != reason => **old = since,
        Some(since) if !since.told && now - since.at > PATIENCE => {
            since.told = true;
            if notices.first(cloth.entity, reason.cure()) {
                warn!("cloth {} still waits: {}", label(cloth.entity, cloth.name), reason.cure());
            }
        }
        Some(_) => {}
    }
}

/// Class A: the authored mesh is drawn, and the reason is on the entity.
pub(super) fn fail(
    commands: &mut Commands,
    notices: &mut Notices,
    cloth: &mut BindableItem,
    sources: &Sources,
    error: ClothError,
) {
    let source = cloth.mesh.as_ref().map(|shown| match &cloth.binding {
        Some(b) if b.instance.as_ref().is_some_and(|i| i.id() == shown.0.id()) => b.source.clone(),
        _ => sources.authored(&shown.0),
    });
    let (Some(source), Some(mesh)) = (source, &mut cloth.mesh) else { return };
    if mesh.0.id() != source.id() {
        mesh.0 = source.clone();
    }
    let mut entity = commands.entity(cloth.entity);
    let bake = match &cloth.binding {
        Some(b) => {
            take_apart(&mut entity, b, cloth.taken);
            cloth.global.and_then(|g| Placement::of(&g.affine())).map_or(b.bake, |p| p.bake)
        }
        None => cloth.global.and_then(|g| Placement::of(&g.affine())).map_or(Mat3::IDENTITY, |p| p.bake),
    };
    let own_bounds = cloth.own_bounds && cloth.binding.is_none();
    let shortest_edge = ClothDecimation::usable(cloth.decimation);
    entity.try_insert(Binding {
        source,
        instance: None,
        bake,
        shortest_edge,
        own_bounds,
        pending: Change::None,
        on_skin: false,
    });
    entity.try_remove::<WaitingSince>();
    *cloth.status = ClothStatus::Failed;
    if notices.first(cloth.entity, error.kind.name()) {
        warn!("cloth {} cannot be simulated: {error}", label(cloth.entity, cloth.name));
    }
    if cloth.error != Some(&error) {
        entity.try_insert(error.clone());
        commands.trigger(ClothFailed { entity: cloth.entity, error });
    }
}
