//! From the meshes of a skinned body to colliders for its bones, once for all bodies that are alike.

use std::sync::{Arc, Weak};

use bevy::mesh::VertexAttributeValues;
use bevy::mesh::skinning::SkinnedMeshInverseBindposes;
use bevy::platform::collections::{HashMap, HashSet};
use bevy::prelude::*;

use super::unreadable;
use crate::character::{BoneCollider, BoneShape};
use crate::components::{ClothBody, ClothCollider, ClothColliderShape};

/// Why a body gets no colliders.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum BodyError {
    /// It is simulated and cannot be in its own way.
    #[error("it is a `Cloth`: put `ClothBody` on the mesh that wears it, and remove one of the two here")]
    Cloth,
    /// Its mesh cannot be read.
    #[error("{0}")]
    Unreadable(String),
    /// Its mesh hangs on no joints.
    #[error(
        "its mesh has no joints: export it with its skin, which makes `Mesh::ATTRIBUTE_JOINT_INDEX` (Uint16x4) and \
         `Mesh::ATTRIBUTE_JOINT_WEIGHT` (Float32x4), or use `ClothCollider::fit_mesh`"
    )]
    NoJoints,
    /// Nothing is left to fit a shape to.
    #[error(
        "no shape fits it: its vertices need weights above 0 for joints of its `SkinnedMesh`, and inverse bind poses that can be inverted"
    )]
    NothingFits,
}

impl BodyError {
    /// What is told once.
    pub(crate) fn kind(&self) -> &'static str {
        match self {
            Self::Cloth => "body is cloth",
            Self::Unreadable(_) => "body is unreadable",
            Self::NoJoints => "body has no joints",
            Self::NothingFits => "nothing fits the body",
        }
    }
}

/// What a body waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BodyWait {
    Mesh,
    Skin,
    Asset,
    BindPoses,
    Joints,
    Scale,
}

impl BodyWait {
    /// What is missing, and what helps.
    pub(crate) fn cure(self) -> &'static str {
        match self {
            Self::Mesh => "it has no `Mesh3d`: put `ClothBody` on the entity of a skinned mesh",
            Self::Skin => {
                "it has no `SkinnedMesh`: put `ClothBody` on the entity of a skinned mesh, or use `ClothCollider::fit_mesh`"
            }
            Self::Asset => "its mesh is not loaded: keep the loader of its asset running, or check the path",
            Self::BindPoses => {
                "`SkinnedMesh::inverse_bindposes` is not loaded: keep the loader of its asset running, or check the handle"
            }
            Self::Joints => "`SkinnedMesh::joints` has an entity without `GlobalTransform`: give it a `Transform`",
            Self::Scale => {
                "no entity of `SkinnedMesh::joints` is there with a scale that is finite and not 0: spawn the joints, and scale them"
            }
        }
    }
}

/// Vertices of a skinned mesh, as they are in the asset.
pub(crate) struct SkinnedVertices<'a> {
    pub positions: &'a [[f32; 3]],
    pub joints: &'a [[u16; 4]],
    pub weights: &'a [[f32; 4]],
}

impl<'a> SkinnedVertices<'a> {
    pub(crate) fn of(mesh: &'a Mesh) -> Result<Self, BodyError> {
        let positions = match mesh.try_attribute(Mesh::ATTRIBUTE_POSITION) {
            Ok(VertexAttributeValues::Float32x3(positions)) => positions,
            Ok(_) => return Err(BodyError::Unreadable("its mesh has positions that are not Float32x3: convert them".into())),
            Err(error) => return Err(BodyError::Unreadable(unreadable(&error).detail)),
        };
        let Ok(VertexAttributeValues::Uint16x4(joints)) = mesh.try_attribute(Mesh::ATTRIBUTE_JOINT_INDEX) else {
            return Err(BodyError::NoJoints);
        };
        let Ok(VertexAttributeValues::Float32x4(weights)) = mesh.try_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT) else {
            return Err(BodyError::NoJoints);
        };
        Ok(Self { positions, joints, weights })
    }
}

