//! A number for each vertex: one for all, or painted.

use bevy::prelude::*;

use super::ClothColorChannel;

/// A number for each vertex of a cloth, in the unit of the setting that it is for.
#[derive(Clone, Debug, Default, PartialEq, Reflect)]
#[cfg_attr(feature = "presets", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub enum ClothMap {
    /// The setting is off.
    #[default]
    Off,
    /// The same everywhere.
    Uniform(f32),
    /// `low + (high - low) * paint`, where paint goes from 0 to 1. Paint beyond that counts as 0 or 1, and paint that is not a
    /// number as 0.
    Painted {
        /// What was painted.
        paint: ClothPaint,
        /// Where the paint is 0.
        low: f32,
        /// Where the paint is 1.
        high: f32,
    },
}

/// Where a painted number is in a mesh.
#[derive(Clone, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "presets", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub enum ClothPaint {
    /// A channel of the vertex colour.
    Color(ClothColorChannel),
    /// A float attribute of that name, such as `"_CLOTH_MAXDIST"` in a glTF. Of one with several components the first, or the
    /// one that is named behind a dot: `"_CLOTH_PAINT.g"` is the second of `r`, `g`, `b`, `a`.
    Attribute(String),
}

impl Default for ClothPaint {
    fn default() -> Self {
        Self::Color(ClothColorChannel::default())
    }
}

impl ClothMap {
    /// A channel of the vertex colour, from `low` where it is 0 to `high` where it is 1.
    #[must_use]
    pub const fn color(channel: ClothColorChannel, low: f32, high: f32) -> Self {
        Self::Painted { paint: ClothPaint::Color(channel), low, high }
    }

    /// A float attribute of the mesh, or one of its components such as `"_CLOTH_PAINT.g"`. The map is `low` where the attribute
    /// is 0, `high` where it is 1.
    #[must_use]
    pub fn attribute(name: impl Into<String>, low: f32, high: f32) -> Self {
        Self::Painted { paint: ClothPaint::Attribute(name.into()), low, high }
    }

    /// Whether it is off.
    #[must_use]
    pub fn is_off(&self) -> bool {
        *self == Self::Off
    }
}

impl From<f32> for ClothMap {
    fn from(value: f32) -> Self {
        Self::Uniform(value)
    }
}
