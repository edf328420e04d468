//! Scratch: memory and buffers of a cloth beside its state, and what its last frame has to tell.

use bevy::math::DVec3;
use bevy::prelude::*;

use crate::components::{ClothRecoveryCause, ClothRecoveryLevel};
use crate::solver::step::{Scratch, StepReport};

/// Scratch: what decides the next frame beside the state, buffers, and what the last frame has to tell.
#[derive(Component, Clone)]
#[component(clone_behavior = Ignore)]
pub(crate) struct ClothScratch {
    pub solver: Scratch,
    /// Whether the solver was not prepared yet.
    pub fresh: bool,
    /// What the frame did, when it was stepped side by side with others.
    pub done: Option<StepReport>,
    /// What the last frame had to recover from.
    pub recovered: Option<(ClothRecoveryLevel, ClothRecoveryCause)>,
    /// Box of the cloth in the world at the last look `[m]`.
    pub bounds: Option<(DVec3, DVec3)>,
    /// The island of cloths it can meet, and its number there.
    pub island: Option<(u32, u32)>,
}

impl Default for ClothScratch {
    fn default() -> Self {
        Self { solver: Scratch::default(), fresh: true, done: None, recovered: None, bounds: None, island: None }
    }
}
