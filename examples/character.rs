//! A human in clothes: `assets/character.glb` says what is cloth, how far it may be from the skin, and that the body has
//! colliders.
//!
//! | key | does |
//! |---|---|
//! | 1 to 9, 0 | another clip |
//! | C | other clothes |
//! | S | how far clothes may be from the skin: as authored, half, not at all |
//! | F | holds back what crosses, or shows it |
//! | space | pauses |
//!
//! `cargo run --release --example make_character` makes the file.

use std::time::Duration;

use bevy::gltf::{Gltf, GltfExtras, GltfPlugin};
use bevy::prelude::*;
use bevy_drape::gltf::cloth_attributes;
use bevy_drape::prelude::*;
use clap::{Parser, ValueEnum};
use drape_stage::{FabricLook, OrbitCamera, Stage, StageArgs, fabric};

/// Clips in the order of keys.
const CLIPS: [&str; 10] = ["Idle", "Walk", "Run", "Turn", "Jump", "Fight", "Dance", "Sit", "LieDown", "ArmsThrough"];
/// The keys.
const KEYS: [KeyCode; 10] = [
    KeyCode::Digit1,
    KeyCode::Digit2,
    KeyCode::Digit3,
    KeyCode::Digit4,
    KeyCode::Digit5,
    KeyCode::Digit6,
    KeyCode::Digit7,
    KeyCode::Digit8,
    KeyCode::Digit9,
    KeyCode::Digit0,
];
/// Time in which one clip passes into another.
const FADE: Duration = Duration::from_millis(300);

/// What the character wears.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Resource)]
enum Outfit {
    /// A cape, and a skirt.
    #[default]
    Cape,
    /// A skirt over a petticoat.
    Skirt,
    /// A long dress.
    Dress,
}

impl Outfit {
    /// Names of the nodes of its pieces.
    fn pieces(self) -> &'static [&'static str] {
        match self {
            Self::Cape => &["Cape", "Skirt"],
            Self::Skirt => &["Skirt", "Petticoat"],
            Self::Dress => &["Dress"],
        }
    }

    /// The one after.
    fn next(self) -> Self {
        let all = Self::value_variants();
        let at = all.iter().position(|outfit| *outfit == self).unwrap_or(0);
        all[(at + 1) % all.len()]
    }
}

/// A human in clothes.
#[derive(Parser)]
struct Arguments {
    /// What it wears.
    #[arg(long, value_enum, default_value_t)]
    outfit: Outfit,
    /// What it does: Idle, Walk, Run, Turn, Jump, Fight, Dance, Sit, `LieDown`, `ArmsThrough`.
    #[arg(long, default_value = "Walk", value_parser = clap::builder::PossibleValuesParser::new(CLIPS))]
    clip: String,
    /// Length below which edges of its clothes are not simulated [m].
    #[arg(long, value_name = "LENGTH")]
    decimation: Option<f32>,
    #[command(flatten)]
    stage: StageArgs,
}

/// The file, and the clip that plays.
#[derive(Resource)]
struct Hero {
    file: Handle<Gltf>,
    clip: usize,
}

/// How coarse its clothes are simulated.
#[derive(Resource)]
struct Coarse(Option<ClothDecimation>);

/// A piece of clothing: its node.
#[derive(Component)]
struct Garment;

fn main() -> AppExit {
    let Arguments { outfit, clip, decimation, stage } = Arguments::parse();
    let clip = CLIPS.iter().position(|name| *name == clip).unwrap_or(0);
    let mut app = Stage::from_args("character", stage)
        .camera(OrbitCamera::around(Vec3::new(0.0, 0.9, 0.0), 3.6).from(0.6, 0.1))
        .hint("1 to 0: clips   C: clothes   S: near the skin   F: hold what crosses")
        .plugins(|plugins| plugins.set(cloth_attributes(GltfPlugin::default())))
        .ready_when(|cloths: Query<&ClothStatus, Without<ClothDisabled>>, players: Query<&AnimationPlayer>| {
            !players.is_empty() && !cloths.is_empty() && cloths.iter().all(|status| *status == ClothStatus::Active)
        })
        .report(report)
        .build();
    app.add_plugins(ClothPlugin::default())
        .insert_resource(outfit)
        .insert_resource(Coarse(decimation.map(ClothDecimation::new)))
        .add_systems(Startup, move |mut commands: Commands, assets: Res<AssetServer>| {
            commands.insert_resource(Hero { file: assets.load("character.glb"), clip });
        })
        .add_systems(Update, (spawn, animate, play, keys))
        // Before the file's extras make cloth of all that it has.
        .add_systems(PostUpdate, (dress, wear).chain().before(ClothSystems::Prepare))
        .run()
}

/// Puts the character on the stage once its file is there.
fn spawn(mut commands: Commands, hero: Res<Hero>, files: Res<Assets<Gltf>>, mut is_there: Local<bool>) {
    let Some(file) = files.get(&hero.file).filter(|_| !*is_there) else { return };
    *is_there = true;
    let scene = file.default_scene.clone().unwrap_or_else(|| file.scenes[0].clone());
    commands.spawn((WorldAssetRoot(scene), ClothCharacter));
}

