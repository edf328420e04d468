//! From which mesh a cloth was made, what was taken off its entity for that, and how long it has waited to be made.

use bevy::math::Mat3;
use bevy::mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes};
use bevy::prelude::*;

use crate::components::ClothWaitingFor;

/// What changed since a cloth was bound.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Change {
    #[default]
    None,
    Pins,
    Scale,
    Mesh,
}

/// Which meshes and which scale a cloth was made from.
#[derive(Component)]
#[component(clone_behavior = Ignore)]
pub(crate) struct Binding {
    /// The authored mesh: read, never written.
    pub source: Handle<Mesh>,
    /// The entity's own mesh: written. None while the cloth cannot be simulated.
    pub instance: Option<Handle<Mesh>>,
    /// Scale and shear that the rest shape has baked in.
    pub bake: Mat3,
    /// Length below which edges were collapsed, in the space of the mesh `[m]`; 0: none.
    pub shortest_edge: f32,
    /// Whether the entity had `NoAutoAabb` before.
    pub own_bounds: bool,
    /// What changed and could not be bound yet.
    pub pending: Change,
    /// Whether the entity has its skin and the authored mesh, being animated only.
    pub on_skin: bool,
}

/// Which mesh a piece of a cloth, or a render mesh, was made from.
#[derive(Component)]
#[component(clone_behavior = Ignore)]
pub(crate) struct PieceBinding {
    /// The authored mesh.
    pub source: Handle<Mesh>,
    /// The mesh of its own, which is shown.
    pub instance: Handle<Mesh>,
    /// Whether the entity had `NoAutoAabb` before.
    pub own_bounds: bool,
    /// What was written last: the cloth, its vertex that is the first here, and its [`ClothShown::writes`](super::ClothShown).
    pub written: Option<(Entity, u32, u32)>,
}

/// The skin that was taken off a cloth's entity. A clone of the entity takes it along, with its own joints where those are
/// cloned, too.
#[derive(Component, Clone, Debug, Default)]
pub(crate) struct TakenSkin {
    pub inverse_bindposes: Handle<SkinnedMeshInverseBindposes>,
    #[entities]
    pub joints: Vec<Entity>,
    /// Whether `DynamicSkinnedMeshBounds` was taken off, too.
    pub bounds: bool,
}

impl TakenSkin {
    /// The component that was taken off.
    pub(crate) fn skin(&self) -> SkinnedMesh {
        SkinnedMesh { inverse_bindposes: self.inverse_bindposes.clone(), joints: self.joints.clone() }
    }
}

/// How long a cloth has waited.
#[derive(Component, Clone, Copy)]
#[component(clone_behavior = Ignore)]
pub(crate) struct WaitingSince {
    /// What for.
    pub reason: ClothWaitingFor,
    /// Real time at the start `[s]`.
    pub at: f64,
    /// Whether the user was told.
    pub told: bool,
}
