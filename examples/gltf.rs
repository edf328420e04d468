//! A scene made outside of Bevy: cloth, pins, colliders and wind are extras in `assets/drape.glb`, and need no code.
//!
//! `cargo run --example make_scene` makes the file.

use bevy::gltf::{GltfAssetLabel, GltfPlugin};
use bevy::prelude::*;
use bevy_drape::gltf::cloth_attributes;
use bevy_drape::prelude::*;
use drape_stage::{FabricLook, OrbitCamera, Stage, fabric};

fn main() -> AppExit {
    Stage::new("gltf")
        .camera(OrbitCamera::around(Vec3::new(0.5, 0.9, 0.0), 5.0).from(0.35, 0.18))
        // The one line for pins and maps that are custom attributes of the mesh.
        .plugins(|plugins| plugins.set(cloth_attributes(GltfPlugin::default())))
        .ready_when(|cloths: Query<(), With<Cloth>>| cloths.iter().len() == 2)
        .report(report)
        .build()
        .add_plugins(ClothPlugin::default())
        .add_systems(Startup, load)
        .add_systems(Update, (play, dress))
        .run()
}

fn load(mut commands: Commands, assets: Res<AssetServer>, mut graphs: ResMut<Assets<AnimationGraph>>) {
    let (graph, _) = AnimationGraph::from_clip(assets.load(GltfAssetLabel::Animation(0).from_asset("drape.glb")));
    commands.insert_resource(Motion(graphs.add(graph)));
    commands.spawn(WorldAssetRoot(assets.load(GltfAssetLabel::Scene(0).from_asset("drape.glb"))));
}

/// The animation of the file.
#[derive(Resource)]
struct Motion(Handle<AnimationGraph>);

/// Plays it for ever.
fn play(mut commands: Commands, motion: Res<Motion>, players: Query<(Entity, &mut AnimationPlayer), Added<AnimationPlayer>>) {
    for (entity, mut player) in players {
        player.play(1.into()).repeat();
        commands.entity(entity).insert(AnimationGraphHandle(motion.0.clone()));
    }
}

/// Gives the cloths of the file a weave.
fn dress(
    mut commands: Commands,
    cloths: Query<(Entity, &ChildOf), Added<Cloth>>,
    names: Query<&Name>,
    mut images: ResMut<Assets<Image>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    for (cloth, parent) in cloths {
        let curtain = names.get(parent.0).is_ok_and(|name| name.as_str() == "Curtain");
        let (look, color, repeats) = if curtain {
            (FabricLook::Linen, Color::srgb(0.86, 0.80, 0.68), 8.0)
        } else {
            (FabricLook::Wool, Color::srgb(0.10, 0.36, 0.38), 5.0)
        };
        commands.entity(cloth).insert(MeshMaterial3d(fabric(&mut images, &mut materials, look, color, repeats)));
    }
}

fn report(cloths: Query<&ClothReport>) -> String {
    cloths.iter().map(|report| format!("worst edge {:.3} of rest, {} pinned\n", report.worst_edge, report.pinned)).collect()
}
