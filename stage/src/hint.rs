//! The few words in the corner of the window.

use bevy::prelude::*;

/// What the stage itself does with the mouse and the keyboard.
const CONTROLS: &str = "drag: orbit   right drag: pan   wheel: zoom   space: pause";

/// Writes the hint of the example and that of the stage, 12 px from the corner.
pub fn spawn(commands: &mut Commands, hint: &str) {
    let text = if hint.is_empty() { CONTROLS.into() } else { format!("{hint}\n{CONTROLS}") };
    commands.spawn((
        Text::new(text),
        TextFont { font_size: FontSize::Px(13.0), ..default() },
        TextColor(Color::srgba(0.06, 0.06, 0.08, 0.9)),
        Node { position_type: PositionType::Absolute, top: px(12), left: px(12), ..default() },
    ));
}

/// Space stops the time of the simulation and lets it go on.
pub fn pause(keys: Res<ButtonInput<KeyCode>>, mut time: ResMut<Time<Virtual>>) {
    if keys.just_pressed(KeyCode::Space) {
        if time.is_paused() {
            time.unpause();
        } else {
            time.pause();
        }
    }
}
