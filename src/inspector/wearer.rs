//! The bodies of the character that wears a cloth.

use bevy::prelude::*;

use crate::components::{ClothBody, ClothCharacter};

/// Entities with a [`ClothBody`] of the character that a cloth belongs to, and how they are set.
pub(super) fn bodies(world: &World, cloth: Entity) -> Vec<(Entity, ClothBody)> {
    let up = |entity: &Entity| world.get::<ChildOf>(*entity).map(ChildOf::parent);
    let above = |entity: Entity| core::iter::successors(Some(entity), up);
    let Some(character) = above(cloth).find(|&at| world.entity(at).contains::<ClothCharacter>()) else { return Vec::new() };
    let Some(mut bodies) = world.try_query::<(Entity, &ClothBody)>() else { return Vec::new() };
    let own = bodies.iter(world).filter(|(body, _)| above(*body).any(|at| at == character));
    own.map(|(entity, body)| (entity, *body)).collect()
}
