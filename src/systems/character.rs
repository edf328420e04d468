//! Prepare: skinned bodies get colliders for their bones, again when their mesh, skin or layers change.
//!
//! ```text
//!   watch     what changed, and what is not there yet
//!   group     bodies with the same joints and settings are fitted together; the first of them owns the colliders
//!   fit       in the bind pose, once for all bodies that are alike
//!   replace   old colliders go, new ones are children of their joints
//!   tune      settings that change are written to the colliders that are there
//! ```

use std::sync::Arc;

use bevy::ecs::entity_disabling::Disabled;
use bevy::ecs::query::QueryData;
use bevy::ecs::relationship::RelationshipTarget;
use bevy::ecs::system::SystemParam;
use bevy::math::{Affine3A, Mat3};
use bevy::mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes};
use bevy::prelude::*;

use crate::bind::{
    BodyCache, BodyError, BodyKey, BodyWait, SkinnedVertices, Sources, collider_of, joints_above, margin_of, uniform_scale,
};
use crate::character::{BoneCollider, FitSettings, SkinnedBody, fit};
use crate::components::checked::Checked;
use crate::components::fitted::{FittedBody, FittedColliders, FittedTo, MadeOf, Stage};
use crate::components::{Cloth, ClothBody, ClothCollider, ClothCollisionLayers, ClothPiece, ClothRenderMesh};
use crate::notices::{Notices, PATIENCE, label};

/// A skinned body, fitted or not.
#[derive(QueryData)]
#[query_data(mutable)]
pub(crate) struct Body {
    entity: Entity,
    name: Option<&'static Name>,
    settings: Ref<'static, ClothBody>,
    mesh: Option<&'static Mesh3d>,
    skin: Option<Ref<'static, SkinnedMesh>>,
    is_cloth: Has<Cloth>,
    is_piece: Has<ClothPiece>,
    is_render_mesh: Has<ClothRenderMesh>,
    layers: Option<&'static ClothCollisionLayers>,
    fitted: Option<&'static mut FittedBody>,
}

impl BodyItem<'_, '_> {
    /// Whether its mesh is that of a cloth, or one that follows a cloth.
    fn shows_cloth(&self) -> bool {
        self.is_cloth || self.is_piece || self.is_render_mesh
    }
}

