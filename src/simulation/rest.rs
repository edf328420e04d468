//! Rest: the shape a cloth was made with.

use std::sync::Arc;

use bevy::prelude::*;

use crate::solver::rest::RestShape;

/// Rest: the shape the cloth was made with, shared by every cloth of one mesh and scale.
#[derive(Component, Clone, Debug)]
#[component(clone_behavior = Ignore)]
pub struct ClothRest(pub(crate) Arc<RestShape>);

impl ClothRest {
    /// The shape.
    #[must_use]
    pub fn shape(&self) -> &RestShape {
        &self.0
    }

    /// Whether two cloths share one shape in memory.
    #[must_use]
    pub fn is_shared_with(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}
