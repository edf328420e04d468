//! From simulated cloth to its animation, and back.

use bevy::prelude::*;

use super::checked::Checked;

/// How much of a skinned cloth is simulated. Below 1 the cloth may go less far from its animated skin than
/// [`ClothLimits`](crate::ClothLimits) say. At 0 the entity has its own mesh and `SkinnedMesh` back: the GPU skins it, and it
/// costs nothing. Far away [`ClothLod`](crate::ClothLod) and [`ClothBudget`](crate::ClothBudget) do the same.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// // A dance goes too far for the skirt: it is animated within a quarter of a second.
/// fn dance(mut commands: Commands, skirt: Single<Entity, With<Cloth>>) {
///     commands.entity(*skirt).insert(ClothBlend { weight: 0.0, ..default() });
/// }
/// # let mut app = App::new();
/// # app.add_systems(Update, dance);
/// ```
///
/// Does nothing to a cloth without a skin.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothBlend {
    /// 1: simulated, 0: animated (dimensionless). Default 1, range 0 to 1.
    pub weight: f32,
    /// How fast what is shown goes there `[1/s]`. Default 4, range 0.01 to 1000. Fast, it is seen to be drawn to its skin.
    pub rate: f32,
}

impl Default for ClothBlend {
    fn default() -> Self {
        Self { weight: 1.0, rate: 4.0 }
    }
}

impl ClothBlend {
    pub(crate) fn checked(&self, checked: &mut Checked) -> Self {
        Self {
            weight: checked.within("blend.weight", self.weight, 1.0, 0.0, 1.0),
            rate: checked.within("blend.rate", self.rate, 4.0, 0.01, 1000.0),
        }
    }
}
