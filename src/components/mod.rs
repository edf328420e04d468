//! What users spawn and read, one file per concern; `fitted` and `grip` come along with it and are not theirs.

mod blend;
pub(crate) mod checked;
pub(crate) mod fitted;
pub(crate) mod grip;

mod body;
mod budget;
mod character;
mod cloth;
mod collider;
mod collision;
mod coupling;
mod decimation;
mod grab;
mod hit;
mod layers;
mod limits;
mod loading;
mod lod;
mod map;
mod material;
mod piece;
mod render_mesh;
mod reset;
mod pins;
mod primitive;
mod report;
mod shape;
mod skip;
mod sleep;
mod solver;
mod status;
mod subdivision;
mod touch;
mod untangle;
mod warm_up;
mod wind;

pub use blend::ClothBlend;
pub use body::ClothBody;
pub use budget::{ClothBudget, ClothPriority};
pub use character::{ClothCharacter, ClothInertia};
pub use cloth::{Cloth, ClothDisabled};
pub use collider::{ClothCollider, ClothColliderDisabled};
pub use collision::ClothCollision;
pub use coupling::{ClothCollisionDisabled, ClothCoupling, ClothReaction, ClothRigidBody};
pub use decimation::ClothDecimation;
pub use grab::ClothGrab;
pub use hit::ClothHit;
pub use layers::ClothCollisionLayers;
pub use limits::{ClothDrive, ClothLimits};
pub use loading::ClothLoading;
pub use lod::{ClothDetail, ClothLod};
pub use map::{ClothMap, ClothPaint};
pub use material::ClothMaterial;
pub use piece::ClothPiece;
pub use pins::{ClothColorChannel, ClothOnTargetLost, ClothPinSelect, ClothPinSet, ClothPins, PositionPredicate};
pub use render_mesh::ClothRenderMesh;
pub use report::{ClothBuildReport, ClothReport};
pub use reset::ClothReset;
pub use shape::{ClothColliderPart, ClothColliderShape, ClothMeshFit, ParryShape};
pub use skip::{ClothSkipFrame, ClothSkipPolicy};
pub use sleep::{ClothSleep, ClothSleepDisabled, ClothSlept, ClothWoke};
pub use solver::{ClothGravity, ClothMembrane, ClothSolver, ClothTeleportMode};
pub use status::{
    ClothError, ClothErrorKind, ClothFailed, ClothHeld, ClothRecovered, ClothRecoveryCause, ClothRecoveryLevel, ClothStatus,
    ClothTangled, ClothTargetLost, ClothTeleported, ClothUntangled, ClothUntanglingEscalated, ClothWaitingFor,
};
pub use subdivision::ClothSubdivision;
pub use touch::{ClothContactEnded, ClothContactEvents, ClothContactStarted, ClothContacts, ClothTouch};
pub use untangle::{ClothUntangling, ClothUntanglingDisabled, ClothUntanglingMethod};
pub use warm_up::ClothWarmUp;
pub use wind::{ClothGlobalWind, ClothWind, ClothWindZone, ClothWindZoneShape};
