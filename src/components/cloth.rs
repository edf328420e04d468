//! The marker that makes a mesh a cloth.

use bevy::ecs::lifecycle::HookContext;
use bevy::ecs::world::DeferredWorld;
use bevy::prelude::*;

use super::{
    ClothBuildReport, ClothCollision, ClothMaterial, ClothPins, ClothReport, ClothSkipFrame, ClothSleep, ClothSolver,
    ClothStatus, ClothUntangling,
};
use crate::notices;
use crate::schedule::ClothClock;

/// Makes the [`Mesh3d`] of its entity a cloth.
///
/// Everything else has defaults, and what is removed while `Cloth` stays comes back as its default:
/// - [`ClothMaterial`], [`ClothSolver`] and [`ClothPins`]: what it is made of, how exactly it is simulated, where it is held.
/// - [`ClothCollision`], [`ClothUntangling`] and [`ClothSkipFrame`]: what happens when it meets itself or another cloth.
/// - [`ClothSleep`]: when it is left alone.
/// - [`ClothStatus`], [`ClothReport`] and [`ClothBuildReport`]: how it fares.
///
/// Other components are optional: [`ClothWind`](crate::ClothWind), [`ClothCollisionLayers`](crate::ClothCollisionLayers),
/// [`ClothLimits`](crate::ClothLimits) and [`ClothDrive`](crate::ClothDrive) on characters, [`ClothLod`](crate::ClothLod),
/// [`ClothContactEvents`](crate::ClothContactEvents). Markers switch something off for as long as they are there:
/// [`ClothDisabled`], [`ClothSleepDisabled`](crate::ClothSleepDisabled),
/// [`ClothUntanglingDisabled`](crate::ClothUntanglingDisabled).
///
/// The mesh asset itself is never written: the entity gets a copy of its own, and removing `Cloth` gives the authored mesh
/// back. The cloth starts where the entity is and then lives in the world. Moving the entity moves the particles pinned to it,
/// and the rest follows by physics.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # fn setup(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>) {
/// commands.spawn((
///     Mesh3d(meshes.add(Plane3d::default().mesh().size(2.0, 2.0).subdivisions(40))),
///     Cloth,
///     ClothMaterial::SILK,
///     ClothPins::where_position(|p| p.z < -0.99),
/// ));
/// # }
/// ```
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
#[component(on_add = needs_plugin)]
#[require(
    ClothMaterial,
    ClothSolver,
    ClothPins,
    ClothCollision,
    ClothUntangling,
    ClothSkipFrame,
    ClothSleep,
    ClothStatus,
    ClothReport,
    ClothBuildReport,
    Transform
)]
pub struct Cloth;

fn needs_plugin(world: DeferredWorld<'_>, HookContext { entity, .. }: HookContext) {
    notices::needs_plugin::<Cloth, ClothClock>(world, entity, "ClothPlugin");
}

/// Switches the cloth of its entity off for as long as it is there. The cloth is not simulated, costs nothing and meets no
/// other cloth. It keeps its last shape in the space of its entity, or the authored mesh if it never ran. When this is removed
/// the cloth goes on from where it was, with the speed it had.
///
/// Its carrier may move meanwhile: a long way is a teleport ([`ClothSolver::teleport`](crate::ClothSolver::teleport)), a short
/// one that of a single frame. A cloth that is to stay where others lie on it is paused, with a
/// [`time_scale`](field@crate::ClothSolver::time_scale) of 0.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothDisabled;