/// Where meshes and skeletons come from.
#[derive(SystemParam)]
pub(crate) struct Anatomy<'w, 's> {
    meshes: Res<'w, Assets<Mesh>>,
    bind_poses: Option<Res<'w, Assets<SkinnedMeshInverseBindposes>>>,
    sources: Res<'w, Sources>,
    joints: Query<'w, 's, (Option<&'static GlobalTransform>, Option<&'static ChildOf>, Option<&'static Name>), Allow<Disabled>>,
    layers: Query<'w, 's, &'static ClothCollisionLayers, Allow<Disabled>>,
}

/// What keeps a body from being fitted.
enum Obstacle {
    Wait(BodyWait),
    Fail(BodyError),
}

/// Makes colliders of bodies that are new or changed.
pub(crate) fn bodies(
    mut commands: Commands,
    anatomy: Anatomy,
    mut cache: ResMut<BodyCache>,
    mut notices: ResMut<Notices>,
    time: Res<Time<Real>>,
    mut bodies: Query<Body>,
) {
    if !anatomy.sources.modified.is_empty() {
        cache.forget(&anatomy.sources.modified);
    }
    if !watch(&mut commands, &anatomy, &mut notices, time.elapsed_secs_f64(), &mut bodies) {
        return;
    }
    let groups = groups(&anatomy, &bodies);
    for mut body in &mut bodies {
        let is_first = groups.iter().any(|group| group[0] == body.entity);
        if let Some(state) = &mut body.fitted
            && !(is_first || state.members.is_empty())
        {
            (state.members, state.colliders) = (Vec::new(), None);
            replace(&mut commands, body.entity, Vec::new());
        }
    }
    for group in groups {
        let Ok(first) = bodies.get(group[0]) else { continue };
        let is_made =
            |entity: &Entity| bodies.get(*entity).is_ok_and(|body| body.fitted.is_some_and(|state| state.stage == Stage::Made));
        let is_fitted = first.fitted.is_some_and(|state| state.members == group) && group.iter().all(is_made);
        if is_fitted && !first.settings.is_changed() {
            continue;
        }
        let before = first.fitted.map(|state| state.settings);
        let mut checked = Checked::default();
        let settings = first.settings.checked(&mut checked);
        notices.clamped(first.entity, first.name, "body", &checked);
        if is_fitted {
            if before != Some(settings) {
                tune(&mut commands, &first, settings);
            }
            remember(&mut bodies, group[0], settings);
            continue;
        }
        let colliders = fit_together(&anatomy, &mut cache, &bodies, &group);
        let stage = if colliders.is_empty() { Stage::Failed } else { Stage::Made };
        if stage == Stage::Failed {
            tell(&mut notices, first.entity, first.name, &BodyError::NothingFits);
        }
        let own = first.layers.copied();
        let parts = first.skin.as_ref().map_or_else(Vec::new, |skin| anatomy.parts(&skin.joints, &colliders, &settings, own));
        replace(&mut commands, first.entity, parts);
        for &member in &group {
            if let Ok(mut body) = bodies.get_mut(member)
                && let Some(state) = &mut body.fitted
            {
                state.stage = stage;
            }
        }
        if let Ok(mut body) = bodies.get_mut(group[0])
            && let Some(state) = &mut body.fitted
        {
            state.settings = settings;
            state.members = if stage == Stage::Made { group } else { Vec::new() };
            state.colliders = (stage == Stage::Made).then_some(colliders);
        }
    }
}

/// Marks bodies that are to be fitted as new. Whether there are any, or fitted ones that no longer can be or have other
/// settings.
fn watch(commands: &mut Commands, anatomy: &Anatomy, notices: &mut Notices, now: f64, bodies: &mut Query<Body>) -> bool {
    let takes_part = |stage: Stage| matches!(stage, Stage::New | Stage::Made);
    let mut is_stale = false;
    for mut body in bodies {
        let shows_cloth = body.shows_cloth();
        let Some(state) = &mut body.fitted else {
            // A clone has none.
            commands.entity(body.entity).try_insert(FittedBody::default());
            continue;
        };
        let Anatomy { sources, .. } = anatomy;
        let made_of = MadeOf {
            mesh: body.mesh.map(|mesh| sources.authored(&mesh.0).id()),
            skin: body.skin.as_ref().map(|skin| skin.inverse_bindposes.id()),
            is_cloth: shows_cloth,
            layers: body.layers.copied(),
        };
        let arrived = made_of.mesh.is_some_and(|mesh| {
            sources.modified.contains(&mesh) || (state.stage == Stage::Failed && sources.added.contains(&mesh))
        });
        let is_tuned = body.settings.is_changed();
        let is_changed = body.skin.as_ref().is_some_and(DetectChanges::is_changed)
            || (is_tuned && !takes_part(state.stage))
            || body.skin.as_ref().is_some_and(|skin| anatomy.layers_of(skin).ne(state.joint_layers.iter().copied()));
        is_stale |= is_tuned && takes_part(state.stage);
        let is_tried =
            arrived || is_changed || state.made_of != made_of || matches!(state.stage, Stage::New | Stage::Waiting { .. });
        if !is_tried {
            continue;
        }
        state.made_of = made_of;
        state.joint_layers.clear();
        state.joint_layers.extend(body.skin.iter().flat_map(|skin| anatomy.layers_of(skin)));
        let next = match anatomy.obstacle(body.mesh, body.skin.as_deref(), shows_cloth) {
            None => Stage::New,
            Some(Obstacle::Wait(wait)) => {
                let since = if let Stage::Waiting { since } = state.stage { since } else { now };
                if now - since > PATIENCE && notices.first(body.entity, wait.cure()) {
                    warn!("body {} still waits for its colliders: {}", label(body.entity, body.name), wait.cure());
                }
                Stage::Waiting { since }
            }
            Some(Obstacle::Fail(error)) => {
                tell(notices, body.entity, body.name, &error);
                Stage::Failed
            }
        };
        is_stale |= takes_part(state.stage) || takes_part(next);
        state.stage = next;
    }
    is_stale
}

/// One warning for one cause.
fn tell(notices: &mut Notices, entity: Entity, name: Option<&Name>, error: &BodyError) {
    if notices.first(entity, error.kind()) {
        warn!("body {} gets no colliders: {error}", label(entity, name));
    }
}

/// Bodies that are fitted together, in the order of entities.
fn groups(anatomy: &Anatomy, bodies: &Query<Body>) -> Vec<Vec<Entity>> {
    let takes_part = |state: &FittedBody| matches!(state.stage, Stage::New | Stage::Made);
    let mut ready: Vec<Entity> =
        bodies.iter().filter(|body| body.fitted.is_some_and(takes_part)).map(|body| body.entity).collect();
    ready.sort_unstable();
    let mut groups: Vec<Vec<Entity>> = Vec::new();
    for entity in ready {
        let Ok(body) = bodies.get(entity) else { continue };
        let is_like = |group: &&mut Vec<Entity>| bodies.get(group[0]).is_ok_and(|first| anatomy.are_alike(&first, &body));
        match groups.iter_mut().find(is_like) {
            Some(group) => group.push(entity),
            None => groups.push(vec![entity]),
        }
    }
    groups
}

/// The colliders of bodies with one skeleton.
fn fit_together(anatomy: &Anatomy, cache: &mut BodyCache, bodies: &Query<Body>, group: &[Entity]) -> Arc<[BoneCollider]> {
    let first = group.first().and_then(|entity| bodies.get(*entity).ok());
    let Some(skin) = first.as_ref().and_then(|body| body.skin.as_deref()) else { return Arc::default() };
    let Some(bind_poses) = anatomy.bind_poses_of(skin) else { return Arc::default() };
    let mut meshes: Vec<AssetId<Mesh>> = Vec::new();
    for &entity in group {
        let mesh = bodies.get(entity).ok().and_then(|body| body.fitted?.made_of.mesh);
        // A clone adds nothing.
        if let Some(mesh) = mesh.filter(|mesh| !meshes.contains(mesh)) {
            meshes.push(mesh);
        }
    }
    let count = skin.joints.len().min(bind_poses.len());
    let joints: Vec<(bool, Option<usize>)> = {
        let parents = anatomy.parents(&skin.joints[..count]);
        skin.joints[..count].iter().zip(parents).map(|(&joint, parent)| (anatomy.joints.contains(joint), parent)).collect()
    };
    let unit = rounded(anatomy.unit(skin, bind_poses).unwrap_or(0.0));
    let key = BodyKey { meshes, bind_poses: skin.inverse_bindposes.id(), joints, unit: unit.to_bits() };
    let BodyKey { meshes, joints, .. } = key.clone();
    cache.get_or_fit(key, || {
        let (mut positions, mut indices, mut weights) = (Vec::new(), Vec::new(), Vec::new());
        let meshes = meshes.iter().filter_map(|mesh| SkinnedVertices::of(anatomy.meshes.get(*mesh)?).ok());
        for vertices in meshes {
            // So that those of one mesh stay beside each other.
            let count = vertices.positions.len().min(vertices.joints.len()).min(vertices.weights.len());
            positions.extend(vertices.positions[..count].iter().map(|&p| Vec3::from(p)));
            indices.extend_from_slice(&vertices.joints[..count]);
            weights.extend_from_slice(&vertices.weights[..count]);
        }
        // What a joint moves that is gone goes to the one above.
        let bind = |(&(is_there, _), bind): (&(bool, Option<usize>), &Mat4)| {
            if is_there { Affine3A::from_mat4(*bind) } else { Affine3A::ZERO }
        };
        let inverse_binds: Vec<Affine3A> = joints.iter().zip(bind_poses.iter()).map(bind).collect();
        let parents: Vec<Option<usize>> = joints.iter().map(|&(_, parent)| parent).collect();
        let body = SkinnedBody {
            positions: &positions,
            joints: &indices,
            weights: &weights,
            inverse_binds: &inverse_binds,
            parents: &parents,
            unit,
        };
        // `margin_of` adds the margin of `ClothBody`, which may change without a fit.
        fit(&body, &FitSettings { margin: 0.0, ..FitSettings::default() })
    })
}

/// To some four digits, so that characters that stand differently share a fit.
fn rounded(unit: f32) -> f32 {
    const DROPPED: u32 = 1 << 10;
    f32::from_bits((unit.to_bits() + DROPPED / 2) & !(DROPPED - 1))
}

impl Anatomy<'_, '_> {
    /// What is missing or wrong. Allocates nothing.
    fn obstacle(&self, mesh: Option<&Mesh3d>, skin: Option<&SkinnedMesh>, is_cloth: bool) -> Option<Obstacle> {
        if is_cloth {
            return Some(Obstacle::Fail(BodyError::Cloth));
        }
        let Some(mesh) = mesh else { return Some(Obstacle::Wait(BodyWait::Mesh)) };
        let Some(skin) = skin else { return Some(Obstacle::Wait(BodyWait::Skin)) };
        let Some(mesh) = self.meshes.get(&self.sources.authored(&mesh.0)) else {
            return Some(Obstacle::Wait(BodyWait::Asset));
        };
        if let Err(error) = SkinnedVertices::of(mesh) {
            return Some(Obstacle::Fail(error));
        }
        let Some(bind_poses) = self.bind_poses_of(skin) else { return Some(Obstacle::Wait(BodyWait::BindPoses)) };
        let lacks_place = |&joint: &Entity| self.joints.get(joint).is_ok_and(|(global, ..)| global.is_none());
        if skin.joints.iter().any(lacks_place) {
            return Some(Obstacle::Wait(BodyWait::Joints));
        }
        let has_size = self.units(skin, bind_poses).next().is_some();
        (!has_size).then_some(Obstacle::Wait(BodyWait::Scale))
    }

