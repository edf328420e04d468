//! What is remembered of a body from one frame to the next. It comes along with a collider, a coupling or a skinned body; users
//! do not see it.

use std::sync::Arc;

use bevy::mesh::skinning::SkinnedMeshInverseBindposes;
use bevy::prelude::*;

use super::body::ClothBody;
use super::layers::ClothCollisionLayers;
use super::shape::ClothColliderShape;
use crate::character::BoneCollider;
use crate::solver::body::SharedShape;

/// Shape of a collider as it was made, and where it was.
#[derive(Component, Default)]
#[component(clone_behavior = Ignore)]
pub(crate) struct ColliderBody {
    pub stage: Stage,
    /// What the collider was when its shape was made last: margin and friction need no other.
    pub asked: ClothColliderShape,
    pub shape: Option<SharedShape>,
    pub unscaled: Option<SharedShape>,
    pub scale: Vec3,
    pub mesh: Option<AssetId<Mesh>>,
    /// Where it was at the end of the last frame.
    pub pose: Option<Isometry3d>,
    /// Radius of the ball around it `[m]`.
    pub reach: f32,
}

impl ColliderBody {
    /// Whether this shape was made from that of another crate last.
    #[cfg(feature = "avian")]
    pub(crate) fn has_made(&self, shape: &SharedShape) -> bool {
        self.shape.as_ref().is_some_and(|made| Arc::ptr_eq(&made.0, &shape.0))
    }

    /// Takes a shape that was checked.
    pub(crate) fn make(&mut self, shape: Option<SharedShape>) {
        self.reach = shape.as_ref().map_or(0.0, |shape| shape.compute_local_bounding_sphere().radius);
        self.shape = shape;
    }
}

/// How far a shape is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Stage {
    /// Not tried yet.
    #[default]
    New,
    /// Its mesh is not there; since that real time `[s]`.
    Waiting {
        since: f64,
    },
    /// It cannot be made until something changes.
    Failed,
    Made,
}

/// Where a body that takes part was at the end of the last frame, and how many cloths gave it something.
#[derive(Component, Clone, Copy, Debug, Default)]
#[component(clone_behavior = Ignore)]
pub(crate) struct CoupledBody {
    pub pose: Option<Isometry3d>,
    pub givers: u32,
}

/// What the colliders of a skinned body were fitted to.
#[derive(Component, Default)]
#[component(clone_behavior = Ignore)]
pub(crate) struct FittedBody {
    pub stage: Stage,
    pub made_of: MadeOf,
    /// Layers of the joints of its skin, of those that have some.
    pub joint_layers: Vec<Option<ClothCollisionLayers>>,
    /// Bodies that were fitted together, this one first. Empty where another one is first, or nothing is fitted.
    pub members: Vec<Entity>,
    /// The settings that its colliders have, in range.
    pub settings: ClothBody,
    /// What was fitted to them; keeps it for others with the same mesh.
    pub colliders: Option<Arc<[BoneCollider]>>,
}

/// What of a skinned body can be compared from frame to frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct MadeOf {
    pub mesh: Option<AssetId<Mesh>>,
    pub skin: Option<AssetId<SkinnedMeshInverseBindposes>>,
    pub is_cloth: bool,
    pub layers: Option<ClothCollisionLayers>,
}

/// On a collider of a bone: the first of the bodies it was fitted to. It is reflected so that a scene that is saved and loaded
/// has no second set.
#[derive(Component, Clone, Copy, Debug, Reflect)]
#[reflect(Component, Clone, Debug)]
#[relationship(relationship_target = FittedColliders)]
pub(crate) struct FittedTo(pub Entity);

/// Colliders of the bones of a body. They go with it, and yet are not linked: whoever clones a character clones them as
/// children of joints, and would have them twice.
#[derive(Component, Debug)]
#[relationship_target(relationship = FittedTo)]
pub(crate) struct FittedColliders(Vec<Entity>);
