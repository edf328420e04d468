//! What is remembered of a grip from one frame to the next. It comes along with the grip; users do not see it.

use bevy::prelude::*;

/// What a grip holds, found once.
#[derive(Component, Clone, Default)]
#[component(clone_behavior = Ignore)]
pub(crate) struct Grip {
    /// Particles and their shares, which add up to one.
    pub shares: Vec<(u32, f32)>,
    /// From what the shares were found: cloth, particles, weights, radius, and number of particles.
    pub of: Option<(Entity, [u32; 3], Vec3, f32, usize)>,
    /// Target of the last frame in the world `[m]`.
    pub target: Option<Vec3>,
}
