//! Cloth that begins anew.

use bevy::prelude::*;

/// Puts a cloth back to where it begins, without velocity, contact or fold. It begins on its skin, or in its shape at rest
/// where its carrier is. On an entity that is no cloth it is for all cloths below, such as those of a
/// [`ClothCharacter`](crate::ClothCharacter). The plugin removes it when that is done, in the next frame in which time passes
/// and the cloth is simulated. A cloth that [failed](crate::ClothFailed) since it blew up begins anew, too.
///
/// For games that know when a new scene, a new round or another clip begins. A jump that is far and fast is found without it:
/// [`ClothSolver::teleport`](crate::ClothSolver::teleport).
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// fn respawn(mut commands: Commands, hero: Single<Entity, With<ClothCharacter>>) {
///     commands.entity(*hero).insert((Transform::default(), ClothReset));
/// }
/// # let mut app = App::new();
/// # app.add_systems(Update, respawn);
/// ```
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothReset;
