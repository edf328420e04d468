//! Who touches whom.

use bevy::prelude::*;

/// Layers of a cloth, of a collider or, on a joint, of what a [`ClothBody`](crate::ClothBody) fits to it and below. Without it:
/// member of layer 0, touches everything.
///
/// Two things touch when each is a member of a layer that the other filters for. The order of clothes that are worn over each
/// other is [`ClothCollision::garment_layer`](crate::ClothCollision::garment_layer).
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothCollisionLayers {
    /// Layers it belongs to, a bit each. Default `1`.
    pub memberships: u32,
    /// Layers it touches, a bit each. Default all.
    pub filters: u32,
}

impl ClothCollisionLayers {
    /// Member of layer 0, touches everything.
    pub const DEFAULT: Self = Self { memberships: 1, filters: u32::MAX };

    /// Member of `memberships`, touches `filters`.
    #[must_use]
    pub const fn new(memberships: u32, filters: u32) -> Self {
        Self { memberships, filters }
    }

    /// Whether the two touch.
    #[must_use]
    pub const fn touches(self, other: Self) -> bool {
        self.memberships & other.filters != 0 && other.memberships & self.filters != 0
    }
}

impl Default for ClothCollisionLayers {
    fn default() -> Self {
        Self::DEFAULT
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_touch_only_when_each_filters_for_the_other() {
        let a = ClothCollisionLayers::new(0b01, 0b10);
        let b = ClothCollisionLayers::new(0b10, 0b01);
        let c = ClothCollisionLayers::new(0b10, 0b10);
        assert!(a.touches(b) && b.touches(a));
        assert!(!a.touches(c) && !c.touches(a));
    }
}
