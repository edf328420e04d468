//! How a cloth meets itself and other cloths.

use bevy::prelude::*;

/// How a cloth meets itself and other cloths.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "presets", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothCollision {
    /// Whether the cloth meets itself: it is untangled from itself and, with `contact`, folds on itself. Default true.
    pub self_collision: bool,
    /// Whether the cloth rests on other cloths, and on itself, one thickness apart and with friction. Default true. Without it,
    /// cloths pass through each other and are untangled afterwards.
    pub contact: bool,
    /// Order of garments. Where two cloths cross, the one with the higher number moves outside, to the front of the triangles.
    /// Cloth that lies there in another order is found, too. Default 0; equal numbers have no order. Where pins of both hold
    /// them in another order, that of the pins counts, and a warning says so.
    /// [`ClothCollisionLayers`](crate::ClothCollisionLayers) decide which cloths meet at all.
    pub garment_layer: i32,
}

impl Default for ClothCollision {
    fn default() -> Self {
        Self { self_collision: true, contact: true, garment_layer: 0 }
    }
}
