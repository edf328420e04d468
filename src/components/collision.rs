//! How a cloth meets itself and other cloths.

use bevy::prelude::*;

/// How a cloth meets itself and other cloths.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
pub struct ClothCollision {
    /// Whether it is untangled from itself, not only from other cloths. Default false; cloth from glTF: true. Looking for crossings of a draped sheet of 64 x 64 with itself
    /// takes some milliseconds a frame, and nothing yet keeps folds apart before they cross.
    pub self_collision: bool,
    /// Order of layers of clothing: higher lies outside. Default 0. Reserved: has no effect yet.
    pub layer: i32,
}
