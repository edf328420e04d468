//! Pointers over cloth: a backend for Bevy's picking, and cloth that a pointer takes hold of.

use bevy::camera::visibility::RenderLayers;
use bevy::ecs::lifecycle::HookContext;
use bevy::ecs::world::DeferredWorld;
use bevy::picking::backend::ray::{RayId, RayMap};
use bevy::picking::backend::{HitData, PointerHits};
use bevy::picking::pointer::{PointerAction, PointerId, PointerInput, PointerPress};
use bevy::picking::{PickingSettings, PickingSystems};
use bevy::prelude::*;

use crate::components::{Cloth, ClothGrab};
use crate::notices;
use crate::query::ClothQuery;

/// Sends Bevy's pointer events, as `Pointer<Over>`, `Pointer<Click>` and `Pointer<Drag>`, to cloths where they are shown, and
/// lets pointers drag those with [`ClothDraggable`].
///
/// Pointers meet both sides of a cloth where it is drawn, held and interpolated shapes included. [`Pickable`], [`RenderLayers`]
/// and visibility count as for Bevy's meshes. The hit of an event has the point in the world `[m]`, the normal of the triangle,
/// and the [`ClothHit`](crate::ClothHit) itself: `event.hit.extra_as::<ClothHit>()`. The normal faces away from a pointer
/// behind the cloth.
///
/// Bevy's `MeshPickingPlugin` finds cloths, too. Where both are wanted, set `MeshPickingSettings::require_markers`, or each
/// cloth is asked twice and the [`ClothHit`](crate::ClothHit) may be missing.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # fn add(app: &mut App) {
/// app.add_plugins(ClothPickingPlugin).add_observer(|click: On<Pointer<Click>>, mut cloths: Query<&mut ClothParticles>| {
///     if let (Ok(mut cloth), Some(point)) = (cloths.get_mut(click.entity), click.hit.position) {
///         cloth.apply_impulse(point, Vec3::Y * 0.05, 0.3);
///     }
/// });
/// # }
/// ```
///
/// # Panics
/// Without Bevy's `PickingPlugin`.
#[derive(Clone, Copy, Debug, Default)]
pub struct ClothPickingPlugin;

/// Which cloths pointers find.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[reflect(Resource, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothPickingSettings {
    /// Whether only cloths with [`Pickable`] are found; otherwise all are, and cover what is behind them. Default false.
    pub require_markers: bool,
}

/// Lets pointers drag the cloth of its entity: left mouse button, or touch. Needs [`ClothPickingPlugin`].
///
/// Where the pointer is pressed it takes hold with a [`ClothGrab`] of its own and of these settings. The grip keeps its
/// distance in front of the camera. It lets go when the pointer is released or cancelled, and when this component is removed.
/// The cloth keeps the velocity it has then.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
#[component(on_add = needs_plugin)]
pub struct ClothDraggable {
    /// [`ClothGrab::radius`] `[m]`. Default 0.05, range 0 to 10. 0 pulls at one triangle, which shows.
    pub radius: f32,
    /// [`ClothGrab::compliance`] `[m/N]`. Default 0.001, range 0 to 100. Higher values trail behind the pointer.
    pub compliance: f32,
    /// [`ClothGrab::max_force`] `[N]`. Default 20, range 0 to 10,000. Some ten times the weight of the cloth drags it briskly.
    pub max_force: f32,
}

impl Default for ClothDraggable {
    fn default() -> Self {
        let ClothGrab { radius, compliance, max_force, .. } = ClothGrab::default();
        Self { radius, compliance, max_force }
    }
}

fn needs_plugin(world: DeferredWorld<'_>, HookContext { entity, .. }: HookContext) {
    notices::needs_plugin::<ClothDraggable, ClothPickingSettings>(world, entity, "ClothPickingPlugin");
}

/// On the entity of a grip: whose it is.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct HeldByPointer {
    pointer: PointerId,
    camera: Entity,
    /// How far in front of the camera it is held `[m]`.
    depth: f32,
}

impl Plugin for ClothPickingPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<ClothPickingSettings>()
            .add_observer(take)
            .add_systems(PreUpdate, (hits.in_set(PickingSystems::Backend), drag.in_set(PickingSystems::PostHover)));
    }

    fn finish(&self, app: &mut App) {
        assert!(
            app.world().contains_resource::<RayMap>(),
            "ClothPickingPlugin needs Bevy's picking. Add `DefaultPlugins`, or for a headless app \
             `app.add_plugins((PickingPlugin, InteractionPlugin))`."
        );
    }
}

