//! Cloth that is finer than its mesh.

use bevy::prelude::*;

/// Subdivision: splits the long edges of a mesh before it becomes cloth, so that a plane of four vertices or a cape of fifty
/// bends.
///
/// The cloth is simulated and drawn with a finer copy of its mesh. Normals, texture coordinates, colours, maps and weights of a
/// skin are interpolated. The vertices of the mesh keep their numbers, so pins by vertex hold the same vertices. Pins by
/// position, colour or attribute hold the new vertices between, too. Morph targets are lost. What is flat stays flat until the
/// cloth bends. A mesh under a [`ClothRenderMesh`](crate::ClothRenderMesh) is made finer, too; one that is drawn by
/// [pieces](crate::ClothPiece) is not.
///
/// The copy is made in the frame in which the mesh arrives, whatever [`ClothLoading`](crate::ClothLoading) says. The mesh is
/// given back when this or [`Cloth`](crate::Cloth) is removed. Another length makes another copy, and the cloth begins anew;
/// cloths with the same mesh and length share one. In a glTF, it is `cloth.subdivision`.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # fn spawn(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>) {
/// let four_vertices = meshes.add(Plane3d::default().mesh().size(2.0, 2.0));
/// commands.spawn((Mesh3d(four_vertices), Cloth, ClothSubdivision::new(0.05), ClothPins::where_position(|p| p.z < -0.99)));
/// # }
/// ```
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothSubdivision {
    /// The longest edge that is left, in the space of the mesh, before its scale `[m]`. Default 0.05, more than 0. Shorter:
    /// finer folds, and a cost that grows with the inverse square; no mesh gets more than 50,000 vertices.
    pub longest_edge: f32,
}

impl ClothSubdivision {
    /// Splits edges longer than `longest_edge` `[m]`.
    #[must_use]
    pub const fn new(longest_edge: f32) -> Self {
        Self { longest_edge }
    }
}

impl Default for ClothSubdivision {
    fn default() -> Self {
        Self::new(0.05)
    }
}
