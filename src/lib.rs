//! Cloth for Bevy that does not stretch like rubber, does not tangle, and says so when it does.
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_drape::prelude::*;
//!
//! fn setup(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>) {
//!     commands.spawn((
//!         Mesh3d(meshes.add(Plane3d::default().mesh().size(2.0, 2.0).subdivisions(40))),
//!         Cloth,
//!         ClothMaterial::SILK,
//!         ClothPins::where_position(|p| p.z < -0.99),
//!     ));
//!     commands.spawn((Transform::from_xyz(0.0, -1.0, 0.0), ClothCollider::ball(0.5)));
//! }
//! ```

#![forbid(unsafe_code)]

mod bind;
pub mod components;
#[cfg(feature = "gltf")]
pub mod gltf;
mod groups;
mod notices;
pub mod plugin;
pub mod scenes;
pub mod simulation;
pub mod solver;
mod systems;

pub use components::{
    Cloth, ClothBuildReport, ClothCollider, ClothCollision, ClothError, ClothErrorKind, ClothFailed, ClothGravity, ClothHeld,
    ClothLayers, ClothMaterial, ClothPins, ClothRecovered, ClothReport, ClothSolver, ClothStatus, ClothTangled,
    ClothTargetLost, ClothTeleported, ClothUntangled, ClothWind, ColliderPart, ColliderShape, ColorChannel, GlobalWind,
    MeshFit, OnTargetLost, PinSelect, PinSet, PositionPredicate, RecoveryCause, RecoveryLevel, SkipFrame, SkipPolicy,
    TeleportMode, Untangle, UntangleMethod, WaitingFor, WindZone, WindZoneShape,
};
pub use groups::ClothGroups;
pub use plugin::{ClothPlugin, ClothSystems};
pub use simulation::{ClothParticles, ClothRest};

/// What most apps need.
pub mod prelude {
    pub use crate::{
        Cloth, ClothCollider, ClothCollision, ClothGravity, ClothLayers, ClothMaterial, ClothPins, ClothPlugin, ClothReport,
        ClothSolver, ClothStatus, ClothSystems, ClothWind, ColorChannel, GlobalWind, MeshFit, OnTargetLost, SkipFrame,
        SkipPolicy, Untangle, UntangleMethod, WindZone,
    };
}
