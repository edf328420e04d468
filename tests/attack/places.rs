//! Where entities are, and whether they are there at all.

use bevy::ecs::entity_disabling::Disabled;
use bevy::prelude::*;
use bevy_drape::prelude::*;
use fastrand::Rng;

use super::stage::Stage;
use super::wild::{number, once_in, one_of, size, turn, vector, wild_vector};

/// Despawns it, with its children or without.
pub fn despawn(stage: &mut Stage, slot: usize, rng: &mut Rng) -> String {
    let Some(entity) = stage.live(slot) else { return format!("{slot}: nothing to despawn") };
    if once_in(rng, 3) {
        stage.world().entity_mut(entity).detach_all_children();
    }
    stage.world().try_despawn(entity).ok();
    format!("{slot}: despawned")
}

/// Switches it off or on, one way or another.
pub fn disable(stage: &mut Stage, slot: usize, rng: &mut Rng) -> String {
    let Some(entity) = stage.live(slot) else { return format!("{slot}: nothing to disable") };
    let mut entity = stage.app.world_mut().entity_mut(entity);
    match rng.u32(0..4) {
        0 if entity.contains::<Disabled>() => entity.remove::<Disabled>(),
        0 => entity.insert(Disabled),
        1 if entity.contains::<ClothDisabled>() => entity.remove::<ClothDisabled>(),
        1 => entity.insert(ClothDisabled),
        2 if entity.contains::<Cloth>() => entity.remove::<Cloth>(),
        2 => entity.insert(Cloth),
        _ => entity.remove::<Disabled>(),
    };
    let off = [entity.contains::<Disabled>(), entity.contains::<ClothDisabled>(), !entity.contains::<Cloth>()];
    format!("{slot}: disabled, cloth disabled, no cloth: {off:?}")
}

/// A clone under another number.
pub fn clone(stage: &mut Stage, slot: usize, other: usize, rng: &mut Rng) -> String {
    let Some(entity) = stage.live(slot).filter(|_| slot != other) else { return format!("{slot}: nothing to clone") };
    let linked = rng.bool();
    let mut entity = stage.app.world_mut().entity_mut(entity);
    let twin = entity.clone_and_spawn_with_opt_out(move |cloner| {
        cloner.linked_cloning(linked);
    });
    // A clone of everything below has no number, and may lose its parent.
    let below: Vec<Entity> = stage.world().query::<&Children>().query(stage.app.world()).iter_descendants(twin).collect();
    stage.belongings.extend(below);
    stage.enter(other, twin);
    format!("{slot}: cloned as {other}, linked {linked}")
}

/// Whether `entity` is `ancestor` or below it.
fn is_below(world: &World, mut entity: Entity, ancestor: Entity) -> bool {
    loop {
        if entity == ancestor {
            return true;
        }
        let Some(parent) = world.get::<ChildOf>(entity) else { return false };
        entity = parent.parent();
    }
}

/// A joint, or the entity of a number.
fn joint(stage: &Stage, slot: usize, rng: &mut Rng) -> Option<Entity> {
    let joints = stage.belongings.iter().copied().filter(|e| stage.app.world().get_entity(*e).is_ok());
    let joints: Vec<Entity> = joints.collect();
    if joints.is_empty() || rng.bool() { stage.live(slot) } else { Some(one_of(rng, &joints)) }
}

/// Another parent, which may be a joint, or none.
pub fn reparent(stage: &mut Stage, slot: usize, other: usize, rng: &mut Rng) -> String {
    let Some(child) = stage.live(slot) else { return format!("{slot}: nothing to give a parent") };
    match joint(stage, other, rng).filter(|_| !once_in(rng, 3)) {
        Some(parent) if !is_below(stage.app.world(), parent, child) => {
            stage.world().entity_mut(child).insert(ChildOf(parent));
            format!("{slot}: child of {parent}")
        }
        _ => {
            stage.world().entity_mut(child).remove::<ChildOf>();
            format!("{slot}: no child any more")
        }
    }
}

/// Changes a transform, which comes in if there is none.
fn with(stage: &mut Stage, entity: Option<Entity>, change: impl FnOnce(&mut Transform)) -> String {
    let Some(entity) = entity else { return "nothing to move".into() };
    let mut entity = stage.app.world_mut().entity_mut(entity);
    let mut transform = entity.get::<Transform>().copied().unwrap_or_default();
    change(&mut transform);
    entity.insert(transform);
    format!("{} at {transform:?}", entity.id())
}

/// Moves it a little or far.
pub fn shift(stage: &mut Stage, slot: usize, rng: &mut Rng) -> String {
    let by = one_of(rng, &[0.01, 0.3, 3.0, 100.0, 1.0e5, 9.0e6]);
    let by = vector(rng, by);
    let entity = stage.live(slot);
    format!("{slot}: {}", with(stage, entity, |t| t.translation += by))
}

/// Moves and turns it, or a joint.
pub fn dance(stage: &mut Stage, slot: usize, rng: &mut Rng) -> String {
    let at = vector(rng, 0.5);
    let turn = if once_in(rng, 3) { turn(rng) } else { Quat::from_rotation_y(rng.f32()) };
    let entity = joint(stage, slot, rng);
    with(stage, entity, |t| (t.translation, t.rotation) = (at, turn))
}

/// Another scale.
pub fn scale(stage: &mut Stage, slot: usize, rng: &mut Rng) -> String {
    let mut scale = Vec3::splat(size(rng));
    match rng.u32(0..6) {
        0 => scale = vector(rng, 2.0),
        1 => scale.x = -scale.x,
        2 => scale = Vec3::ZERO,
        3 => scale[rng.usize(0..3)] = number(rng),
        _ => {}
    }
    let entity = joint(stage, slot, rng);
    with(stage, entity, |t| t.scale = scale)
}

/// A transform that is none.
pub fn nowhere(stage: &mut Stage, slot: usize, rng: &mut Rng) -> String {
    let (which, wild) = (rng.u32(0..3), wild_vector(rng));
    let entity = joint(stage, slot, rng);
    with(stage, entity, |t| match which {
        0 => t.translation = wild,
        1 => t.rotation = Quat::from_vec4(wild.extend(0.5)),
        _ => t.scale = wild,
    })
}

/// An entity without any component.
pub fn bare(stage: &mut Stage, slot: usize) -> String {
    let Some(entity) = stage.live(slot) else { return format!("{slot}: nothing to take everything from") };
    stage.world().entity_mut(entity).clear();
    format!("{slot}: without any component")
}
