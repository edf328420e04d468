#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

// In the order of the data flow.
pub mod plugin;
pub mod components;
#[cfg(feature = "gltf")]
pub mod gltf;
#[cfg(feature = "avian")]
mod avian;
mod bind;
mod groups;
mod notices;
pub mod simulation;
mod systems;
pub mod solver;
pub mod scenes;

pub use components::{
    Cloth, ClothBuildReport, ClothCollider, ClothCollision, ClothCoupling, ClothError, ClothErrorKind, ClothFailed,
    ClothGravity, ClothHeld, ClothImpulse, ClothLastResort, ClothLayers, ClothMaterial, ClothPins, ClothRecovered, ClothReport,
    ClothRigidBody, ClothSolver, ClothStatus, ClothTangled, ClothTargetLost, ClothTeleported, ClothUntangled, ClothWind,
    ColliderPart, ColliderShape, ColorChannel, GlobalWind, MeshFit, NoClothCollision, OnTargetLost, PinSelect, PinSet,
    PositionPredicate, RecoveryCause, RecoveryLevel, SkipFrame, SkipPolicy, TeleportMode, Untangle, UntangleMethod, WaitingFor,
    WindZone, WindZoneShape,
};
pub use groups::ClothGroups;
pub use plugin::{ClothPlugin, ClothSystems};
pub use simulation::{ClothParticles, ClothRest};

/// What most apps need.
pub mod prelude {
    pub use crate::{
        Cloth, ClothCollider, ClothCollision, ClothCoupling, ClothError, ClothFailed, ClothGravity, ClothHeld, ClothImpulse,
        ClothLastResort, ClothLayers, ClothMaterial, ClothParticles, ClothPins, ClothPlugin, ClothRecovered, ClothReport,
        ClothRigidBody, ClothSolver, ClothStatus, ClothSystems, ClothTangled, ClothTargetLost, ClothTeleported, ClothUntangled,
        ClothWind, ColliderShape, ColorChannel, GlobalWind, MeshFit, NoClothCollision, OnTargetLost, PinSelect, PinSet,
        SkipFrame, SkipPolicy, TeleportMode, Untangle, UntangleMethod, WindZone, WindZoneShape,
    };
}