/// All that a fit depends on.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct BodyKey {
    pub meshes: Vec<AssetId<Mesh>>,
    pub bind_poses: AssetId<SkinnedMeshInverseBindposes>,
    /// Whether each joint is there, and which one is above it.
    pub joints: Vec<(bool, Option<usize>)>,
    /// Bits of the metres per unit of the mesh.
    pub unit: u32,
}

/// Fitted colliders of bodies that are alike; forgotten with the last body that uses them.
#[derive(Resource, Default)]
pub(crate) struct BodyCache {
    fits: HashMap<BodyKey, Weak<[BoneCollider]>>,
}

impl BodyCache {
    /// The colliders of a body, fitted if no other body has them yet.
    pub(crate) fn get_or_fit(&mut self, key: BodyKey, fit: impl FnOnce() -> Vec<BoneCollider>) -> Arc<[BoneCollider]> {
        if let Some(known) = self.fits.get(&key).and_then(Weak::upgrade) {
            return known;
        }
        let fitted: Arc<[BoneCollider]> = fit().into();
        self.fits.retain(|_, known| known.strong_count() > 0);
        self.fits.insert(key, Arc::downgrade(&fitted));
        fitted
    }

    /// Forgets the colliders of meshes that changed.
    pub(crate) fn forget(&mut self, meshes: &HashSet<AssetId<Mesh>>) {
        self.fits.retain(|key, _| !key.meshes.iter().any(|mesh| meshes.contains(mesh)));
    }
}

/// The collider of a bone, and its place under the joint. `settings` are in range.
pub(crate) fn collider_of(fitted: &BoneCollider, settings: &ClothBody) -> (ClothCollider, Transform) {
    let (shape, place) = match &fitted.shape {
        &BoneShape::Capsule { a, b, radius } => {
            let (length, along) = ((b - a).length(), (b - a).try_normalize().unwrap_or(Vec3::Y));
            // One that is almost a ball is a ball.
            let length = if length > 1.0e-3 * radius { length } else { 0.0 };
            let place = Transform::from_translation(0.5 * (a + b)).with_rotation(Quat::from_rotation_arc(Vec3::Y, along));
            (ClothColliderShape::Capsule { radius, length }, place)
        }
        BoneShape::Hull { points } => (ClothColliderShape::ConvexHull { points: points.clone() }, Transform::IDENTITY),
    };
    let collider = ClothCollider {
        shape,
        margin: margin_of(fitted, settings),
        static_friction: settings.static_friction,
        dynamic_friction: settings.dynamic_friction,
    };
    (collider, place)
}

/// Distance that cloth keeps from it `[m]`: that of settings in range, or what covers nine in ten of its vertices.
pub(crate) fn margin_of(fitted: &BoneCollider, settings: &ClothBody) -> f32 {
    settings.margin.max(fitted.margin).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::character::Outside;

    #[test]
    fn a_capsule_lies_between_its_ends_and_a_short_one_is_a_ball() {
        let (a, b) = (Vec3::new(0.1, -0.2, 0.3), Vec3::new(0.1, -0.2, -0.4));
        let shape = BoneShape::Capsule { a, b, radius: 0.05 };
        let mut fitted = BoneCollider { joint: 0, shape, unit: 1.0, margin: 3.0, vertices: 9, outside: Outside::default() };
        let (collider, place) = collider_of(&fitted, &ClothBody::default());
        assert_eq!(collider.margin, 1.0);
        let ClothColliderShape::Capsule { radius, length } = collider.shape else { panic!("{collider:?}") };
        assert!(radius == 0.05 && (length - 0.7).abs() < 1.0e-6, "{radius} {length}");
        for (end, y) in [(a, -0.35), (b, 0.35)] {
            let at = place.transform_point(Vec3::Y * y);
            assert!(at.distance(end) < 1.0e-6, "{at} for {end}");
        }
        fitted.shape = BoneShape::Capsule { a, b: a + Vec3::X * 1.0e-6, radius: 0.05 };
        let (collider, place) = collider_of(&fitted, &ClothBody::default());
        assert_eq!(collider.shape, ClothColliderShape::Capsule { radius: 0.05, length: 0.0 });
        assert!(place.translation.distance(a) < 1.0e-5 && place.is_finite());
    }
}
