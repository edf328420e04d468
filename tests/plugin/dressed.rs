//! Characters of others, with nothing but extras added to their files, where the files are there.

use bevy::ecs::schedule::SingleThreadedExecutor;
use bevy::mesh::skinning::SkinnedMesh;
use bevy::prelude::*;
use bevy_drape::prelude::*;
use serde_json::{Value, json};

use crate::common::log::Log;
use crate::common::*;
use crate::mannequin::{enter, stage};

/// Where the JSON of a binary glTF begins; its length comes 8 bytes before, that of the file 12.
const JSON: usize = 20;

/// A copy of a file with extras added to nodes by name: a stage for it, and its name there. `extras` is given the positions of
/// the vertices of the parts of a node, one after the other, as the file has them.
fn dressed(file: &str, extras: impl Fn(&str, &[Vec<Vec3>]) -> Option<Value>) -> Option<(App, String)> {
    let bytes = std::fs::read(drape_tests::data("characters")?.join(file)).expect("a file");
    let parsed = gltf::Gltf::from_slice(&bytes).expect("a glTF");
    let (length, rest) = bytes[JSON - 8..].split_at(4);
    let length = u32::from_le_bytes(length.try_into().expect("a length")) as usize;
    let mut json: Value = serde_json::from_slice(&rest[4..4 + length]).expect("JSON");
    for node in parsed.nodes() {
        let parts: Vec<Vec<Vec3>> = node
            .mesh()
            .into_iter()
            .flat_map(|mesh| mesh.primitives())
            .map(|part| {
                let reader = part.reader(|_| parsed.blob.as_deref());
                reader.read_positions().expect("positions").map(Vec3::from).collect()
            })
            .collect();
        if let Some(extras) = extras(node.name().unwrap_or_default(), &parts) {
            json["nodes"][node.index()]["extras"] = extras;
        }
    }
    let mut text = json.to_string();
    text.extend(core::iter::repeat_n(' ', text.len().next_multiple_of(4) - text.len()));
    let mut out = bytes[..8].to_vec();
    out.extend(((bytes.len() - length + text.len()) as u32).to_le_bytes());
    out.extend((text.len() as u32).to_le_bytes());
    out.extend(b"JSON");
    out.extend(text.bytes());
    out.extend(&bytes[JSON + length..]);
    let folder = std::env::temp_dir().join(format!("bevy_drape_dressed_{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    std::fs::write(folder.join(file), out).expect("a file");
    let mut app = stage(&folder, 60.0);
    // The log is that of this thread.
    app.edit_schedule(PostUpdate, |schedule| {
        schedule.set_executor(SingleThreadedExecutor::new());
    });
    Some((app, file.to_owned()))
}

/// The only cloth.
fn only_cloth(app: &mut App) -> Entity {
    let mut cloths = app.world_mut().query_filtered::<Entity, With<Cloth>>();
    cloths.single(app.world()).expect("one cloth")
}

fn named(app: &mut App, name: &str) -> Entity {
    let mut names = app.world_mut().query::<(Entity, &Name)>();
    names.iter(app.world()).find(|(_, of)| of.as_str() == name).map(|(entity, _)| entity).expect("a node")
}

/// The cape of the knight is an unskinned child of his chest, of 56 vertices.
#[test]
fn the_cape_of_a_knight_moves_without_code() {
    let Some((mut app, file)) = dressed("knight.glb", |name, parts| match name {
        "Knight_Cape" => {
            // Metres.
            let top = parts[0].iter().map(|x| x.y).fold(f32::NEG_INFINITY, f32::max);
            let pins: Vec<usize> = (0..parts[0].len()).filter(|&v| parts[0][v].y > top - 0.1).collect();
            Some(json!({"cloth": {"pin": pins, "subdivision": 0.08}}))
        }
        "Rig" => Some(json!({"collider": "skeleton"})),
        _ => None,
    }) else {
        return;
    };
    let log = Log::default();
    let (least, most) = log.listen(|| {
        enter(&mut app, &file, Some("Running_A"), true, 0.0);
        let (cloth, chest) = (only_cloth(&mut app), named(&mut app, "chest"));
        assert_eq!(status(&app, cloth), ClothStatus::Active);
        let (mut least, mut most) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for frame in 0..180 {
            run(&mut app, 1);
            assert!(finite(&app, cloth));
            let chest = app.world().get::<GlobalTransform>(chest).expect("a chest").affine().inverse();
            let hem =
                world_positions(&app, cloth).into_iter().map(|x| chest.transform_point3(x)).min_by(|a, b| a.y.total_cmp(&b.y));
            let hem = hem.expect("a hem");
            if frame >= 60 {
                (least, most) = (least.min(hem), most.max(hem));
            }
        }
        (least, most)
    });
    let lines = log.read();
    assert!(lines.len() <= 1, "{lines:#?}");
    assert!((most - least).max_element() > 0.05, "the hem stays within {} to {} of the chest", least, most);
}

/// The skirt of the witch is two of the three parts of a node, purple and a golden hem, at a scale of 100. The third part is
/// her legs, which stay with the skin.
#[test]
fn the_skirt_and_the_hem_of_a_witch_stay_one_piece_without_code() {
    let Some((mut app, file)) = dressed("witch.glb", |name, parts| match name {
        "Witch_Legs" => {
            // Hundreds of metres: the uppermost 5 cm.
            let top = parts[0].iter().map(|x| x.z).fold(f32::NEG_INFINITY, f32::max);
            let all: Vec<(usize, Vec3)> =
                parts.iter().enumerate().flat_map(|(i, part)| part.iter().map(move |&x| (i, x))).collect();
            let pins: Vec<usize> = (0..all.len()).filter(|&v| all[v].0 == 2 || all[v].1.z > top - 0.0005).collect();
            Some(json!({"cloth": {"pin": pins}}))
        }
        "RootNode" => Some(json!({"collider": "skeleton"})),
        _ => None,
    }) else {
        return;
    };
    let log = Log::default();
    let (gap, moved, pairs) = log.listen(|| {
        enter(&mut app, &file, None, false, 0.0);
        run(&mut app, 3);
        let cloth = only_cloth(&mut app);
        assert_eq!(status(&app, cloth), ClothStatus::Active, "{:?}", report(&app, cloth));
        let mut pieces = app.world_mut().query::<(Entity, &ClothPiece)>();
        let mut pieces: Vec<(u32, Entity)> = pieces.iter(app.world()).map(|(entity, piece)| (piece.first, entity)).collect();
        pieces.sort_unstable();
        assert_eq!(pieces.len(), 3);
        let [skirt, hem] = [pieces[0].1, pieces[1].1];
        assert!(!app.world().entity(skirt).contains::<SkinnedMesh>());
        let start = [world_positions(&app, skirt), world_positions(&app, hem)];
        let near = |a: &Vec3, b: &Vec3| a.distance(*b) < 1.0e-5;
        let pairs: Vec<[usize; 2]> = (0..start[0].len())
            .flat_map(|i| (0..start[1].len()).map(move |k| [i, k]))
            .filter(|&[i, k]| near(&start[0][i], &start[1][k]))
            .collect();
        let leg = named(&mut app, "UpperLeg.L");
        let (mut gap, mut moved) = (0.0f32, 0.0f32);
        for frame in 0..150 {
            let turn = Quat::from_rotation_x(0.02 * (0.1 * frame as f32).cos());
            app.world_mut().get_mut::<Transform>(leg).expect("a leg").rotation *= turn;
            run(&mut app, 1);
            assert!(finite(&app, cloth));
            let now = [world_positions(&app, skirt), world_positions(&app, hem)];
            gap = pairs.iter().map(|&[i, k]| now[0][i].distance(now[1][k])).fold(gap, f32::max);
            moved = now[0].iter().zip(&start[0]).map(|(now, start)| now.distance(*start)).fold(moved, f32::max);
        }
        (gap, moved, pairs.len())
    });
    let lines = log.read();
    assert!(lines.len() <= 1, "{lines:#?}");
    assert!(pairs > 20 && gap <= 1.0e-4 && moved > 0.02, "{pairs} pairs are up to {gap} m apart, moved by {moved} m");
}
