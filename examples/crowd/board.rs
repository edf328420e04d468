//! What the governor does, in numbers.

use bevy::prelude::*;
use bevy::ui::UiTargetCamera;
use bevy_drape::prelude::*;

use crate::Crowd;

/// Time over which the cost is averaged [s]: numbers that flicker cannot be read.
const AVERAGED: f32 = 0.25;

/// What it is written on.
#[derive(Component)]
pub struct Board;

/// What all cloths cost, and how many are at each level of detail.
fn count<'a>(cloths: impl Iterator<Item = &'a ClothReport>) -> (f32, [u32; 4]) {
    let (mut ms, mut levels) = (0.0, [0; 4]);
    for report in cloths {
        let still = report.detail == ClothDetail::Still;
        let work = report.integrate_ms + report.detect_ms + report.resolve_ms + report.evaluate_ms + report.respond_ms;
        ms += if still { 0.0 } else { work } + report.sync_ms;
        levels[report.detail as usize] += 1;
    }
    (ms, levels)
}

fn text(crowd: u32, budget: Option<&ClothBudget>, ms: f32, [full, half, quarter, still]: [u32; 4]) -> String {
    let budget = budget.map_or("no budget".to_string(), |budget| format!("budget {:.1} ms", budget.ms));
    format!("{crowd} characters\n{budget}\ncost {ms:.1} ms\nfull {full}\nhalf {half}\nquarter {quarter}\nstill {still}")
}

/// Writes the board, in the corner of what every camera shows.
#[expect(clippy::too_many_arguments, reason = "parameters of a system")]
pub fn write(
    mut commands: Commands,
    time: Res<Time>,
    crowd: Option<Res<Crowd>>,
    budget: Option<Res<ClothBudget>>,
    cloths: Query<&ClothReport, With<Cloth>>,
    cameras: Query<Entity, With<Camera3d>>,
    mut boards: Query<&mut Text, With<Board>>,
    mut mean: Local<f32>,
) {
    let Some(crowd) = crowd else { return };
    let (ms, levels) = count(cloths.iter());
    *mean += (ms - *mean) * (time.delta_secs() / AVERAGED).min(1.0);
    let line = text(crowd.wanted, budget.as_deref(), *mean, levels);
    if boards.is_empty() {
        for camera in &cameras {
            let corner = Node {
                position_type: PositionType::Absolute,
                top: px(12),
                right: px(12),
                padding: UiRect::axes(px(10), px(8)),
                ..default()
            };
            let font = TextFont { font_size: FontSize::Px(14.0), ..default() };
            let paper = BackgroundColor(Color::srgba(0.12, 0.12, 0.14, 0.75));
            commands.spawn((corner, paper, UiTargetCamera(camera))).with_child((
                Board,
                Text::new(line.clone()),
                font,
                TextColor(Color::WHITE),
            ));
        }
    }
    for mut text in &mut boards {
        if text.0 != line {
            text.0.clone_from(&line);
        }
    }
}

/// What a run without a window says at its end.
pub fn report(crowd: Res<Crowd>, budget: Option<Res<ClothBudget>>, cloths: Query<&ClothReport, With<Cloth>>) -> String {
    let (ms, levels) = count(cloths.iter());
    text(crowd.wanted, budget.as_deref(), ms, levels).replace('\n', ", ") + "\n"
}
