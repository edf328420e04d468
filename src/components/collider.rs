//! What cloth drapes over.

use bevy::prelude::*;
use parry3d::shape::SharedShape;

use super::checked::Checked;
use super::fitted::ColliderBody;
use super::shape::{ClothColliderPart, ClothColliderShape, ClothMeshFit, ParryShape};

/// Pushes cloth away from its entity.
///
/// It moves with the entity, fast or slow. Cloth does not move it without
/// [`ClothCoupling::TwoWay`](crate::ClothCoupling::TwoWay). Which cloths it touches is up to
/// [`ClothCollisionLayers`](crate::ClothCollisionLayers). Entities with [`ClothColliderDisabled`] or `Disabled` push nothing;
/// on a cloth it pushes other cloths, not its own.
///
/// It meets the particles of a cloth, and its faces where it is finer than the mesh: tips, edges, small balls. A thin collider
/// that moves fast can still poke out for a frame. Give it a [`margin`](Self::margin), round its tip, or make the mesh finer.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # fn setup(mut commands: Commands) {
/// commands.spawn((Transform::from_xyz(0.0, 0.5, 0.0), ClothCollider::ball(0.5).with_friction(0.2)));
/// # }
/// ```
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[reflect(Component, Default, Clone, Debug)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
#[require(Transform, ColliderBody)]
pub struct ClothCollider {
    /// The shape, in the space of the entity.
    pub shape: ClothColliderShape,
    /// Extra distance the cloth keeps from the surface `[m]`, on top of its own thickness. Default 0, range 0 to 1.
    pub margin: f32,
    /// Coulomb coefficient below which cloth sticks (dimensionless). Default 0.5, range 0 to 10; combined by the geometric
    /// mean.
    pub static_friction: f32,
    /// Coulomb coefficient while cloth slides (dimensionless). Default 0.4, range 0 to 10; combined by the geometric mean.
    pub dynamic_friction: f32,
}

/// Switches the [`ClothCollider`] of its entity off: it pushes no cloth, as a sensor, until this is removed.
///
/// It comes back without having swept what lies between. Colliders of avian are kept away by avian's `ColliderDisabled`, or by
/// [`ClothCollisionDisabled`](crate::ClothCollisionDisabled).
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothColliderDisabled;

impl Default for ClothCollider {
    fn default() -> Self {
        Self::new(ClothColliderShape::default())
    }
}

impl ClothCollider {
    /// A collider of any shape.
    #[must_use]
    pub const fn new(shape: ClothColliderShape) -> Self {
        Self { shape, margin: 0.0, static_friction: 0.5, dynamic_friction: 0.4 }
    }

    /// A ball of `radius` `[m]`.
    #[must_use]
    pub const fn ball(radius: f32) -> Self {
        Self::new(ClothColliderShape::Ball { radius })
    }

    /// A capsule along y: `radius` `[m]`, `length` of the segment without the caps `[m]`.
    #[must_use]
    pub const fn capsule(radius: f32, length: f32) -> Self {
        Self::new(ClothColliderShape::Capsule { radius, length })
    }

    /// A box of lengths `x`, `y`, `z` `[m]`.
    #[must_use]
    pub const fn cuboid(x: f32, y: f32, z: f32) -> Self {
        Self::new(ClothColliderShape::Cuboid { size: Vec3::new(x, y, z) })
    }

    /// A cylinder of `radius` and `height` `[m]` along y, its middle at the origin.
    #[must_use]
    pub const fn cylinder(radius: f32, height: f32) -> Self {
        Self::new(ClothColliderShape::Cylinder { radius, height })
    }

    /// A cone of `radius` and `height` `[m]` along y, its tip up and the middle of its height at the origin.
    #[must_use]
    pub const fn cone(radius: f32, height: f32) -> Self {
        Self::new(ClothColliderShape::Cone { radius, height })
    }

    /// Everything below the plane through the origin with `normal` out of the solid, of any length but 0 (dimensionless).
    #[must_use]
    pub const fn half_space(normal: Vec3) -> Self {
        Self::new(ClothColliderShape::HalfSpace { normal })
    }

    /// The ground: everything below the entity's xz plane.
    #[must_use]
    pub const fn ground() -> Self {
        Self::half_space(Vec3::Y)
    }

    /// The convex hull of `points` `[m]`.
    #[must_use]
    pub fn convex_hull(points: impl IntoIterator<Item = Vec3>) -> Self {
        Self::new(ClothColliderShape::ConvexHull { points: points.into_iter().collect() })
    }

    /// A surface of triangles `[m]`, with two sides: cloth stays on the side it comes from.
    #[must_use]
    pub const fn tri_mesh(vertices: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Self {
        Self::new(ClothColliderShape::TriMesh { vertices, triangles, solid: false })
    }

    /// A closed surface of triangles `[m]`, counter-clockwise seen from outside.
    #[must_use]
    pub const fn solid_tri_mesh(vertices: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Self {
        Self::new(ClothColliderShape::TriMesh { vertices, triangles, solid: true })
    }

    /// Ground over a grid in xz. `heights` come row by row: rows along z, `columns` along x. `size` is the extent along x and z
    /// `[m]`, and the scale of heights along y.
    #[must_use]
    pub const fn height_field(rows: u32, columns: u32, heights: Vec<f32>, size: Vec3) -> Self {
        Self::new(ClothColliderShape::HeightField { rows, columns, heights, size })
    }

    /// Several shapes moved as one: `(translation [m], rotation, shape)`.
    #[must_use]
    pub fn compound(parts: impl IntoIterator<Item = (Vec3, Quat, ClothColliderShape)>) -> Self {
        let parts = parts
            .into_iter()
            .map(|(translation, rotation, shape)| ClothColliderPart { translation, rotation, shape })
            .collect();
        Self::new(ClothColliderShape::Compound { parts })
    }

    /// Fitted to the `Mesh3d` of the entity, once its asset is loaded.
    #[must_use]
    pub const fn fit_mesh(fit: ClothMeshFit) -> Self {
        Self::new(ClothColliderShape::Mesh(fit))
    }

    /// Any shape of parry3d.
    #[must_use]
    pub const fn parry(shape: SharedShape) -> Self {
        Self::new(ClothColliderShape::Parry(ParryShape(Some(shape))))
    }

    /// Sets both friction coefficients (dimensionless).
    #[must_use]
    pub const fn with_friction(mut self, coefficient: f32) -> Self {
        self.static_friction = coefficient;
        self.dynamic_friction = coefficient;
        self
    }

    /// Sets the extra distance the cloth keeps `[m]`.
    #[must_use]
    pub const fn with_margin(mut self, margin: f32) -> Self {
        self.margin = margin;
        self
    }

    /// Margin `[m]`, static and dynamic friction that can be used.
    pub(crate) fn checked(&self, checked: &mut Checked) -> (f32, f32, f32) {
        (
            checked.within("collider.margin", self.margin, 0.0, 0.0, 1.0),
            checked.within("collider.static_friction", self.static_friction, 0.5, 0.0, 10.0),
            checked.within("collider.dynamic_friction", self.dynamic_friction, 0.4, 0.0, 10.0),
        )
    }
}
