#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

// In the order of the data flow.
pub mod plugin;
pub mod components;
#[cfg(feature = "gltf")]
pub mod gltf;
mod bind;
mod notices;
pub mod simulation;
mod systems;
pub mod solver;
pub mod scenes;

pub use components::{
    Cloth, ClothBuildReport, ClothCollider, ClothCollision, ClothError, ClothErrorKind, ClothFailed, ClothGravity, ClothLayers,
    ClothMaterial, ClothPins, ClothRecovered, ClothReport, ClothSolver, ClothStatus, ClothTargetLost, ClothTeleported,
    ClothWind, ColliderPart, ColliderShape, ColorChannel, GlobalWind, MeshFit, OnTargetLost, PinSelect, PinSet,
    PositionPredicate, RecoveryCause, RecoveryLevel, TeleportMode, WaitingFor, WindZone, WindZoneShape,
};
pub use plugin::{ClothPlugin, ClothSystems};
pub use simulation::{ClothParticles, ClothRest};

/// What most apps need.
pub mod prelude {
    pub use crate::{
        Cloth, ClothCollider, ClothError, ClothFailed, ClothGravity, ClothLayers, ClothMaterial, ClothParticles, ClothPins,
        ClothPlugin, ClothRecovered, ClothReport, ClothSolver, ClothStatus, ClothSystems, ClothTargetLost, ClothTeleported,
        ClothWind, ColliderShape, ColorChannel, GlobalWind, MeshFit, OnTargetLost, PinSelect, PinSet, TeleportMode, WindZone,
        WindZoneShape,
    };
}
