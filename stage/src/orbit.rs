//! A camera that orbits around a target: drag to turn, right-drag to pan, wheel to zoom.

use bevy::{
    input::mouse::{AccumulatedMouseScroll, MouseScrollUnit},
    prelude::*,
    window::CursorMoved,
};
use bevy_egui::input::EguiWantsInput;

/// Where the camera is, in polar coordinates around what it looks at.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct OrbitCamera {
    /// The point in the middle of the picture.
    pub target: Vec3,
    /// Distance from the target [m].
    pub distance: f32,
    /// Angle around the vertical [rad]; 0 looks along -Z.
    pub yaw: f32,
    /// Height above the horizon [rad].
    pub pitch: f32,
}

/// Set it while the user interface wants the pointer, and the camera will not move.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PointerTaken(pub bool);

/// Turn per pixel of mouse motion [rad].
const TURN: f32 = 0.006;
/// Zoom per notch of the wheel.
const ZOOM: f32 = 0.1;
/// Pixels of a touch pad that count as a notch.
const PIXELS_PER_NOTCH: f32 = 40.0;
/// The camera stays above the floor and does not roll over [rad].
const PITCH: (f32, f32) = (-0.05, 1.5);
/// It also stays out of what it looks at, and in the studio [m].
const DISTANCE: (f32, f32) = (0.15, 20.0);

impl OrbitCamera {
    /// A camera in front of the target and a little above it.
    pub const fn around(target: Vec3, distance: f32) -> Self {
        Self { target, distance, yaw: 0.5, pitch: 0.3 }
    }

    /// The same camera from elsewhere [rad].
    pub const fn from(mut self, yaw: f32, pitch: f32) -> Self {
        self.yaw = yaw;
        self.pitch = pitch;
        self
    }

    /// Where the camera is and where it looks.
    pub fn transform(&self) -> Transform {
        let rotation = Quat::from_rotation_y(self.yaw) * Quat::from_rotation_x(-self.pitch);
        Transform::from_translation(self.target + rotation * Vec3::Z * self.distance).with_rotation(rotation)
    }
}

/// The pointer is taken while it is over a panel.
pub fn yield_to_panels(wants: Option<Res<EguiWantsInput>>, mut taken: ResMut<PointerTaken>) {
    if let Some(wants) = wants {
        taken.0 = wants.wants_any_pointer_input();
    }
}

/// Moves the camera as the pointer says.
pub fn turn(
    cameras: Query<&mut OrbitCamera>,
    buttons: Res<ButtonInput<MouseButton>>,
    mut moves: MessageReader<CursorMoved>,
    scroll: Res<AccumulatedMouseScroll>,
    taken: Res<PointerTaken>,
) {
    let drag: Vec2 = moves.read().filter_map(|event| event.delta).sum();
    let notches = match scroll.unit {
        MouseScrollUnit::Line => scroll.delta.y,
        MouseScrollUnit::Pixel => scroll.delta.y / PIXELS_PER_NOTCH,
    };
    if taken.0 {
        return;
    }
    for mut camera in cameras {
        if drag != Vec2::ZERO && buttons.pressed(MouseButton::Left) {
            camera.yaw -= drag.x * TURN;
            camera.pitch = (camera.pitch + drag.y * TURN).clamp(PITCH.0, PITCH.1);
        }
        if drag != Vec2::ZERO && buttons.pressed(MouseButton::Right) {
            let reach = 0.0015 * camera.distance;
            let shift = camera.transform().rotation * Vec3::new(-drag.x, drag.y, 0.0);
            camera.target += shift * reach;
        }
        if notches != 0.0 {
            let distance = camera.distance * (-notches * ZOOM).exp();
            camera.distance = distance.clamp(DISTANCE.0, DISTANCE.1);
        }
    }
}

/// Puts the camera where its coordinates say.
pub fn place(cameras: Query<(&OrbitCamera, &mut Transform), Changed<OrbitCamera>>) {
    for (camera, mut transform) in cameras {
        *transform = camera.transform();
    }
}
