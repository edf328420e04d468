//! Cloth that is coarser than its mesh.

use bevy::prelude::*;

/// Decimation: a fine mesh is simulated with fewer particles, and drawn as fine as it is.
///
/// Edges that are shorter than a length are collapsed before the mesh becomes cloth; those that are left have about 1.2 times
/// that length. Every vertex of the mesh follows the triangles near it, as a [`ClothRenderMesh`](crate::ClothRenderMesh) does.
/// So hems, seams and wrinkles that are finer than the cloth keep their shape and their normals. A garment of 15,000 vertices
/// costs what one of a thousand does, and the deformation of its vertices.
///
/// Particles are vertices of the mesh, with the pins, maps and weights of a skin that were authored there. The others follow.
/// A pinned vertex that is no particle holds the one that it went into, up to two lengths away, where nothing beside that is
/// held. [Pieces](crate::ClothPiece) of several materials follow, too. No vertex, and no border, is farther from what is
/// simulated than an eighth of the length.
///
/// Another length builds the cloth anew, in the frame in which it changes; where other edges collapse it begins as authored, as
/// with another mesh. [`ClothSubdivision`](crate::ClothSubdivision) comes first. In a glTF, it is `cloth.decimation`.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # fn spawn(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>) {
/// let fine = meshes.add(Plane3d::default().mesh().size(2.0, 2.0).subdivisions(150));
/// commands.spawn((Mesh3d(fine), Cloth, ClothDecimation::new(0.04), ClothPins::where_position(|p| p.z < -0.99)));
/// # }
/// ```
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothDecimation {
    /// Edges shorter than this are collapsed, in the space of the mesh, before its scale `[m]`. Default 0.03, more than 0.
    /// Longer: fewer particles, by the square, and wider folds.
    pub shortest_edge: f32,
}

impl ClothDecimation {
    /// The length that is used `[m]`; 0, which collapses nothing, for one that is not above 0 and finite.
    pub(crate) fn usable(decimation: Option<&Self>) -> f32 {
        let length = decimation.map_or(0.0, |decimation| decimation.shortest_edge);
        if length > 0.0 && length < f32::INFINITY { length } else { 0.0 }
    }

    /// Collapses edges shorter than `shortest_edge` `[m]`.
    #[must_use]
    pub const fn new(shortest_edge: f32) -> Self {
        Self { shortest_edge }
    }
}

impl Default for ClothDecimation {
    fn default() -> Self {
        Self::new(0.03)
    }
}
