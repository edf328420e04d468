//! The mouse as a hand that grabs cloth.

use bevy::prelude::*;
use bevy_drape::prelude::*;

use super::PointerTaken;

/// Farthest that the pointer reaches [m].
pub const REACH: f32 = 20.0;

/// The grip and how far from the camera it is held [m].
#[derive(Resource, Default)]
pub struct Hand(pub Option<(Entity, f32)>);

/// The ray under the pointer.
pub fn ray(window: &Window, camera: (&Camera, &GlobalTransform)) -> Option<Ray3d> {
    camera.0.viewport_to_world(camera.1, window.cursor_position()?).ok()
}

/// Grabs where the pointer meets a cloth, drags at that distance from the camera, and lets go.
#[expect(clippy::too_many_arguments, reason = "a system takes what it reads as arguments")]
pub fn pointer(
    mut commands: Commands,
    mut hand: ResMut<Hand>,
    mut taken: ResMut<PointerTaken>,
    window: Single<&Window>,
    camera: Single<(&Camera, &GlobalTransform)>,
    buttons: Res<ButtonInput<MouseButton>>,
    cloths: ClothQuery,
    mut grips: Query<&mut ClothGrab>,
) {
    let Some(ray) = ray(&window, *camera) else { return };
    if buttons.just_pressed(MouseButton::Left)
        && let Some(hit) = cloths.cast_ray(ray, REACH)
    {
        hand.0 = Some((commands.spawn(ClothGrab::at(&hit)).id(), hit.distance));
    }
    if let Some((grip, distance)) = hand.0 {
        if let Ok(mut grab) = grips.get_mut(grip) {
            grab.target = ray.get_point(distance);
        }
        if !buttons.pressed(MouseButton::Left) {
            commands.entity(grip).despawn();
            hand.0 = None;
        }
    }
    taken.0 = hand.0.is_some();
}
