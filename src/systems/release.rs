//! What is left behind when an entity stops being a cloth: the authored mesh, and nothing of ours.

use bevy::camera::primitives::Aabb;
use bevy::camera::visibility::{DynamicSkinnedMeshBounds, NoAutoAabb};
use bevy::ecs::entity_disabling::Disabled;
use bevy::ecs::query::Allow;
use bevy::ecs::relationship::RelationshipTarget;
use bevy::prelude::*;

use crate::components::fitted::{ColliderBody, FittedBody, FittedColliders, Stage};
use crate::components::{
    Cloth, ClothBody, ClothCollider, ClothCoupling, ClothError, ClothGrab, ClothPiece, ClothRenderMesh, ClothReport,
    ClothStatus, ClothWindZone,
};
use crate::notices::Notices;
use crate::simulation::{
    Binding, ClothInputs, ClothParticles, ClothRest, ClothShown, IslandPlace, Slumber, TakenSkin, WaitingSince,
};

/// A cloth that stops being one, disabled or not.
type Released = (
    Option<&'static mut Mesh3d>,
    Option<&'static Binding>,
    Option<&'static TakenSkin>,
    Option<&'static mut ClothStatus>,
    Option<&'static mut ClothReport>,
);

/// Gives the authored mesh back when `Cloth` is removed.
pub(crate) fn on_remove_cloth(
    removed: On<Remove, Cloth>,
    mut commands: Commands,
    mut cloths: Query<Released, Allow<Disabled>>,
) {
    forget(&mut commands, removed.entity);
    let Ok((mesh, binding, taken, status, report)) = cloths.get_mut(removed.entity) else { return };
    let Ok(mut entity) = commands.get_entity(removed.entity) else { return };
    if let Some(mut status) = status {
        *status = ClothStatus::New;
    }
    if let Some(mut report) = report {
        *report = ClothReport::default();
    }
    if let (Some(mut mesh), Some(binding)) = (mesh, binding)
        && binding.instance.as_ref().is_some_and(|i| i.id() == mesh.0.id())
    {
        mesh.0 = binding.source.clone();
    }
    if let Some(binding) = binding {
        take_apart(&mut entity, binding, taken);
    }
    entity.try_remove::<(Binding, ClothError, WaitingSince)>();
}

/// Removes what the simulation put on the entity and gives its skin and bounds back.
pub(crate) fn take_apart(entity: &mut EntityCommands, binding: &Binding, taken: Option<&TakenSkin>) {
    entity.try_remove::<(ClothRest, ClothParticles, ClothInputs, IslandPlace, ClothShown, Slumber)>();
    if binding.instance.is_none() {
        return;
    }
    give_back(entity, binding.own_bounds, taken);
}

/// Gives an entity that showed a mesh of ours its bounds and its skin back.
pub(crate) fn give_back(entity: &mut EntityCommands, own_bounds: bool, taken: Option<&TakenSkin>) {
    entity.try_remove::<Aabb>();
    if !own_bounds {
        entity.try_remove::<NoAutoAabb>();
    }
    if let Some(taken) = taken {
        entity.try_insert(taken.skin()).try_remove::<TakenSkin>();
        if taken.bounds {
            entity.try_insert(DynamicSkinnedMeshBounds);
        }
    }
}

/// Forgets the shape of a collider.
pub(crate) fn on_remove_collider(removed: On<Remove, ClothCollider>, mut commands: Commands) {
    forget(&mut commands, removed.entity);
    if let Ok(mut entity) = commands.get_entity(removed.entity) {
        entity.try_remove::<ColliderBody>();
    }
}

/// Forgets where a body was, and which cloths one met: neither is observed while its entity is disabled.
pub(crate) fn on_disable(
    disabled: On<Add, Disabled>,
    mut bodies: Query<&mut ColliderBody, Allow<Disabled>>,
    mut cloths: Query<&mut IslandPlace, Allow<Disabled>>,
) {
    if let Ok(mut body) = bodies.get_mut(disabled.entity) {
        body.pose = None;
    }
    if let Ok(mut place) = cloths.get_mut(disabled.entity) {
        (place.island, place.bounds) = (None, None);
    }
}

/// Despawns the colliders of a body's bones; bodies that were fitted together with it are fitted anew.
pub(crate) fn on_remove_body(
    removed: On<Remove, ClothBody>,
    mut commands: Commands,
    mut bodies: Query<(Entity, &mut FittedBody), Allow<Disabled>>,
    colliders: Query<&FittedColliders, Allow<Disabled>>,
) {
    let body = removed.entity;
    forget(&mut commands, body);
    // Now, since a body that is despawned has no list of them any more when commands run.
    for collider in colliders.get(body).into_iter().flat_map(RelationshipTarget::iter) {
        commands.entity(collider).try_despawn();
    }
    let members = bodies.get_mut(body).map(|(_, mut fitted)| std::mem::take(&mut fitted.members)).unwrap_or_default();
    for (other, mut fitted) in &mut bodies {
        if other != body && (members.contains(&other) || fitted.members.contains(&body)) {
            fitted.stage = Stage::New;
        }
    }
    if let Ok(mut body) = commands.get_entity(body) {
        body.try_remove::<FittedBody>();
    }
}

/// Forgets the warnings about a wind zone.
pub(crate) fn on_remove_zone(removed: On<Remove, ClothWindZone>, mut commands: Commands) {
    forget(&mut commands, removed.entity);
}

/// Forgets the warnings about a grip.
pub(crate) fn on_remove_grab(removed: On<Remove, ClothGrab>, mut commands: Commands) {
    forget(&mut commands, removed.entity);
}

/// Forgets the warnings about an entity, unless another component of it may have been meant.
pub(crate) fn forget(commands: &mut Commands, entity: Entity) {
    commands.queue(move |world: &mut World| {
        let is_meant = world.get_entity(entity).is_ok_and(|entity| {
            entity.contains::<Cloth>()
                || entity.contains::<ClothBody>()
                || entity.contains::<ClothCollider>()
                || entity.contains::<ClothCoupling>()
                || entity.contains::<ClothGrab>()
                || entity.contains::<ClothPiece>()
                || entity.contains::<ClothRenderMesh>()
                || entity.contains::<ClothWindZone>()
        });
        if let Some(mut notices) = world.get_resource_mut::<Notices>().filter(|_| !is_meant) {
            notices.forget(entity);
        }
    });
}
