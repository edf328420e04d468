//! Cloth for [Bevy](https://bevy.org) that does not stretch like rubber.
//!
//! [`ClothPlugin`] simulates every mesh with a [`Cloth`]. The other components have defaults; a cloth takes those it needs:
//!
//! - what it is made of: [`ClothMaterial`]; what holds it: [`ClothPins`];
//! - collision: [`ClothCollider`], [`ClothBody`], [`ClothCollision`] with cloth; wind: [`ClothGlobalWind`], [`ClothWind`],
//!   [`ClothWindZone`];
//! - how it follows a character: [`ClothLimits`], [`ClothDrive`], [`ClothInertia`], [`ClothBlend`];
//! - how it begins: [`ClothWarmUp`], [`ClothReset`], [`ClothPose`];
//! - how much it may cost: [`ClothSleep`], [`ClothLod`], [`ClothBudget`], [`ClothSolver`];
//! - reports and events: [`ClothReport`], [`ClothStatus`], [`ClothRecovered`] and others.
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_drape::prelude::*;
//!
//! fn setup(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>) {
//!     let sheet = Plane3d::default().mesh().size(2.0, 2.0).subdivisions(60);
//!     commands.spawn((Mesh3d(meshes.add(sheet)), Cloth, ClothMaterial::COTTON, ClothPins::where_position(|p| p.z < -0.99)));
//! }
//! ```
//!
//! Lengths are in metres, masses in kilograms, times in seconds. The solver, [`solver`], knows nothing of the engine and can be
//! used without it.
#![forbid(unsafe_code)]
#![warn(unreachable_pub)]

// In the order of the data flow.
pub mod plugin;
pub mod components;
#[cfg(feature = "gltf")]
pub mod gltf;
#[cfg(feature = "inspector")]
pub mod inspector;
#[cfg(feature = "presets")]
pub mod presets;
#[cfg(feature = "avian")]
mod avian;
mod bind;
mod islands;
mod notices;
#[cfg(feature = "picking")]
mod picking;
mod query;
#[cfg(feature = "record")]
mod recorder;
mod schedule;
pub mod simulation;
mod skin_query;
mod snapshot;
mod systems;
mod time;
#[cfg(feature = "debug")]
pub mod debug;
mod diagnostics;
pub mod character;
pub mod solver;
#[cfg(feature = "lab")]
pub mod lab;

pub use components::{
    Cloth, ClothBlend, ClothBody, ClothBudget, ClothBuildReport, ClothCharacter, ClothCollider, ClothColliderDisabled,
    ClothColliderPart, ClothColliderShape, ClothCollision, ClothCollisionDisabled, ClothCollisionLayers, ClothColorChannel,
    ClothContactEnded, ClothContactEvents, ClothContactStarted, ClothContacts, ClothCoupling, ClothDecimation, ClothDetail,
    ClothDisabled, ClothDrive, ClothError, ClothErrorKind, ClothFailed, ClothGlobalWind, ClothGrab, ClothGravity, ClothHeld,
    ClothHit, ClothInertia, ClothLimits, ClothLoading, ClothLod, ClothMap, ClothMaterial, ClothMembrane, ClothMeshFit,
    ClothOnTargetLost, ClothPaint, ClothPiece, ClothPinSelect, ClothPinSet, ClothPins, ClothPriority, ClothReaction,
    ClothRecovered, ClothRecoveryCause, ClothRecoveryLevel, ClothRenderMesh, ClothReport, ClothReset, ClothRigidBody,
    ClothSkipFrame, ClothSkipPolicy, ClothSleep, ClothSleepDisabled, ClothSlept, ClothSolver, ClothStatus, ClothSubdivision,
    ClothTangled, ClothTargetLost, ClothTeleportMode, ClothTeleported, ClothTouch, ClothUntangled, ClothUntangling,
    ClothUntanglingDisabled, ClothUntanglingEscalated, ClothUntanglingMethod, ClothWaitingFor, ClothWarmUp, ClothWind,
    ClothWindZone, ClothWindZoneShape, ClothWoke, ParryShape, PositionPredicate,
};
#[cfg(feature = "debug")]
pub use debug::{ClothDebug, ClothDebugPlugin, ClothGizmos};
pub use diagnostics::ClothDiagnosticsPlugin;
pub use islands::ClothIslands;
#[cfg(feature = "picking")]
pub use picking::{ClothDraggable, ClothPickingPlugin, ClothPickingSettings};
pub use plugin::ClothPlugin;
#[cfg(feature = "presets")]
pub use presets::{ClothPreset, ClothPresetHandle};
pub use query::ClothQuery;
#[cfg(feature = "record")]
pub use recorder::{ClothRecorder, ClothRecorderPlugin, ClothRecordings};
pub use schedule::ClothSystems;
pub use simulation::{ClothParticles, ClothPose, ClothRest};
pub use skin_query::ClothSkinQuery;
pub use snapshot::{ClothSnapshot, ClothSnapshotError};

