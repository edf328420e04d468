//! Prepare: where every body was and is, in the world.

use bevy::prelude::*;

use super::carriers::Characters;
use crate::bind::{ColliderError, Sources, shape_of};
use crate::components::fitted::{ColliderBody, Stage};
use crate::components::{ClothCollider, ClothColliderDisabled, ClothColliderShape, ClothCollisionLayers, ClothMeshFit};
use crate::notices::{Notices, PATIENCE, label};
use crate::simulation::{WorldBodies, WorldBody, jumped, swept};
use crate::solver::body::shape;
use crate::time::ClothTime;

/// Makes shapes of new colliders, and of those whose data, scale or mesh changed.
pub(crate) fn shapes(
    mut commands: Commands,
    meshes: Res<Assets<Mesh>>,
    sources: Res<Sources>,
    mut notices: ResMut<Notices>,
    time: Res<Time<Real>>,
    mut colliders: Query<(
        Entity,
        Option<&Name>,
        Ref<ClothCollider>,
        &GlobalTransform,
        Option<&Mesh3d>,
        Option<&mut ColliderBody>,
    )>,
) {
    let now = time.elapsed_secs_f64();
    for (entity, name, collider, global, mesh, body) in &mut colliders {
        let Some(mut body) = body else {
            commands.entity(entity).try_insert(ColliderBody::default());
            continue;
        };
        let source = mesh.map(|m| sources.authored(&m.0)).filter(|_| needs_mesh(&collider.shape));
        let mesh_id = source.as_ref().map(Handle::id);
        let arrived = mesh_id.is_some_and(|id| sources.modified.contains(&id) || sources.added.contains(&id));
        let reshaped = collider.is_changed() && body.asked != collider.shape;
        let changed = reshaped || body.mesh != mesh_id || arrived || body.stage == Stage::New;
        if changed || matches!(body.stage, Stage::Waiting { .. }) {
            body.mesh = mesh_id;
            if changed {
                body.asked.clone_from(&collider.shape);
            }
            let (unscaled, stage) = match shape_of(&collider.shape, source.as_ref().and_then(|s| meshes.get(s))) {
                Ok(shape) => (Some(shape), Stage::Made),
                Err(ColliderError::NoMesh) => (None, waiting(body.stage, now)),
                Err(error) => {
                    if notices.first(entity, "shape") {
                        warn!("collider {} pushes nothing: {error}", label(entity, name));
                    }
                    (None, Stage::Failed)
                }
            };
            if let Stage::Waiting { since } = stage
                && now - since > PATIENCE
                && notices.first(entity, "mesh")
            {
                let cure = "give its entity a `Mesh3d`, keep the loader of its asset running, or check the path";
                warn!("collider {} still waits: {}: {cure}", label(entity, name), ColliderError::NoMesh);
            }
            (body.unscaled, body.stage, body.scale) = (unscaled, stage, Vec3::NAN);
        }
        let scale = global.scale();
        if !scale.is_finite() {
            // It keeps the shape it had. The warning about one without a shape is here, about others with their pose.
            if body.shape.is_none() && notices.first(entity, "scale") {
                warn!(
                    "collider {} pushes nothing: the scale of its transform is not finite: set finite numbers",
                    label(entity, name)
                );
            }
        } else if !((scale - body.scale).abs().max_element() <= 1.0e-4 * scale.abs().max_element()) {
            body.scale = scale;
            let scaled = body.unscaled.as_ref().and_then(|unscaled| match shape::scaled(unscaled, scale) {
                Ok(shape) => Some(shape),
                Err(error) => {
                    if notices.first(entity, "scale") {
                        warn!("collider {} pushes nothing: {error}", label(entity, name));
                    }
                    None
                }
            });
            body.make(scaled);
        }
    }
}

/// Waits since `now`, or for as long as it did.
fn waiting(stage: Stage, now: f64) -> Stage {
    if matches!(stage, Stage::Waiting { .. }) { stage } else { Stage::Waiting { since: now } }
}

/// Whether a shape, or a part of it, is fitted to the mesh of the entity. A plane needs none.
fn needs_mesh(shape: &ClothColliderShape) -> bool {
    match shape {
        ClothColliderShape::Mesh(fit) => *fit != ClothMeshFit::HalfSpace,
        ClothColliderShape::Compound { parts } => parts.iter().any(|part| needs_mesh(&part.shape)),
        _ => false,
    }
}

/// Records where every body was in the last simulated frame and is now.
pub(crate) fn poses(
    time: Res<ClothTime>,
    mut world: ResMut<WorldBodies>,
    mut notices: ResMut<Notices>,
    characters: Characters,
    mut colliders: Query<(
        Entity,
        Option<&Name>,
        &ClothCollider,
        Has<ClothColliderDisabled>,
        &GlobalTransform,
        Option<&ClothCollisionLayers>,
        &mut ColliderBody,
    )>,
) {
    let WorldBodies { bodies, checked, .. } = &mut *world;
    bodies.clear();
    let dt = time.delta_secs();
    for (entity, name, collider, disabled, global, layers, mut body) in &mut colliders {
        let Some(shape) = body.shape.clone().filter(|_| !disabled) else {
            body.pose = None;
            continue;
        };
        let (_, rotation, translation) = global.to_scale_rotation_translation();
        let finite = rotation.is_finite() && translation.is_finite();
        checked.clear();
        let (margin, static_friction, dynamic_friction) = collider.checked(checked);
        if !finite {
            checked.refuse("transform");
        }
        notices.clamped(entity, name, "collider", checked);
        let to = if finite { Some(Isometry3d::new(translation, rotation.normalize())) } else { body.pose };
        let Some(to) = to else { continue };
        let from = body.pose.filter(|from| !jumped(from, &to, body.reach, dt)).unwrap_or(to);
        body.pose = Some(to);
        let layers = layers.copied().unwrap_or_default();
        let character = characters.of(entity);
        let swept = swept(&shape, [&from, &to], margin);
        bodies.push(WorldBody {
            entity,
            swept,
            character,
            shape,
            from,
            to,
            layers,
            margin,
            static_friction,
            dynamic_friction,
            rigid: None,
        });
    }
    bodies.sort_unstable_by_key(|body| body.entity);
}

#[cfg(test)]
mod tests {
    use bevy::ecs::system::RunSystemOnce;

    use crate::solver::body::SharedShape;

    use super::*;

    #[test]
    fn a_margin_makes_no_other_shape_and_a_radius_does() {
        let mut world = World::new();
        world.init_resource::<Assets<Mesh>>();
        world.init_resource::<Sources>();
        world.init_resource::<Notices>();
        world.init_resource::<Time<Real>>();
        let collider = world.spawn((ClothCollider::ball(0.5), GlobalTransform::default(), ColliderBody::default())).id();
        let made = |world: &mut World| {
            world.run_system_once(shapes).unwrap();
            world.get::<ColliderBody>(collider).and_then(|body| body.shape.clone()).unwrap()
        };
        let first = made(&mut world);
        world.get_mut::<ClothCollider>(collider).unwrap().margin = 0.1;
        let with_margin = made(&mut world);
        world.get_mut::<ClothCollider>(collider).unwrap().shape = ClothColliderShape::Ball { radius: 0.6 };
        let larger = made(&mut world);
        let same = |a: &SharedShape, b: &SharedShape| std::sync::Arc::ptr_eq(&a.0, &b.0);
        assert!(same(&first, &with_margin) && !same(&first, &larger));
        assert_eq!(larger.as_ball().map(|ball| ball.radius), Some(0.6));
    }
}