    fn bind_poses_of(&self, skin: &SkinnedMesh) -> Option<&[Mat4]> {
        self.bind_poses.as_ref()?.get(&skin.inverse_bindposes).map(|poses| &poses[..])
    }

    /// Metres per unit of the mesh, as each joint that is there has it.
    fn units(&self, skin: &SkinnedMesh, bind_poses: &[Mat4]) -> impl Iterator<Item = f32> {
        skin.joints.iter().zip(bind_poses).filter_map(|(&joint, bind)| {
            let (global, ..) = self.joints.get(joint).ok()?;
            let matrix = global?.affine().matrix3 * Affine3A::from_mat4(*bind).matrix3;
            Some(uniform_scale(&Mat3::from(matrix))).filter(|unit| unit.is_normal())
        })
    }

    /// Metres per unit of the mesh: of joints that an animation scales differently, the one in the middle.
    fn unit(&self, skin: &SkinnedMesh, bind_poses: &[Mat4]) -> Option<f32> {
        let mut units: Vec<f32> = self.units(skin, bind_poses).collect();
        units.sort_unstable_by(f32::total_cmp);
        units.get(units.len() / 2).copied()
    }

    /// The nearest joint above each joint.
    fn parents(&self, joints: &[Entity]) -> Vec<Option<usize>> {
        joints_above(joints, |entity| self.joints.get(entity).ok()?.1.map(ChildOf::parent))
    }

