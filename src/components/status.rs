//! How a cloth fares: waiting, simulated or failed, and the events on the way.

use bevy::prelude::*;

/// Whether a cloth is simulated.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub enum ClothStatus {
    /// Something is missing that may still come.
    Waiting(ClothWaitingFor),
    /// It is simulated, or sleeps ([`ClothReport::asleep`](crate::ClothReport::asleep)), or was switched off since
    /// ([`ClothDisabled`](crate::ClothDisabled)).
    Active,
    /// It cannot be simulated; [`ClothError`] on the entity says why.
    Failed,
    /// It has not been looked at yet.
    #[default]
    New,
}

/// Input that a cloth waits for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub enum ClothWaitingFor {
    /// A `Mesh3d` on the entity.
    #[default]
    Mesh,
    /// The mesh asset to load.
    Asset,
    /// A transform that is finite, no farther than 1e7 m from the origin, and whose scale is not zero along any axis.
    Transform,
    /// The target of a pin set to be spawned.
    Target,
    /// The joints or bind poses of its skin.
    Skin,
    /// Its mesh, which is large, to be prepared in the background ([`ClothLoading`](crate::ClothLoading)).
    Build,
}

impl ClothWaitingFor {
    pub(crate) const fn cure(self) -> &'static str {
        match self {
            Self::Mesh => "it has no `Mesh3d`: insert one",
            Self::Asset => "its mesh asset is not loaded: keep the handle's loader running, or check the path",
            Self::Transform => {
                "a number of its transform is not finite or beyond 1e7 m, or its scale is zero along an axis: set finite numbers, nearer to the \
                 origin, and a scale that is not zero"
            }
            Self::Target => "the target of a pin set was despawned or has no `Transform`: spawn it with one, or name another",
            Self::Skin => {
                "a joint or the inverse bind poses of its `SkinnedMesh` are missing: spawn them, or remove `SkinnedMesh`"
            }
            Self::Build => "its mesh takes long to prepare: give it fewer vertices, or set `ClothLoading`",
        }
    }
}

/// Why a cloth cannot be simulated. On the entity for as long as that is so; the authored mesh is drawn meanwhile.
#[derive(Component, Clone, Debug, Default, PartialEq, Eq, Reflect, thiserror::Error)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
#[error("{detail}")]
pub struct ClothError {
    /// Kind of failure.
    pub kind: ClothErrorKind,
    /// Exact cause, and what helps.
    pub detail: String,
}

/// Kinds of failures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Default, Clone, Debug, PartialEq, Hash)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub enum ClothErrorKind {
    /// The mesh asset failed to load.
    LoadFailed,
    /// The mesh is only in the render world, where it cannot be read.
    RenderWorldOnly,
    /// The mesh has no positions, or not as `Float32x3`.
    NoPositions,
    /// The mesh is made of lines or points.
    NotTriangles,
    /// The mesh has too few vertices, no triangle that can be simulated, or a position that is not finite.
    #[default]
    BadMesh,
    /// A pin set names a colour channel or attribute that the mesh does not have.
    NoPinAttribute,
    /// It blew up again and again and was stopped.
    Unstable,
}

impl ClothErrorKind {
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::LoadFailed => "LoadFailed",
            Self::RenderWorldOnly => "RenderWorldOnly",
            Self::NoPositions => "NoPositions",
            Self::NotTriangles => "NotTriangles",
            Self::BadMesh => "BadMesh",
            Self::NoPinAttribute => "NoPinAttribute",
            Self::Unstable => "Unstable",
        }
    }
}

/// A cloth cannot be simulated (any more).
#[derive(EntityEvent, Clone, Debug)]
pub struct ClothFailed {
    /// The cloth.
    pub entity: Entity,
    /// Why.
    pub error: ClothError,
}

/// A cloth blew up and was taken back.
#[derive(EntityEvent, Clone, Copy, Debug)]
pub struct ClothRecovered {
    /// The cloth.
    pub entity: Entity,
    /// How far back it was taken.
    pub level: ClothRecoveryLevel,
    /// What was wrong.
    pub cause: ClothRecoveryCause,
}

/// How far a cloth was taken back, mildest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[reflect(Clone, Debug, PartialEq)]
pub enum ClothRecoveryLevel {
    /// To its last good state, without velocity.
    LastGood,
    /// To its pose at rest.
    Rest,
    /// To its pose at rest, and stopped there.
    Frozen,
}

/// What was wrong with a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[reflect(Clone, Debug, PartialEq)]
pub enum ClothRecoveryCause {
    /// A position or velocity was not finite.
    NotFinite,
    /// A particle was faster than [`ClothSolver::max_speed`](crate::ClothSolver::max_speed).
    TooFast,
    /// An edge was longer than [`ClothSolver::reset_edge_ratio`](crate::ClothSolver::reset_edge_ratio) allows.
    Overstretched,
}

impl ClothRecoveryCause {
    /// The same in a sentence.
    pub(crate) const fn because(self) -> &'static str {
        match self {
            Self::NotFinite => "a position was not finite",
            Self::TooFast => "a particle was faster than `ClothSolver::max_speed`",
            Self::Overstretched => "an edge was longer than `ClothSolver::reset_edge_ratio` allows",
        }
    }
}

/// A cloth has begun to cross itself or another, and untangling did not end it within the frame.
#[derive(EntityEvent, Clone, Copy, Debug)]
pub struct ClothTangled {
    /// The cloth.
    pub entity: Entity,
    /// Edges that cross faces.
    pub crossings: u32,
    /// Length of the intersection curves `[m]`.
    pub contour_length: f32,
}

/// A cloth that was tangled is clean again.
#[derive(EntityEvent, Clone, Copy, Debug)]
pub struct ClothUntangled {
    /// The cloth.
    pub entity: Entity,
    /// How long it was tangled `[s]`.
    pub after: f32,
}

/// A tangled cloth is shown in its last clean shape from this frame on, for as long as
/// [`ClothSkipFrame`](crate::ClothSkipFrame) allows.
#[derive(EntityEvent, Clone, Copy, Debug)]
pub struct ClothHeld {
    /// The cloth.
    pub entity: Entity,
}

/// Untangling did not succeed for a second, so stronger means are used. First come regions and separations for every contour,
/// in more directions. At last the tangled part is drawn to the animated pose or the shape at rest. Methods other than
/// [`ByEndType`](crate::ClothUntanglingMethod::ByEndType) have only the last of these; with
/// [`ClothUntanglingDisabled`](crate::ClothUntanglingDisabled) there is none, and no event.
#[derive(EntityEvent, Clone, Copy, Debug)]
pub struct ClothUntanglingEscalated {
    /// The cloth.
    pub entity: Entity,
    /// Edges that cross faces.
    pub crossings: u32,
}

/// The target of a pin set is gone; what happens is up to [`ClothOnTargetLost`](crate::ClothOnTargetLost).
#[derive(EntityEvent, Clone, Copy, Debug)]
pub struct ClothTargetLost {
    /// The cloth.
    pub entity: Entity,
    /// The target that is gone.
    pub target: Entity,
}

/// The carrier of a cloth jumped, and the cloth went along as [`ClothTeleportMode`](crate::ClothTeleportMode) says.
#[derive(EntityEvent, Clone, Copy, Debug)]
pub struct ClothTeleported {
    /// The cloth.
    pub entity: Entity,
    /// Length of the jump `[m]`.
    pub distance: f32,
    /// Angle of the turn `[rad]`.
    pub angle: f32,
}
