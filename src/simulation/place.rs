//! Place: where a cloth is among the others.

use bevy::math::DVec3;
use bevy::prelude::*;

/// Place: the island of a cloth, and the box it was in at the last look.
#[derive(Component, Clone, Default)]
#[component(clone_behavior = Ignore)]
pub(crate) struct IslandPlace {
    /// Box of the cloth in the world at the last look `[m]`.
    pub bounds: Option<(DVec3, DVec3)>,
    /// How far its box went between the last two looks at which it had moved `[m]`.
    pub motion: f64,
    /// The island of cloths it can meet, and its number there.
    pub island: Option<(u32, u32)>,
    /// Whether it was in none when it last moved: it can meet nothing, and not itself.
    pub alone: bool,
}