/// What most apps need.
pub mod prelude {
    pub use crate::{
        Cloth, ClothBlend, ClothBody, ClothBudget, ClothBuildReport, ClothCharacter, ClothCollider, ClothColliderDisabled,
        ClothColliderShape, ClothCollision, ClothCollisionDisabled, ClothCollisionLayers, ClothColorChannel, ClothContactEnded,
        ClothContactEvents, ClothContactStarted, ClothContacts, ClothCoupling, ClothDecimation, ClothDetail, ClothDisabled,
        ClothDrive, ClothError, ClothFailed, ClothGlobalWind, ClothGrab, ClothGravity, ClothHeld, ClothHit, ClothInertia,
        ClothLimits, ClothLoading, ClothLod, ClothMap, ClothMaterial, ClothMembrane, ClothMeshFit, ClothOnTargetLost,
        ClothPaint, ClothParticles, ClothPiece, ClothPinSelect, ClothPinSet, ClothPins, ClothPlugin, ClothPose, ClothPriority,
        ClothQuery, ClothReaction, ClothRecovered, ClothRenderMesh, ClothReport, ClothReset, ClothRest, ClothRigidBody,
        ClothSkinQuery, ClothSkipFrame, ClothSkipPolicy, ClothSleep, ClothSleepDisabled, ClothSlept, ClothSnapshot,
        ClothSnapshotError, ClothSolver, ClothStatus, ClothSubdivision, ClothSystems, ClothTangled, ClothTargetLost,
        ClothTeleportMode, ClothTeleported, ClothTouch, ClothUntangled, ClothUntangling, ClothUntanglingDisabled,
        ClothUntanglingEscalated, ClothUntanglingMethod, ClothWarmUp, ClothWind, ClothWindZone, ClothWindZoneShape, ClothWoke,
    };
    #[cfg(feature = "debug")]
    pub use crate::{ClothDebug, ClothDebugPlugin};
    pub use crate::{ClothDiagnosticsPlugin, ClothErrorKind, ClothRecoveryCause, ClothRecoveryLevel, ClothWaitingFor};
    #[cfg(feature = "picking")]
    pub use crate::{ClothDraggable, ClothPickingPlugin, ClothPickingSettings};
    #[cfg(feature = "presets")]
    pub use crate::{ClothPreset, ClothPresetHandle};
    #[cfg(feature = "record")]
    pub use crate::{ClothRecorder, ClothRecorderPlugin, ClothRecordings};
}

/// The code in the guide compiles, too.
#[cfg(doctest)]
mod guide {
    #[doc = include_str!("../README.md")]
    mod readme {}
    #[doc = include_str!("../docs/characters.md")]
    mod characters {}
    #[doc = include_str!("../docs/components.md")]
    mod components {}
    #[doc = include_str!("../docs/fabrics.md")]
    mod fabrics {}
    #[doc = include_str!("../docs/panel.md")]
    mod panel {}
    #[doc = include_str!("../docs/resolution.md")]
    mod resolution {}
    #[doc = include_str!("../docs/tools.md")]
    mod tools {}
}