/// Tells which cloths are under each pointer, down to the first that covers what is behind it.
fn hits(
    settings: Res<ClothPickingSettings>,
    rays: Res<RayMap>,
    cameras: Query<(&Camera, Option<&RenderLayers>)>,
    looks: Query<(Option<&ViewVisibility>, Option<&RenderLayers>, Option<&Pickable>), With<Cloth>>,
    cloths: ClothQuery,
    mut hits: MessageWriter<PointerHits>,
) {
    for (id, ray) in rays.iter() {
        let Ok((camera, seen)) = cameras.get(id.camera) else { continue };
        let seen = seen.unwrap_or_default();
        let meets = |cloth: Entity| {
            looks.get(cloth).is_ok_and(|(visible, layers, pickable)| {
                // Without Bevy's visibility, in a headless app, all is visible.
                visible.is_none_or(|visible| visible.get())
                    && seen.intersects(layers.unwrap_or_default())
                    && pickable.map_or(!settings.require_markers, |p| p.is_hoverable || p.should_block_lower)
            })
        };
        let covers = |cloth: Entity| looks.get(cloth).is_ok_and(|(.., pickable)| pickable.is_none_or(|p| p.should_block_lower));
        let mut picks: Vec<(Entity, HitData)> = Vec::new();
        while let Some(hit) =
            cloths.cast_ray_if(*ray, f32::INFINITY, |cloth| meets(cloth) && !picks.iter().any(|&(found, _)| found == cloth))
        {
            let data = HitData::new_with_extra(id.camera, hit.distance, Some(hit.point), Some(hit.normal), hit);
            picks.push((hit.entity, data));
            if covers(hit.entity) {
                break;
            }
        }
        if !picks.is_empty() {
            hits.write(PointerHits::new(id.pointer, picks, camera.order as f32));
        }
    }
}

/// Takes hold of a cloth where a pointer is pressed on it.
fn take(
    press: On<Pointer<Press>>,
    mut commands: Commands,
    rays: Res<RayMap>,
    draggable: Query<&ClothDraggable, With<Cloth>>,
    cameras: Query<&GlobalTransform, With<Camera>>,
    cloths: ClothQuery,
) {
    if press.button != PointerButton::Primary {
        return;
    }
    let (cloth, pointer, camera) = (press.entity, press.pointer_id, press.hit.camera);
    let Ok(&ClothDraggable { radius, compliance, max_force }) = draggable.get(cloth) else { return };
    let (Some(ray), Ok(eye)) = (rays.map.get(&RayId::new(camera, pointer)), cameras.get(camera)) else { return };
    // The hit of the event may be that of another backend, which knows no particles.
    let Some(hit) = cloths.cast_ray_if(*ray, f32::INFINITY, |entity| entity == cloth) else { return };
    commands.spawn((
        ClothGrab { radius, compliance, max_force, ..ClothGrab::at(&hit) },
        HeldByPointer { pointer, camera, depth: depth(eye, hit.point) },
    ));
}

/// Moves what pointers hold, and lets go. Pointer events do not suffice: a pointer may leave the cloth before it is released,
/// and a camera may move while the pointer rests.
#[expect(clippy::too_many_arguments, reason = "a system takes what it reads as arguments")]
fn drag(
    mut commands: Commands,
    settings: Res<PickingSettings>,
    rays: Res<RayMap>,
    mut inputs: MessageReader<PointerInput>,
    pointers: Query<(&PointerId, &PointerPress)>,
    cameras: Query<&GlobalTransform, With<Camera>>,
    cloths: Query<(), (With<Cloth>, With<ClothDraggable>)>,
    mut grips: Query<(Entity, &HeldByPointer, &mut ClothGrab)>,
) {
    let ended: Vec<PointerId> = inputs
        .read()
        .filter(|input| matches!(input.action, PointerAction::Release(PointerButton::Primary) | PointerAction::Cancel))
        .map(|input| input.pointer_id)
        .collect();
    let listens = settings.is_enabled && settings.is_input_enabled;
    for (entity, held, mut grab) in &mut grips {
        let pressed = pointers.iter().any(|(id, press)| *id == held.pointer && press.is_primary_pressed());
        let holds = listens && pressed && !ended.contains(&held.pointer) && cloths.contains(grab.cloth);
        if !holds {
            commands.entity(entity).try_despawn();
            continue;
        }
        // Beside the picture there is no ray, and the grip stays where it is.
        let ray = rays.map.get(&RayId::new(held.camera, held.pointer));
        if let (Some(&ray), Ok(eye)) = (ray, cameras.get(held.camera))
            && let Some(target) = at_depth(ray, eye, held.depth)
        {
            grab.target = target;
        }
    }
}

/// How far in front of a camera a point lies `[m]`.
fn depth(eye: &GlobalTransform, point: Vec3) -> f32 {
    eye.forward().dot(point - eye.translation())
}

/// Where a ray gets as far in front of a camera as that `[m]`.
fn at_depth(ray: Ray3d, eye: &GlobalTransform, wanted: f32) -> Option<Vec3> {
    let along = (wanted - depth(eye, ray.origin)) / eye.forward().dot(*ray.direction);
    (0.0..f32::INFINITY).contains(&along).then(|| ray.get_point(along))
}
