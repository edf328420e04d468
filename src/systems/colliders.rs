//! Prepare: where every body was and is, in the world.

use bevy::prelude::*;

use crate::bind::{ColliderError, Sources, shape_of};
use crate::components::checked::Checked;
use crate::components::{ClothCollider, ClothLayers, ColliderShape};
use crate::notices::{Notices, label};
use crate::solver::body::{SharedShape, shape};

/// Shape of a collider as it was made, and where it was.
#[derive(Component, Default)]
#[component(clone_behavior = Ignore)]
pub(crate) struct ColliderBody {
    /// Whether the shape was tried.
    made: bool,
    shape: Option<SharedShape>,
    unscaled: Option<SharedShape>,
    scale: Vec3,
    mesh: Option<AssetId<Mesh>>,
    pose: Option<Isometry3d>,
    reach: f32,
}

/// A body in the world in this frame.
pub(crate) struct WorldBody {
    pub entity: Entity,
    pub shape: SharedShape,
    pub from: Isometry3d,
    pub to: Isometry3d,
    pub layers: ClothLayers,
    pub margin: f32,
    pub static_friction: f32,
    pub dynamic_friction: f32,
}

/// Every body, in the order of entities.
#[derive(Resource, Default)]
pub(crate) struct WorldBodies {
    pub bodies: Vec<WorldBody>,
    checked: Checked,
}

/// Makes shapes of new colliders, and of those whose data, scale or mesh changed.
pub(crate) fn shapes(
    mut commands: Commands,
    meshes: Res<Assets<Mesh>>,
    sources: Res<Sources>,
    mut notices: ResMut<Notices>,
    mut colliders: Query<(
        Entity,
        Option<&Name>,
        Ref<ClothCollider>,
        &GlobalTransform,
        Option<&Mesh3d>,
        Option<&mut ColliderBody>,
    )>,
) {
    for (entity, name, collider, global, mesh, body) in &mut colliders {
        let source = mesh.map(|m| sources.authored(&m.0));
        let fitted = matches!(collider.shape, ColliderShape::Mesh(_));
        let mesh_id = source.as_ref().filter(|_| fitted).map(Handle::id);
        let scale = global.scale();
        let Some(mut body) = body else {
            commands.entity(entity).try_insert(ColliderBody::default());
            continue;
        };
        let arrived = mesh_id.is_some_and(|id| sources.modified.contains(&id) || sources.added.contains(&id));
        let changed = collider.is_changed() || body.mesh != mesh_id || arrived || !body.made;
        if changed || (body.unscaled.is_none() && fitted) {
            body.made = true;
            body.mesh = mesh_id;
            body.scale = Vec3::ZERO;
            body.unscaled = match shape_of(&collider.shape, source.as_ref().and_then(|s| meshes.get(s))) {
                Ok(shape) => Some(shape),
                Err(ColliderError::NoMesh) => None,
                Err(error) => {
                    if notices.first(entity, "shape") {
                        warn!("collider {} pushes nothing: {error}", label(entity, name));
                    }
                    None
                }
            };
        }
        if changed || (scale - body.scale).abs().max_element() > 1.0e-4 * scale.abs().max_element() {
            body.scale = scale;
            body.shape = body.unscaled.as_ref().and_then(|unscaled| match shape::scaled(unscaled, scale) {
                Ok(shape) => Some(shape),
                Err(error) => {
                    if notices.first(entity, "scale") {
                        warn!("collider {} pushes nothing: {error}", label(entity, name));
                    }
                    None
                }
            });
            body.reach = body.shape.as_ref().map_or(0.0, |s| s.compute_local_bounding_sphere().radius);
        }
    }
}

/// Records where every body was in the last simulated frame and is now.
pub(crate) fn poses(
    mut world: ResMut<WorldBodies>,
    mut notices: ResMut<Notices>,
    mut colliders: Query<(Entity, Option<&Name>, &ClothCollider, &GlobalTransform, Option<&ClothLayers>, &mut ColliderBody)>,
) {
    let WorldBodies { bodies, checked } = &mut *world;
    bodies.clear();
    for (entity, name, collider, global, layers, mut body) in &mut colliders {
        let Some(shape) = body.shape.clone().filter(|_| collider.enabled) else {
            body.pose = None;
            continue;
        };
        let (_, rotation, translation) = global.to_scale_rotation_translation();
        let finite = rotation.is_finite() && translation.is_finite();
        checked.clear();
        let (margin, static_friction, dynamic_friction) = collider.checked(checked);
        if !finite {
            checked.clamped.push("transform".into());
        }
        notices.clamped(entity, name, "collider", &checked.clamped);
        let to = if finite { Some(Isometry3d::new(translation, rotation.normalize())) } else { body.pose };
        let Some(to) = to else { continue };
        let from = body.pose.filter(|from| !jumped(from, &to, body.reach)).unwrap_or(to);
        body.pose = Some(to);
        let layers = layers.copied().unwrap_or_default();
        bodies.push(WorldBody { entity, shape, from, to, layers, margin, static_friction, dynamic_friction });
    }
    bodies.sort_unstable_by_key(|body| body.entity);
}

/// A body that jumps further than cloth teleports sweeps nothing on its way.
fn jumped(from: &Isometry3d, to: &Isometry3d, reach: f32) -> bool {
    let limit = if reach.is_finite() { (3.0 * reach).max(2.0) } else { f32::INFINITY };
    !(from.translation.distance(to.translation) <= limit)
}
