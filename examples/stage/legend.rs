//! What the colours mean that are drawn with `--debug`.

use bevy::prelude::*;
use bevy::ui::UiTargetCamera;
use bevy_drape::ClothDebug;

/// Writes the legend in the upper right corner of what the camera shows.
pub fn spawn(mut commands: Commands, debug: Res<ClothDebug>, cameras: Query<Entity, With<Camera3d>>) {
    for camera in &cameras {
        let corner = Node {
            position_type: PositionType::Absolute,
            top: px(12),
            right: px(12),
            flex_direction: FlexDirection::Column,
            padding: UiRect::all(px(6)),
            ..default()
        };
        let paper = BackgroundColor(Color::srgba(0.12, 0.12, 0.14, 0.75));
        commands.spawn((corner, paper, UiTargetCamera(camera))).with_children(|lines| {
            for line in debug.legend() {
                let text = format!("{}: {}", line.item, line.label);
                let font = TextFont { font_size: FontSize::Px(12.0), ..default() };
                let row = Node { align_items: AlignItems::Center, column_gap: px(6), ..default() };
                lines.spawn(row).with_children(|row| {
                    row.spawn((Node { width: px(10), height: px(10), ..default() }, BackgroundColor(line.color)));
                    row.spawn((Text::new(text), font, TextColor(Color::WHITE)));
                });
            }
        });
    }
}
