//! Characters: bodies with bones that cloth drapes over.

use bevy::prelude::*;

use super::checked::Checked;
use super::fitted::FittedBody;

/// Makes colliders for the bones of a skinned body. Put it on an entity with `Mesh3d` and `SkinnedMesh`.
///
/// Each part of the body gets a capsule, or a convex hull where it is flat. The collider is an entity of its own, a child of
/// its joint, with a [`ClothCollider`](crate::ClothCollider) and a name such as `thigh_l collider`. It moves with the joint.
/// You may edit or despawn it. Its layers are the [`ClothCollisionLayers`](crate::ClothCollisionLayers) of its joint, or of the
/// nearest joint above that has some, or of this entity. So a skirt can let hands through.
///
/// Colliders are fitted to the mesh in its bind pose, which takes up to 50 ms; characters of the same mesh share the result.
/// They are made anew when the mesh, the skin or the layers change, and edits are lost. A change of this component writes
/// margins and friction to them, and keeps shapes, places and contacts. Change all bodies that are fitted together at once.
/// Bodies with the same joints, settings and layers are fitted together: a character whose mesh is in pieces has one set of
/// colliders. All go when this component is removed.
///
/// A [`Cloth`](crate::Cloth) is no body: this belongs on what wears it.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// fn dress(mut commands: Commands, skins: Query<(Entity, &Name), Added<bevy::mesh::skinning::SkinnedMesh>>) {
///     for (entity, name) in &skins {
///         if name.starts_with("Body") {
///             commands.entity(entity).insert(ClothBody::default());
///         }
///     }
/// }
/// ```
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
#[require(FittedBody)]
pub struct ClothBody {
    /// Distance that cloth keeps from each shape, on top of its own thickness `[m]`. Default 0.015, range 0 to 1. Where more
    /// than a tenth of a part sticks out farther, its collider keeps that distance. Too low: the body shows through; too high:
    /// clothes stand off.
    pub margin: f32,
    /// Coulomb coefficient below which cloth sticks (dimensionless). Default 0.5, range 0 to 10; combined by the geometric
    /// mean. Too low: clothes slip off shoulders; too high: they ride up with the limbs.
    pub static_friction: f32,
    /// Coulomb coefficient while cloth slides (dimensionless). Default 0.4, range 0 to 10; combined by the geometric mean.
    pub dynamic_friction: f32,
}

impl Default for ClothBody {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl ClothBody {
    /// The defaults.
    pub const DEFAULT: Self = Self { margin: 0.015, static_friction: 0.5, dynamic_friction: 0.4 };

    /// Sets both friction coefficients (dimensionless).
    #[must_use]
    pub const fn with_friction(mut self, coefficient: f32) -> Self {
        self.static_friction = coefficient;
        self.dynamic_friction = coefficient;
        self
    }

    /// Sets the distance that cloth keeps `[m]`.
    #[must_use]
    pub const fn with_margin(mut self, margin: f32) -> Self {
        self.margin = margin;
        self
    }

    /// Settings that can be used.
    pub(crate) fn checked(&self, checked: &mut Checked) -> Self {
        let Self { margin, static_friction, dynamic_friction } = Self::DEFAULT;
        Self {
            margin: checked.within("body.margin", self.margin, margin, 0.0, 1.0),
            static_friction: checked.within("body.static_friction", self.static_friction, static_friction, 0.0, 10.0),
            dynamic_friction: checked.within("body.dynamic_friction", self.dynamic_friction, dynamic_friction, 0.0, 10.0),
        }
    }
}
