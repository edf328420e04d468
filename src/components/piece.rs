//! Cloths of several materials.

use bevy::prelude::*;

/// Piece: shows a part of a cloth with a mesh and a material of its own. It is how a cloth has several materials.
///
/// The mesh of the cloth holds the vertices of all of its pieces, one after the other, as [`Mesh::merge`] puts them. It is
/// simulated, and not drawn itself: give the cloth no material, and spawn its pieces in the frame in which it becomes a cloth.
/// Where vertices of two pieces lie in the same place, they stay together.
///
/// The mesh of a piece takes the places of those vertices from [`first`](Self::first) on; what else it has stays its own. A
/// piece lies where its cloth does: make it a child without a transform of its own.
///
/// Removing it gives the piece the mesh back that was authored, as removing [`Cloth`](crate::Cloth) from the cloth does. A node
/// of a glTF whose mesh has several primitives becomes a cloth with a piece for each of them.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # fn spawn(commands: &mut Commands, meshes: &mut Assets<Mesh>, [outside, lining]: [Mesh; 2], [red, silk]: [Handle<StandardMaterial>; 2]) {
/// let mut both = outside.clone();
/// both.merge(&lining).expect("meshes with the same attributes");
/// let first = outside.count_vertices() as u32;
/// let cape = commands.spawn((Mesh3d(meshes.add(both)), Cloth, ClothPins::where_position(|p| p.y > 1.4))).id();
/// commands.entity(cape).with_children(|pieces| {
///     pieces.spawn((Mesh3d(meshes.add(outside)), MeshMaterial3d(red), ClothPiece { cloth: cape, first: 0 }));
///     pieces.spawn((Mesh3d(meshes.add(lining)), MeshMaterial3d(silk), ClothPiece { cloth: cape, first }));
/// });
/// # }
/// ```
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothPiece {
    /// The cloth that it shows a part of.
    #[entities]
    pub cloth: Entity,
    /// The vertex in the mesh of the cloth that is its first (number). Range 0 to the vertices of the cloth less its own.
    pub first: u32,
}

impl Default for ClothPiece {
    fn default() -> Self {
        Self { cloth: Entity::PLACEHOLDER, first: 0 }
    }
}
