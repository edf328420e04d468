//! Who is in the crowd, what each of them wears and does.

use std::collections::HashMap;

use bevy::gltf::{Gltf, GltfExtras};
use bevy::prelude::*;
use bevy_drape::prelude::*;

use crate::Crowd;
use drape_stage::{FabricLook, fabric};

/// Distance between neighbours in a row, and between rows [m].
const APART: Vec2 = Vec2::new(1.5, 1.6);
/// Share of a round that one is ahead of the one before (dimensionless): the golden ratio, so that no two that are near move
/// alike.
const AHEAD: f32 = 0.618_034;
/// What they do, and what they wear: nodes of the file.
const CLIPS: [&str; 5] = ["Walk", "Run", "Idle", "Dance", "Turn"];
const OUTFITS: [&[&str]; 5] = [&["Cape", "Skirt"], &["Skirt"], &["Skirt", "Petticoat"], &["Cape"], &["Cape", "Petticoat"]];
/// Colours of wool and of linen.
const DYES: [Color; 5] = [
    Color::srgb(0.42, 0.07, 0.09),
    Color::srgb(0.13, 0.22, 0.42),
    Color::srgb(0.48, 0.33, 0.10),
    Color::srgb(0.12, 0.30, 0.20),
    Color::srgb(0.33, 0.16, 0.33),
];
const PALE: [Color; 3] = [Color::srgb(0.88, 0.87, 0.83), Color::srgb(0.80, 0.72, 0.60), Color::srgb(0.66, 0.72, 0.76)];

/// One of the crowd, by its number.
#[derive(Component)]
pub struct Member(u32);

/// Adds those that are missing, a few in each frame, and takes away those that are too many.
pub fn gather(mut commands: Commands, crowd: Res<Crowd>, files: Res<Assets<Gltf>>, members: Query<(Entity, &Member)>) {
    let Some(scene) = files.get(&crowd.file).and_then(|file| file.scenes.first()) else { return };
    for (entity, member) in &members {
        if member.0 >= crowd.wanted {
            commands.entity(entity).despawn();
        }
    }
    let there = members.iter().count() as u32;
    for number in there..crowd.wanted.min(there + 10) {
        let facing = Quat::from_rotation_y(0.25 * (number as f32 * 2.4).sin());
        let place = Transform::from_translation(place(number)).with_rotation(facing);
        commands.spawn((WorldAssetRoot(scene.clone()), place, ClothCharacter, Member(number)));
    }
}

/// Rows that grow longer to the back, so that all are seen.
fn place(number: u32) -> Vec3 {
    let row = ((number as f32 * 2.0 + 0.25).sqrt() - 0.5) as u32;
    let first = row * (row + 1) / 2;
    let x = (number - first) as f32 - 0.5 * row as f32;
    let scatter = Vec2::new((number as f32 * 12.9).sin(), (number as f32 * 78.2).sin()) * 0.18;
    Vec3::new(x * APART.x + scatter.x, 0.0, 3.0 - row as f32 * APART.y + scatter.y)
}

/// Whether all are there and in clothes.
pub fn is_ready(
    crowd: Option<Res<Crowd>>,
    members: Query<(), With<Member>>,
    players: Query<(), With<AnimationPlayer>>,
    cloths: Query<&ClothStatus, With<Cloth>>,
) -> bool {
    let wanted = crowd.map_or(u32::MAX, |crowd| crowd.wanted) as usize;
    let all_there = members.iter().count() == wanted && players.iter().count() == wanted;
    all_there && !cloths.is_empty() && cloths.iter().all(|status| *status == ClothStatus::Active)
}

/// Finds the member that an entity belongs to.
fn member_of(entity: Entity, parents: &Query<&ChildOf>, members: &Query<&Member>) -> Option<u32> {
    parents.iter_ancestors(entity).find_map(|above| members.get(above).ok()).map(|member| member.0)
}

/// Sets every newcomer in motion.
pub fn play(
    mut commands: Commands,
    crowd: Res<Crowd>,
    files: Res<Assets<Gltf>>,
    mut graphs: ResMut<Assets<AnimationGraph>>,
    mut graph: Local<Option<(Handle<AnimationGraph>, Vec<AnimationNodeIndex>)>>,
    new: Query<(Entity, &mut AnimationPlayer), Added<AnimationPlayer>>,
    (parents, members): (Query<&ChildOf>, Query<&Member>),
) {
    let Some(file) = files.get(&crowd.file) else { return };
    for (entity, mut player) in new {
        let (graph, nodes) = graph.get_or_insert_with(|| {
            let clips = CLIPS.map(|name| file.named_animations.get(name).cloned().unwrap_or_default());
            let (graph, nodes) = AnimationGraph::from_clips(clips);
            (graphs.add(graph), nodes)
        });
        let number = member_of(entity, &parents, &members).unwrap_or(0);
        player.play(nodes[number as usize % nodes.len()]).repeat().seek_to((number as f32 * AHEAD).fract());
        commands.entity(entity).insert(AnimationGraphHandle(graph.clone()));
    }
}

/// Takes away what a newcomer does not wear, and dyes the rest.
pub fn dress(
    mut commands: Commands,
    nodes: Query<(Entity, &Name, &Children, &GltfExtras), Added<GltfExtras>>,
    (parents, members): (Query<&ChildOf>, Query<&Member>),
    mut images: ResMut<Assets<Image>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut woven: Local<HashMap<(bool, usize), Handle<StandardMaterial>>>,
) {
    for (node, name, pieces, extras) in &nodes {
        let Some(number) = member_of(node, &parents, &members).filter(|_| extras.value.contains("\"cloth\"")) else { continue };
        let number = number as usize;
        if !OUTFITS[number % OUTFITS.len()].contains(&name.as_str()) {
            commands.entity(node).despawn();
            continue;
        }
        let is_cape = name.as_str() == "Cape";
        let is_linen = name.as_str() == "Petticoat";
        // Another one for the cape than for the skirt.
        let dye = (number / OUTFITS.len() + 2 * usize::from(is_cape)) % if is_linen { PALE.len() } else { DYES.len() };
        let weave = woven.entry((is_linen, dye)).or_insert_with(|| {
            let (look, color) = if is_linen { (FabricLook::Linen, PALE[dye]) } else { (FabricLook::Wool, DYES[dye]) };
            fabric(&mut images, &mut materials, look, color, 6.0)
        });
        for piece in pieces {
            commands.entity(*piece).insert(MeshMaterial3d(weave.clone()));
        }
    }
}
