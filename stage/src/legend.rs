//! What the colours mean of the debug drawing.

use bevy::prelude::*;
use bevy::ui::UiTargetCamera;
use bevy_drape::ClothDebug;

/// The legend on what a camera shows.
#[derive(Component)]
pub struct Legend;

/// Writes the legend at the left of what every camera shows, below the hint.
pub fn write(
    mut commands: Commands,
    debug: Res<ClothDebug>,
    cameras: Query<Entity, With<Camera3d>>,
    legends: Query<Entity, With<Legend>>,
) {
    legends.iter().for_each(|legend| commands.entity(legend).despawn());
    let lines = debug.legend();
    for camera in cameras.iter().filter(|_| !lines.is_empty()) {
        let corner = Node {
            position_type: PositionType::Absolute,
            top: px(64),
            left: px(12),
            flex_direction: FlexDirection::Column,
            padding: UiRect::all(px(6)),
            ..default()
        };
        let paper = BackgroundColor(Color::srgba(0.12, 0.12, 0.14, 0.75));
        commands.spawn((Legend, corner, paper, UiTargetCamera(camera))).with_children(|rows| {
            for line in &lines {
                let text = format!("{}: {}", line.item, line.label);
                let font = TextFont { font_size: FontSize::Px(12.0), ..default() };
                let row = Node { align_items: AlignItems::Center, column_gap: px(6), ..default() };
                rows.spawn(row).with_children(|row| {
                    row.spawn((Node { width: px(10), height: px(10), ..default() }, BackgroundColor(line.color)));
                    row.spawn((Text::new(text), font, TextColor(Color::WHITE)));
                });
            }
        });
    }
}
