//! Characters that wear cloth, and how much of their motion it feels.

use bevy::prelude::*;

use super::checked::Checked;

/// The root of a character. The cloths and colliders below it move as one: they teleport in the same frame, and feel the same
/// motion.
///
/// A skinned cloth without one above it inserts one, on the lowest entity above both the cloth and its joints.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothCharacter;

/// Inertia: the share of its carrier's motion that a cloth feels. The rest carries the cloth along. So a sprint does not blow a
/// skirt over the head.
///
/// A cloth without it feels all motion. So do cloths that can meet a cloth of another character, or of none, and those pinned
/// to bodies that cloth can move.
///
/// ```
/// # use bevy_drape::prelude::*;
/// // On a ship of 10 m/s the cape hangs as in a harbour, and still swings with every step.
/// # use bevy::prelude::*;
/// # fn cape(ship: Entity) -> impl Bundle {
/// ClothInertia { space: Some(ship), ..ClothInertia::CHARACTER }
/// # }
/// ```
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothInertia {
    /// Share of the way of the carrier that the cloth feels (dimensionless). Default 1, range 0 to 1.
    pub linear: f32,
    /// Share of its turn (dimensionless). Default 1, range 0 to 1.
    pub angular: f32,
    /// Fastest way that is felt `[m/s]`. Default infinite, from 0.
    pub max_speed: f32,
    /// Fastest turn that is felt `[rad/s]`. Default infinite, from 0.
    pub max_turn: f32,
    /// A ship, a lift or a vehicle whose motion is never felt. Default none.
    #[entities]
    pub space: Option<Entity>,
}

impl Default for ClothInertia {
    fn default() -> Self {
        Self { linear: 1.0, angular: 1.0, max_speed: f32::INFINITY, max_turn: f32::INFINITY, space: None }
    }
}

impl ClothInertia {
    /// For clothes on a character: three quarters of its motion, up to 8 m/s and 12 rad/s.
    pub const CHARACTER: Self = Self { linear: 0.75, angular: 0.75, max_speed: 8.0, max_turn: 12.0, space: None };

    pub(crate) fn checked(&self, checked: &mut Checked) -> Self {
        Self {
            linear: checked.within("inertia.linear", self.linear, 1.0, 0.0, 1.0),
            angular: checked.within("inertia.angular", self.angular, 1.0, 0.0, 1.0),
            max_speed: checked.within_or_off("inertia.max_speed", self.max_speed, f32::INFINITY, 0.0, 1.0e6),
            max_turn: checked.within_or_off("inertia.max_turn", self.max_turn, f32::INFINITY, 0.0, 1.0e6),
            space: self.space,
        }
    }
}
