//! Shapes of colliders, as data: for scenes, inspectors and files.

use bevy::prelude::*;
use parry3d::shape::SharedShape;

/// Shape of a collider in the space of its entity; lengths are scaled by the entity's transform.
#[derive(Clone, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Default, Clone, Debug)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub enum ClothColliderShape {
    /// A ball around the origin.
    Ball {
        /// Radius `[m]`.
        radius: f32,
    },
    /// A capsule along y.
    Capsule {
        /// Radius `[m]`.
        radius: f32,
        /// Length of its segment, without the caps `[m]`.
        length: f32,
    },
    /// A box around the origin.
    Cuboid {
        /// Its lengths `[m]`.
        size: Vec3,
    },
    /// A cylinder along y.
    Cylinder {
        /// Radius `[m]`.
        radius: f32,
        /// Height `[m]`.
        height: f32,
    },
    /// A cone along y, tip up.
    Cone {
        /// Radius of its base `[m]`.
        radius: f32,
        /// Height `[m]`.
        height: f32,
    },
    /// Everything below a plane through the origin.
    HalfSpace {
        /// Out of the solid.
        normal: Vec3,
    },
    /// The convex hull of points.
    ConvexHull {
        /// The points `[m]`.
        points: Vec<Vec3>,
    },
    /// A surface of triangles; cloth stays on the side it comes from, and the surface may be open.
    TriMesh {
        /// The vertices `[m]`.
        vertices: Vec<Vec3>,
        /// Corners of each triangle.
        triangles: Vec<[u32; 3]>,
        /// Whether it is closed and counter-clockwise seen from outside, so that cloth inside is pushed out.
        solid: bool,
    },
    /// Ground over a grid in xz, with +y up.
    HeightField {
        /// Samples along z.
        rows: u32,
        /// Samples along x.
        columns: u32,
        /// Heights `[m]`, row by row.
        heights: Vec<f32>,
        /// Size along x and z `[m]`, and scale of the heights along y.
        size: Vec3,
    },
    /// Several shapes moved as one.
    Compound {
        /// The parts.
        parts: Vec<ClothColliderPart>,
    },
    /// Fitted to the mesh of the entity.
    Mesh(ClothMeshFit),
    /// Any shape of parry3d; neither saved nor shown.
    #[cfg_attr(feature = "serialize", serde(skip))]
    Parry(#[reflect(ignore)] ParryShape),
}

/// A shape of parry3d as it is.
#[derive(Clone, Default)]
pub struct ParryShape(pub Option<SharedShape>);

impl core::fmt::Debug for ParryShape {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("ParryShape(..)")
    }
}

impl PartialEq for ParryShape {
    fn eq(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (Some(a), Some(b)) => std::sync::Arc::ptr_eq(&a.0, &b.0),
            (None, None) => true,
            _ => false,
        }
    }
}

/// How a collider is fitted to the mesh of its entity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub enum ClothMeshFit {
    /// The ball around the centre of its box that holds every vertex.
    Ball,
    /// A capsule along the longest axis of its box.
    Capsule,
    /// Its box.
    Cuboid,
    /// Its convex hull.
    ConvexHull,
    /// Its triangles.
    #[default]
    TriMesh,
    /// Everything below its local xz plane, +y out.
    HalfSpace,
}

/// One shape of a compound.
#[derive(Clone, Debug, Default, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Default, Clone, Debug)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothColliderPart {
    /// Position in the collider `[m]`.
    pub translation: Vec3,
    /// Orientation in the collider.
    pub rotation: Quat,
    /// The shape. It must not be a compound or triangles: a collider with such a part pushes nothing, and says so in a warning.
    pub shape: ClothColliderShape,
}

impl Default for ClothColliderShape {
    fn default() -> Self {
        Self::Ball { radius: 0.5 }
    }
}
