//! How a cloth meets itself and other cloths.

use bevy::prelude::*;

/// How a cloth meets itself and other cloths. Reserved: its fields are kept and saved, but have no effect yet.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
pub struct ClothCollision {
    /// Whether it keeps off itself. Default true. Reserved: has no effect yet.
    pub self_collision: bool,
    /// Order of layers of clothing: higher lies outside. Default 0. Reserved: has no effect yet.
    pub layer: i32,
}

impl Default for ClothCollision {
    fn default() -> Self {
        Self { self_collision: true, layer: 0 }
    }
}