/// Gives the player its clips.
fn animate(
    mut commands: Commands,
    hero: Res<Hero>,
    files: Res<Assets<Gltf>>,
    mut graphs: ResMut<Assets<AnimationGraph>>,
    new: Query<Entity, Added<AnimationPlayer>>,
) {
    let Some(file) = files.get(&hero.file) else { return };
    for entity in &new {
        let clips = CLIPS.map(|name| file.named_animations.get(name).cloned().unwrap_or_default());
        let (graph, _) = AnimationGraph::from_clips(clips);
        commands.entity(entity).insert((AnimationGraphHandle(graphs.add(graph)), AnimationTransitions::new()));
    }
}

/// Plays the clip that is asked for.
fn play(hero: Res<Hero>, players: Query<(&mut AnimationPlayer, &mut AnimationTransitions)>) {
    for (mut player, mut transitions) in players {
        // Nodes of a graph of clips are numbered from 1.
        let clip = AnimationNodeIndex::new(hero.clip + 1);
        if transitions.get_main_animation() != Some(clip) {
            let fade = if transitions.get_main_animation().is_some() { FADE } else { Duration::ZERO };
            let animation = transitions.play(&mut player, clip, fade);
            // To sit down again and again is to stand in an instant.
            if !matches!(CLIPS[hero.clip], "Sit" | "LieDown") {
                animation.repeat();
            }
        }
    }
}

/// Gives every garment its weave, as it comes out of the file.
fn dress(
    mut commands: Commands,
    nodes: Query<(Entity, &Name, &Children), Added<GltfExtras>>,
    mut images: ResMut<Assets<Image>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    for (node, name, pieces) in &nodes {
        let (look, color, repeats) = match name.as_str() {
            "Cape" => (FabricLook::Wool, Color::srgb(0.42, 0.07, 0.09), 5.0),
            "Skirt" => (FabricLook::Gingham(Color::srgb(0.90, 0.88, 0.82)), Color::srgb(0.15, 0.24, 0.48), 18.0),
            "Petticoat" => (FabricLook::Linen, Color::srgb(0.88, 0.87, 0.83), 8.0),
            "Dress" => (FabricLook::Silk, Color::srgb(0.06, 0.30, 0.33), 4.0),
            "Coat" | "Shirt" => (FabricLook::Wool, Color::srgb(0.30, 0.24, 0.18), 5.0),
            _ => continue,
        };
        commands.entity(node).insert(Garment);
        let weave = fabric(&mut images, &mut materials, look, color, repeats);
        pieces.iter().for_each(|piece| {
            commands.entity(piece).insert(MeshMaterial3d(weave.clone()));
        });
    }
}

/// Shows what is worn, and simulates nothing else.
fn wear(
    mut commands: Commands,
    outfit: Res<Outfit>,
    coarse: Res<Coarse>,
    mut garments: Query<(&Name, &Children, &mut Visibility), With<Garment>>,
    new: Query<(), Added<Garment>>,
) {
    if !outfit.is_changed() && new.is_empty() {
        return;
    }
    for (name, pieces, mut visibility) in &mut garments {
        let is_worn = outfit.pieces().contains(&name.as_str());
        *visibility = if is_worn { Visibility::Inherited } else { Visibility::Hidden };
        for piece in pieces {
            if is_worn {
                let mut piece = commands.entity(*piece);
                piece.remove::<ClothDisabled>();
                if let Coarse(Some(decimation)) = *coarse {
                    piece.insert(decimation);
                }
            } else {
                commands.entity(*piece).insert(ClothDisabled);
            }
        }
    }
}

/// What keys do.
fn keys(
    pressed: Res<ButtonInput<KeyCode>>,
    mut hero: ResMut<Hero>,
    mut outfit: ResMut<Outfit>,
    mut cloths: Query<(&mut ClothLimits, &mut ClothSkipFrame)>,
) {
    if let Some(clip) = KEYS.iter().position(|key| pressed.just_pressed(*key)) {
        hero.clip = clip;
    }
    if pressed.just_pressed(KeyCode::KeyC) {
        *outfit = outfit.next();
    }
    for (mut limits, mut skip) in &mut cloths {
        if pressed.just_pressed(KeyCode::KeyS) {
            limits.scale = match limits.scale {
                1.0 => 0.5,
                0.5 => 0.0,
                _ => 1.0,
            };
        }
        if pressed.just_pressed(KeyCode::KeyF) {
            skip.max_held_frames = if skip.max_held_frames > 0 { 0 } else { ClothSkipFrame::default().max_held_frames };
        }
    }
}

fn report(cloths: Query<(&ClothReport, &ChildOf), Without<ClothDisabled>>, names: Query<&Name>) -> String {
    let line = |(report, node): (&ClothReport, &ChildOf)| {
        let name = names.get(node.parent()).map_or("", Name::as_str);
        format!(
            "{name}: worst edge {:.3} of rest, {} crossings, {} restores\n",
            report.worst_edge, report.crossings, report.restores
        )
    };
    cloths.iter().map(line).collect()
}
