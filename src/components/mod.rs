//! What users spawn and read: one file per concern.

pub(crate) mod checked;

mod cloth;
mod collider;
mod collision;
mod grab;
mod coupling;
mod layers;
mod lod;
mod material;
mod pins;
mod primitive;
mod report;
mod shape;
mod skip;
mod sleep;
mod solver;
mod status;
mod touch;
mod untangle;
mod wind;

pub use cloth::Cloth;
pub use collider::ClothCollider;
pub use collision::ClothCollision;
pub use coupling::{ClothCoupling, ClothImpulse, ClothRigidBody, NoClothCollision};
pub use grab::ClothGrab;
pub use layers::ClothLayers;
pub use lod::{ClothDetail, ClothLod};
pub use material::ClothMaterial;
pub use pins::{ClothPins, ColorChannel, OnTargetLost, PinSelect, PinSet, PositionPredicate};
pub use report::{ClothBuildReport, ClothReport};
pub use shape::{ColliderPart, ColliderShape, MeshFit};
pub use skip::{SkipFrame, SkipPolicy};
pub use sleep::{ClothSleep, ClothSlept, ClothWoke};
pub use solver::{ClothGravity, ClothMembrane, ClothSolver, TeleportMode};
pub use status::{
    ClothError, ClothErrorKind, ClothFailed, ClothHeld, ClothLastResort, ClothRecovered, ClothStatus, ClothTangled,
    ClothTargetLost, ClothTeleported, ClothUntangled, RecoveryCause, RecoveryLevel, WaitingFor,
};
pub use touch::{ClothContactEnded, ClothContactEvents, ClothContactStarted, ClothTouch};
pub use untangle::{Untangle, UntangleMethod};
pub use wind::{ClothWind, GlobalWind, WindZone, WindZoneShape};
