//! What of a skinned cloth was made close to the bones of who wears it.

use std::sync::Arc;

use bevy::ecs::system::SystemParam;
use bevy::math::Affine3A;
use bevy::prelude::*;

use super::bodies::WorldBody;
use crate::bind::Skin;
use crate::components::fitted::ColliderBody;
use crate::solver::body::{SharedShape, Snug};

/// How much farther particles are listed than they are kept away, so that a slider lists none anew (dimensionless).
const REACH: f32 = 2.0;

/// Where colliders hang on joints.
#[derive(SystemParam)]
pub(crate) struct Bones<'w, 's> {
    colliders: Query<'w, 's, (&'static ColliderBody, Option<&'static ChildOf>, Option<&'static Transform>)>,
    pub parents: Query<'w, 's, &'static ChildOf>,
}

impl Bones<'_, '_> {
    /// From the space of the mesh to that of a collider in the bind pose. None for one that is neither a joint of the skin nor
    /// a child of one.
    fn in_bind_pose(&self, skin: &Skin, collider: Entity) -> Option<Affine3A> {
        let (body, parent, at) = self.colliders.get(collider).ok()?;
        let to_collider = match (skin.inverse_bind(collider), parent, at) {
            (Some(inverse_bind), ..) => inverse_bind,
            (None, Some(parent), Some(at)) => at.compute_affine().inverse() * skin.inverse_bind(parent.parent())?,
            _ => return None,
        };
        // The scale of all above it is in the shape.
        Some(Affine3A::from_scale(body.scale) * to_collider).filter(Affine3A::is_finite)
    }
}

/// What of one cloth was made close to each bone.
#[derive(Clone, Default)]
pub(crate) struct Worn {
    /// By entity.
    bones: Vec<(Entity, OnBone)>,
}

#[derive(Clone)]
struct OnBone {
    shape: SharedShape,
    /// Distance up to which particles are listed `[m]`.
    reach: f32,
    snug: Option<Arc<Snug>>,
}

impl Worn {
    /// Forgets bones that are not among these bodies, in the order of entities.
    pub(crate) fn keep(&mut self, bodies: &[Entity]) {
        self.bones.retain(|(bone, _)| bodies.binary_search(bone).is_ok());
    }

    /// The particles that were made closer to a bone than `keep` `[m]`; none for a body that hangs on no joint of the skin.
    pub(crate) fn on(&mut self, bone: &WorldBody, keep: f32, skin: &Skin, bones: &Bones) -> Option<Arc<Snug>> {
        let at = self.bones.binary_search_by_key(&bone.entity, |(entity, _)| *entity);
        if let Ok(at) = at
            && let (_, OnBone { shape, reach, snug }) = &self.bones[at]
            && Arc::ptr_eq(&shape.0, &bone.shape.0)
            && keep <= *reach
        {
            return snug.clone();
        }
        let reach = REACH * keep;
        let snug = bones.in_bind_pose(skin, bone.entity).map(|to_bone| {
            let points: Vec<Vec3> = skin.points().iter().map(|point| to_bone.transform_point3(*point)).collect();
            Arc::new(Snug::of(&bone.shape, reach, &points))
        });
        let snug = snug.filter(|snug| !snug.is_empty());
        let known = (bone.entity, OnBone { shape: bone.shape.clone(), reach, snug: snug.clone() });
        match at {
            Ok(at) => self.bones[at] = known,
            Err(at) => self.bones.insert(at, known),
        }
        snug
    }
}
