//! A crowd in clothes under a budget: a governor takes detail from those that matter least, until all cloths together cost no
//! more than that.
//!
//! | key | does |
//! |---|---|
//! | up, down | a larger or a smaller budget |
//! | G | with the budget, or without |
//! | right, left | more or fewer characters |
//! | space | pauses |

mod board;
mod cast;

use bevy::gltf::{Gltf, GltfPlugin};
use bevy::prelude::*;
use bevy_drape::gltf::cloth_attributes;
use bevy_drape::prelude::*;
use clap::Parser;
use drape_stage::{OrbitCamera, Stage, StageArgs};

/// Times as much or as little that a key makes of the budget.
const STEP: f32 = 1.25;
/// Characters that a key adds or takes away, and the most.
const FEW: u32 = 10;
const MOST: u32 = 400;

/// A crowd in clothes under a budget.
#[derive(Parser)]
struct Arguments {
    /// Number of characters.
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=400))]
    characters: u32,
    /// Time that all cloths together may take in a frame [ms].
    #[arg(long, default_value_t = 4.0, value_parser = budget)]
    budget: f32,
    #[command(flatten)]
    stage: StageArgs,
}

fn budget(text: &str) -> Result<f32, String> {
    let ms: f32 = text.parse().map_err(|_| "not a number".to_string())?;
    if (0.01..=1000.0).contains(&ms) { Ok(ms) } else { Err("must be between 0.01 and 1000".into()) }
}

/// The file that all come out of, and how many are wanted.
#[derive(Resource)]
struct Crowd {
    file: Handle<Gltf>,
    wanted: u32,
    /// Budget that the governor has when it is on [ms].
    ms: f32,
}

fn main() -> AppExit {
    let Arguments { characters, budget, stage } = Arguments::parse();
    let mut app = Stage::from_args("crowd", stage)
        .camera(OrbitCamera::around(Vec3::new(0.0, 0.6, -3.5), 13.5).from(0.3, 0.27))
        .hint("up, down: budget   G: governor   right, left: how many")
        .plugins(|plugins| plugins.set(cloth_attributes(GltfPlugin::default())))
        .ready_when(cast::is_ready)
        .report(board::report)
        .build();
    app.add_plugins(ClothPlugin::default())
        .insert_resource(ClothBudget { ms: budget })
        .add_systems(Startup, move |mut commands: Commands, assets: Res<AssetServer>| {
            commands.insert_resource(Crowd { file: assets.load("character.glb"), wanted: characters, ms: budget });
        })
        .add_systems(Update, (keys, cast::gather, cast::play, board::write).chain())
        // Before the file's extras make cloth of all that it has.
        .add_systems(PostUpdate, cast::dress.before(ClothSystems::Prepare))
        .run()
}

/// What keys do.
fn keys(
    mut commands: Commands,
    pressed: Res<ButtonInput<KeyCode>>,
    mut crowd: ResMut<Crowd>,
    budget: Option<Res<ClothBudget>>,
) {
    let step = |more: KeyCode, less: KeyCode| match (pressed.just_pressed(more), pressed.just_pressed(less)) {
        (true, false) => 1,
        (false, true) => -1,
        _ => 0,
    };
    let larger = step(KeyCode::ArrowUp, KeyCode::ArrowDown);
    let toggles = pressed.just_pressed(KeyCode::KeyG);
    if larger != 0 {
        crowd.ms = (crowd.ms * STEP.powi(larger)).clamp(0.1, 100.0);
    }
    match (budget.is_some(), toggles) {
        (true, true) => commands.remove_resource::<ClothBudget>(),
        (false, true) => commands.insert_resource(ClothBudget { ms: crowd.ms }),
        (true, false) if larger != 0 => commands.insert_resource(ClothBudget { ms: crowd.ms }),
        _ => {}
    }
    match step(KeyCode::ArrowRight, KeyCode::ArrowLeft) {
        0 => {}
        more => crowd.wanted = crowd.wanted.saturating_add_signed(more * FEW as i32).clamp(1, MOST),
    }
}
