//! Words that stay at a point of the scene.

use bevy::prelude::*;

use super::INK;

/// Words centred below a point of the scene.
#[derive(Component, Clone, Copy)]
pub struct Label(pub Vec3);

/// Width of a label [px].
const WIDTH: f32 = 300.0;

/// Words below a point [m] of the scene, of a size [px].
pub fn label(at: Vec3, words: impl Into<String>, size: f32) -> impl Bundle {
    (
        Label(at),
        Text::new(words),
        TextFont { font_size: FontSize::Px(size), ..default() },
        TextColor(INK),
        TextLayout::justify(Justify::Center),
        Node { position_type: PositionType::Absolute, width: px(WIDTH), ..default() },
    )
}

/// Puts the words where their points are seen.
pub fn place(camera: Single<(&Camera, &GlobalTransform)>, scale: Res<UiScale>, labels: Query<(&Label, &mut Node)>) {
    let (camera, eye) = *camera;
    for (label, mut node) in labels {
        if let Ok(at) = camera.world_to_viewport(eye, label.0) {
            let at = at / scale.0;
            (node.left, node.top) = (px(at.x - WIDTH / 2.0), px(at.y));
        }
    }
}
