//! Fine meshes that follow a coarse cloth.

use bevy::prelude::*;

/// Render mesh: a fine mesh that is drawn in place of that of a coarse cloth, which is simulated (a *simulation mesh* or
/// *proxy* elsewhere). It costs what the coarse one does, and a deformation of its vertices.
///
/// Each vertex follows the triangles of the cloth within an edge of where it was authored. What is finer than the cloth, such
/// as a seam, a hem of two layers or a wrinkle, keeps its shape and its normals. Several meshes may follow one cloth.
///
/// Give the cloth no material, so that it is not drawn itself. Author both meshes in the same place: a skinned one in the pose
/// of its skeleton. Pins, maps, limits and fabric are those of the cloth. The render mesh loses its skin while it follows. It
/// gets skin and authored mesh back when this or [`Cloth`](crate::Cloth) is removed. The same happens where
/// [`ClothBlend`](crate::ClothBlend) or [`ClothLod`](crate::ClothLod) leave the cloth to its skin.
///
/// In a glTF, `cloth.proxy` on the object that is drawn names the object that is simulated.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # fn spawn(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, red: Handle<StandardMaterial>) {
/// let sheet = |n: u32| Plane3d::default().mesh().size(2.0, 2.0).subdivisions(n).build();
/// let coarse = meshes.add(sheet(20));
/// let fine = meshes.add(sheet(120));
/// let cloth = commands.spawn((Mesh3d(coarse), Cloth, ClothPins::where_position(|p| p.z < -0.99))).id();
/// commands.spawn((Mesh3d(fine), MeshMaterial3d(red), ClothRenderMesh { cloth }, ChildOf(cloth)));
/// # }
/// ```
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothRenderMesh {
    /// The cloth that it follows.
    #[entities]
    pub cloth: Entity,
}

impl Default for ClothRenderMesh {
    fn default() -> Self {
        Self { cloth: Entity::PLACEHOLDER }
    }
}