    /// Whether two bodies have one skeleton and the same settings.
    fn are_alike(&self, a: &BodyReadOnlyItem, b: &BodyReadOnlyItem) -> bool {
        let (Some(skin), Some(other)) = (&a.skin, &b.skin) else { return false };
        let same_poses =
            || skin.inverse_bindposes == other.inverse_bindposes || self.bind_poses_of(skin) == self.bind_poses_of(other);
        *a.settings == *b.settings && a.layers == b.layers && skin.joints == other.joints && same_poses()
    }

    /// Layers of each joint of a skin, of those that have some.
    fn layers_of(&self, skin: &SkinnedMesh) -> impl Iterator<Item = Option<ClothCollisionLayers>> {
        skin.joints.iter().map(|joint| self.layers.get(*joint).ok().copied())
    }

    /// Colliders as they are spawned.
    fn parts(
        &self,
        joints: &[Entity],
        colliders: &[BoneCollider],
        settings: &ClothBody,
        layers: Option<ClothCollisionLayers>,
    ) -> Vec<Part> {
        let parents = self.parents(joints);
        let part = |fitted: &BoneCollider| {
            let joint = *joints.get(fitted.joint)?;
            let name = self.joints.get(joint).ok()?.2;
            let name = name.map_or_else(|| format!("joint {} collider", fitted.joint), |name| format!("{name} collider"));
            let (collider, place) = collider_of(fitted, settings);
            let above = std::iter::successors(Some(fitted.joint), |&joint| parents[joint]).take(joints.len());
            let own = above.filter_map(|joint| self.layers.get(joints[joint]).ok().copied()).next();
            Some(Part { joint, name: Name::new(name), collider, place, layers: own.or(layers) })
        };
        colliders.iter().filter_map(part).collect()
    }
}

/// A collider that is to be spawned.
struct Part {
    joint: Entity,
    name: Name,
    collider: ClothCollider,
    place: Transform,
    layers: Option<ClothCollisionLayers>,
}

/// Despawns the colliders of a body and spawns others under their joints, as far as these are still there.
fn replace(commands: &mut Commands, body: Entity, parts: Vec<Part>) {
    commands.queue(move |world: &mut World| {
        despawn_colliders(world, body);
        if !world.get_entity(body).is_ok_and(|body| body.contains::<ClothBody>()) {
            return;
        }
        for Part { joint, name, collider, place, layers } in parts {
            let Some(&global) = world.get::<GlobalTransform>(joint) else { continue };
            // Transforms were propagated before, and what stands at the origin for a frame would sweep through the cloth.
            let bundle = (name, collider, place, global.mul_transform(place), ChildOf(joint), FittedTo(body));
            let mut spawned = world.spawn(bundle);
            if let Some(layers) = layers {
                spawned.insert(layers);
            }
        }
    });
}

/// Remembers the settings that the colliders of a body have.
fn remember(bodies: &mut Query<Body>, entity: Entity, settings: ClothBody) {
    if let Ok(mut body) = bodies.get_mut(entity)
        && let Some(state) = &mut body.fitted
    {
        state.settings = settings;
    }
}

/// Writes settings in range to those colliders of a body that are still under their joints.
fn tune(commands: &mut Commands, body: &BodyReadOnlyItem, settings: ClothBody) {
    let (Some(skin), Some(colliders)) = (&body.skin, body.fitted.and_then(|state| state.colliders.clone())) else { return };
    let (body, joints) = (body.entity, skin.joints.clone());
    commands.queue(move |world: &mut World| {
        let Some(mine) = world.get::<FittedColliders>(body) else { return };
        for entity in mine.iter().collect::<Vec<Entity>>() {
            let joint = world.get::<ChildOf>(entity).map(ChildOf::parent);
            let fitted = colliders.iter().find(|fitted| joint.is_some() && joints.get(fitted.joint).copied() == joint);
            let (Some(fitted), Some(mut collider)) = (fitted, world.get_mut::<ClothCollider>(entity)) else { continue };
            collider.margin = margin_of(fitted, &settings);
            (collider.static_friction, collider.dynamic_friction) = (settings.static_friction, settings.dynamic_friction);
        }
    });
}

/// Despawns the colliders of a body.
fn despawn_colliders(world: &mut World, body: Entity) {
    let Some(colliders) = world.get::<FittedColliders>(body) else { return };
    for collider in colliders.iter().collect::<Vec<Entity>>() {
        // It may be gone with its joint.
        let _ = world.try_despawn(collider);
    }
}
