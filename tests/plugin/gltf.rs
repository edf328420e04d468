//! A glTF needs no code.

use std::path::PathBuf;

use bevy::gltf::{GltfExtras, GltfPlugin};
use bevy::image::ImagePlugin;
use bevy::mesh::MeshPlugin;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy::world_serialization::{WorldAssetRoot, WorldSerializationPlugin};
use bevy_drape::prelude::*;

use crate::common::*;
use crate::warnings::warnings;

/// A folder of this test's own.
fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("bevy_drape_gltf_{}_{name}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for files");
    folder
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for chunk in bytes.chunks(3) {
        let word = chunk.iter().enumerate().fold(0_u32, |w, (i, &b)| w | u32::from(b) << (16 - 8 * i));
        for i in 0..4 {
            let digit = DIGITS[(word >> (18 - 6 * i) & 63) as usize] as char;
            text.push(if i <= chunk.len() { digit } else { '=' });
        }
    }
    text
}

/// A glTF of one sheet of 5 x 5 vertices in xz; `nodes` are node objects that use mesh 0.
fn write_gltf(path: &std::path::Path, nodes: &[String], scene_extras: &str) {
    let whole = r#"{"attributes": {"POSITION": 0, "NORMAL": 1, "_PIN": 2}, "indices": 3}"#;
    write_gltf_of(path, whole, nodes, scene_extras);
}

/// As [`write_gltf`], with other primitives of the mesh. Accessor 4 is a colour: red is 1 where accessor 2 is, green goes from
/// 0 there to 1 at the other end, blue is 0.5, alpha 0.25. Accessor 5 is its green alone.
fn write_gltf_of(path: &std::path::Path, primitives: &str, nodes: &[String], scene_extras: &str) {
    let mesh = sheet(5);
    let points = vectors(&mesh, Mesh::ATTRIBUTE_POSITION);
    let mut bytes = Vec::new();
    for p in &points {
        bytes.extend(p.to_array().into_iter().flat_map(f32::to_le_bytes));
    }
    for _ in &points {
        bytes.extend([0.0_f32, 1.0, 0.0].into_iter().flat_map(f32::to_le_bytes));
    }
    for p in &points {
        bytes.extend(if p.z < -0.49 { 1.0_f32 } else { 0.0 }.to_le_bytes());
    }
    let indices: Vec<u16> = mesh.indices().expect("indices").iter().map(|i| i as u16).collect();
    let start = bytes.len();
    bytes.extend(indices.iter().flat_map(|i| i.to_le_bytes()));
    let after = bytes.len();
    for p in &points {
        let red = if p.z < -0.49 { 1.0 } else { 0.0 };
        bytes.extend([red, p.z + 0.5, 0.5, 0.25_f32].into_iter().flat_map(f32::to_le_bytes));
    }
    for p in &points {
        bytes.extend((p.z + 0.5).to_le_bytes());
    }
    let list: Vec<String> = (0..nodes.len()).map(|i| i.to_string()).collect();
    let text = format!(
        r#"{{"asset": {{"version": "2.0"}}, "scene": 0,
        "scenes": [{{"nodes": [{nodes_in}], "extras": {scene_extras}}}],
        "nodes": [{nodes}],
        "meshes": [{{"primitives": [{primitives}]}}],
        "accessors": [
            {{"bufferView": 0, "componentType": 5126, "count": 25, "type": "VEC3", "min": [-0.5, 0, -0.5], "max": [0.5, 0, 0.5]}},
            {{"bufferView": 1, "componentType": 5126, "count": 25, "type": "VEC3"}},
            {{"bufferView": 2, "componentType": 5126, "count": 25, "type": "SCALAR"}},
            {{"bufferView": 3, "componentType": 5123, "count": {count}, "type": "SCALAR"}},
            {{"bufferView": 4, "componentType": 5126, "count": 25, "type": "VEC4"}},
            {{"bufferView": 5, "componentType": 5126, "count": 25, "type": "SCALAR"}}],
        "bufferViews": [
            {{"buffer": 0, "byteOffset": 0, "byteLength": 300}},
            {{"buffer": 0, "byteOffset": 300, "byteLength": 300}},
            {{"buffer": 0, "byteOffset": 600, "byteLength": 100}},
            {{"buffer": 0, "byteOffset": {start}, "byteLength": {index_bytes}}},
            {{"buffer": 0, "byteOffset": {after}, "byteLength": 400}},
            {{"buffer": 0, "byteOffset": {single}, "byteLength": 100}}],
        "buffers": [{{"byteLength": {length}, "uri": "data:application/octet-stream;base64,{data}"}}]}}"#,
        nodes_in = list.join(","),
        nodes = nodes.join(","),
        count = indices.len(),
        index_bytes = 2 * indices.len(),
        single = after + 400,
        length = bytes.len(),
        data = base64(&bytes),
    );
    std::fs::write(path, text).expect("a file");
}

fn gltf_app(folder: &std::path::Path) -> App {
    let mut app = App::new();
    let files = AssetPlugin { file_path: folder.display().to_string(), ..default() };
    app.add_plugins((MinimalPlugins, TransformPlugin, files, MeshPlugin, ImagePlugin::default()));
    let gltf = bevy_drape::gltf::cloth_attributes(GltfPlugin::default());
    app.add_plugins((WorldSerializationPlugin, gltf, ClothPlugin::default()));
    app.init_asset::<AnimationClip>();
    app.insert_resource(TimeUpdateStrategy::ManualDuration(core::time::Duration::from_secs_f32(FRAME)));
    app.finish();
    app.cleanup();
    app.update();
    app
}

fn load(app: &mut App, file: &str) {
    let scene = app.world().resource::<AssetServer>().load(format!("{file}#Scene0"));
    app.world_mut().spawn(WorldAssetRoot(scene));
    for _ in 0..400 {
        app.update();
        if app.world_mut().query::<&GltfExtras>().iter(app.world()).next().is_some() {
            return;
        }
        std::thread::sleep(core::time::Duration::from_millis(5));
    }
    panic!("{file} did not load");
}

/// The primitive of the node of that name.
fn primitive(app: &mut App, node: &str) -> Entity {
    let mut nodes = app.world_mut().query::<(&Name, &Children)>();
    let children: Vec<Entity> =
        nodes.iter(app.world()).filter(|(n, _)| n.as_str() == node).flat_map(|(_, c)| c.iter()).collect();
    let with_mesh = children.into_iter().find(|c| app.world().get::<Mesh3d>(*c).is_some());
    with_mesh.unwrap_or_else(|| panic!("no mesh under {node}"))
}

fn node(name: &str, extras: &str) -> String {
    format!(r#"{{"name": "{name}", "mesh": 0, "extras": {extras}}}"#)
}

#[test]
fn a_curtain_and_its_weather_come_out_of_the_file() {
    let folder = folder("curtain");
    std::fs::write(folder.join("heavy.cloth.ron"), "(density: 0.9, bend_stiffness: 1e-3)").expect("a file");
    write_gltf(
        &folder.join("room.gltf"),
        &[
            node("Curtain", r#"{"cloth": {"material": "silk", "pin": "_PIN", "substep_rate": 600}, "other_tool": 7}"#),
            node(
                "Rug",
                r#"{"cloth": {"material": "heavy.cloth.ron", "pin": [0, 4], "thickness": 0.02}, "collision_filters": [0, 3]}"#,
            ),
            // Beside the others, or it would lie on them.
            r#"{"name": "Free", "mesh": 0, "translation": [5, 0, 0], "extras": {"cloth": true}}"#.into(),
            node("Ball", r#"{"collider": {"shape": "cuboid", "friction": 0.25}, "collision_memberships": 3.0}"#),
            r#"{"name": "Floor", "translation": [0, -5, 0], "extras": {"collider": "plane"}}"#.into(),
        ],
        r#"{"gravity": [0, -1.62, 0], "wind": [1, 0, 2]}"#,
    );
    let mut app = gltf_app(&folder);
    load(&mut app, "room.gltf");
    for _ in 0..60 {
        app.update();
        std::thread::sleep(core::time::Duration::from_millis(2));
    }
    let [curtain, rug, free, ball] = ["Curtain", "Rug", "Free", "Ball"].map(|n| primitive(&mut app, n));
    assert_eq!(app.world().resource::<ClothGravity>().0, Vec3::new(0.0, -1.62, 0.0));
    assert_eq!(app.world().resource::<ClothGlobalWind>().velocity, Vec3::new(1.0, 0.0, 2.0));
    let layers = |e| app.world().get::<ClothCollisionLayers>(e).copied();
    assert_eq!(layers(rug), Some(ClothCollisionLayers::new(1, 0b1001)));
    assert_eq!(layers(ball), Some(ClothCollisionLayers::new(0b1000, u32::MAX)));
    assert_eq!(layers(curtain), None);
    let material = |e| app.world().get::<ClothMaterial>(e).expect("a material");
    assert_eq!(*material(curtain), ClothMaterial::SILK);
    assert_eq!(*material(rug), ClothMaterial { density: 0.9, bend_stiffness: 1.0e-3, thickness: 0.02, ..default() });
    assert_eq!(app.world().get::<ClothSolver>(curtain).expect("a solver").substep_rate, 600.0);
    for (cloth, pinned) in [(curtain, 5), (rug, 2), (free, 0)] {
        assert_eq!(status(&app, cloth), ClothStatus::Active, "{:?}", app.world().get::<ClothError>(cloth));
        assert_eq!(report(&app, cloth).pinned, pinned);
        assert_eq!(report(&app, cloth).bodies, 1, "the floor; the box has no height");
    }
    assert_eq!(app.world().get::<ClothCollider>(ball).expect("a collider").static_friction, 0.25);
    assert!(lowest(&world_positions(&app, free)) < lowest(&world_positions(&app, curtain)));
    std::fs::remove_dir_all(&folder).expect("a folder to remove");
}

#[test]
fn what_an_app_or_the_cloth_that_a_clone_is_of_has_set_stays() {
    let folder = folder("own");
    write_gltf(&folder.join("room.gltf"), &[node("Curtain", r#"{"cloth": {"pin": "_PIN", "substep_rate": 600}}"#)], "{}");
    let mut app = gltf_app(&folder);
    app.add_observer(
        |_: On<bevy::world_serialization::WorldInstanceReady>, mut commands: Commands, meshes: Query<Entity, With<Mesh3d>>| {
            for mesh in &meshes {
                commands.entity(mesh).insert((ClothPins::vertices([0]), ClothMaterial::SILK));
            }
        },
    );
    load(&mut app, "room.gltf");
    for _ in 0..60 {
        app.update();
        std::thread::sleep(core::time::Duration::from_millis(2));
    }
    let curtain = primitive(&mut app, "Curtain");
    let is_own = |app: &App, cloth: Entity| {
        let rate = app.world().get::<ClothSolver>(cloth).expect("a solver").substep_rate;
        (report(app, cloth).pinned, app.world().get::<ClothMaterial>(cloth) == Some(&ClothMaterial::SILK), rate)
    };
    assert_eq!(is_own(&app, curtain), (1, true, 600.0));
    let parent = app.world().get::<ChildOf>(curtain).expect("a node").parent();
    let clone = app.world_mut().entity_mut(parent).clone_and_spawn_with_opt_out(|builder| {
        builder.linked_cloning(true);
    });
    run(&mut app, 10);
    let clone = app.world().get::<Children>(clone).expect("a clone of the primitive")[0];
    assert_eq!(is_own(&app, clone), (1, true, 600.0));
    std::fs::remove_dir_all(&folder).expect("a folder to remove");
}

#[test]
fn a_wrong_key_is_one_warning_with_file_node_and_key_and_the_rest_works() {
    let folder = folder("wrong");
    write_gltf(
        &folder.join("wrong.gltf"),
        &[
            node("Curtain", r#"{"cloth": {"stifness": 3, "layer": "top", "pin": [0, 1]}}"#),
            node("Ball", r#"{"collider": "donut"}"#),
            r#"{"name": "Empty", "extras": {"cloth": true}}"#.into(),
        ],
        r#"{"wind": 3}"#,
    );
    let lines = warnings(gltf_app(&folder), |app| {
        load(app, "wrong.gltf");
        run(app, 20);
        let curtain = primitive(app, "Curtain");
        assert_eq!(status(app, curtain), ClothStatus::Active);
        assert_eq!(report(app, curtain).pinned, 2);
    });
    for words in [
        ["wrong.gltf", "`Curtain`", "`cloth.stifness`"],
        ["wrong.gltf", "`Curtain`", "`cloth.layer`"],
        ["wrong.gltf", "`Ball`", "`collider`"],
        ["wrong.gltf", "`Empty`", "`cloth`"],
        ["wrong.gltf", "the scene", "`wind`"],
    ] {
        let count = lines.iter().filter(|line| words.iter().all(|word| line.contains(word))).count();
        assert_eq!(count, 1, "{words:?} in {lines:#?}");
    }
    assert_eq!(lines.len(), 5, "{lines:#?}");
    std::fs::remove_dir_all(&folder).expect("a folder to remove");
}

#[test]
fn pins_by_index_over_primitives_without_normals_and_primitives_that_cannot_be_joined_are_told_of() {
    let folder = folder("pieces");
    let (smooth, bare) =
        (r#"{"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 3}"#, r#"{"attributes": {"POSITION": 0}, "indices": 3}"#);
    let told = |name: &str, primitives: &str, extras: &str| {
        write_gltf_of(&folder.join(name), primitives, &[node("Curtain", extras)], "{}");
        warnings(gltf_app(&folder), |app| {
            load(app, name);
            run(app, 20);
        })
    };
    let pins = r#"{"cloth": {"pin": [0, 4]}}"#;
    assert_eq!(told("smooth.gltf", smooth, pins), Vec::<String>::new());
    assert_eq!(told("free.gltf", bare, r#"{"cloth": true}"#), Vec::<String>::new());
    assert_eq!(told("bare.gltf", bare, pins), Vec::<String>::new());
    let lines = told("several.gltf", &format!("{smooth}, {bare}"), pins);
    assert_eq!(lines.len(), 1, "{lines:#?}");
    assert!(
        ["several.gltf", "`Curtain`", "`cloth.pin`", "no normals"].iter().all(|word| lines[0].contains(word)),
        "{lines:#?}"
    );
    assert_eq!(told("two.gltf", &format!("{smooth}, {smooth}"), pins), Vec::<String>::new());
    let strip = smooth.replace("\"indices\": 3", "\"indices\": 3, \"mode\": 5");
    let lines = told("strip.gltf", &format!("{smooth}, {strip}"), pins);
    assert_eq!(lines.len(), 1, "{lines:#?}");
    let words = ["strip.gltf", "`Curtain`", "2 primitives", "TriangleStrip"];
    assert!(words.iter().all(|word| lines[0].contains(word)), "{lines:#?}");
    std::fs::remove_dir_all(&folder).expect("a folder to remove");
}

#[test]
fn pins_by_index_hold_the_vertices_of_the_file_with_and_without_normals() {
    let folder = folder("numbered");
    let held = |name: &str, primitive: &str| {
        write_gltf_of(&folder.join(name), primitive, &[node("Curtain", r#"{"cloth": {"pin": [1, 3]}}"#)], "{}");
        let mut app = gltf_app(&folder);
        load(&mut app, name);
        run(&mut app, 20);
        let cloth = app.world_mut().query_filtered::<Entity, With<Cloth>>().single(app.world()).expect("one cloth");
        assert_eq!(report(&app, cloth).pinned, 2, "{name}");
        let state = app.world().get::<ClothParticles>(cloth).expect("a cloth").state().clone();
        let mut held: Vec<_> = state.positions.iter().filter(|x| x.w == 0.0).map(|x| x.truncate().to_array()).collect();
        held.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
        held
    };
    let smooth = held("smooth.gltf", r#"{"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 3}"#);
    let bare = held("bare.gltf", r#"{"attributes": {"POSITION": 0}, "indices": 3}"#);
    assert_eq!(smooth, bare);
    std::fs::remove_dir_all(&folder).expect("a folder to remove");
}

#[test]
fn a_node_of_several_primitives_is_one_cloth() {
    let folder = folder("primitives");
    let (painted, bare) = (
        r#"{"attributes": {"POSITION": 0, "NORMAL": 1, "_PIN": 2, "COLOR_0": 4}, "indices": 3}"#,
        r#"{"attributes": {"POSITION": 0, "NORMAL": 1, "_PIN": 2}, "indices": 3}"#,
    );
    let extras = r#"{"cloth": {"pin": "_PIN"}}"#;
    write_gltf_of(&folder.join("cape.gltf"), &format!("{painted}, {bare}"), &[node("Cape", extras)], "{}");
    let mut app = gltf_app(&folder);
    load(&mut app, "cape.gltf");
    run(&mut app, 60);
    let world = app.world_mut();
    let cloths: Vec<Entity> = world.query_filtered::<Entity, With<Cloth>>().iter(world).collect();
    let pieces: Vec<(Entity, ClothPiece)> =
        world.query::<(Entity, &ClothPiece)>().iter(world).map(|(entity, piece)| (entity, *piece)).collect();
    assert_eq!((cloths.len(), pieces.len()), (1, 2));
    assert_eq!(
        pieces.iter().map(|(_, piece)| (piece.cloth, piece.first)).collect::<Vec<_>>(),
        [(cloths[0], 0), (cloths[0], 25)]
    );
    // Both lie in the same place, so they are one.
    assert_eq!((particles(&app, cloths[0]).len(), report(&app, cloths[0]).pinned), (25, 5));
    let [a, b] = [0, 1].map(|k| positions(&app, pieces[k].0));
    assert_eq!(a, b);
    assert!(lowest(&a) < -0.2, "it hangs");
    std::fs::remove_dir_all(&folder).expect("a folder to remove");
}

#[test]
fn an_object_is_drawn_in_place_of_its_proxy() {
    let folder = folder("proxy");
    let drawn = |name: &str, proxy: &str| node(name, &format!(r#"{{"cloth.proxy": {proxy}}}"#));
    write_gltf(
        &folder.join("cape.gltf"),
        &[drawn("Drawn", r#""Simulated""#), node("Simulated", r#"{"cloth": {"pin": "_PIN"}}"#)],
        "{}",
    );
    let lines = warnings(gltf_app(&folder), |app| {
        load(app, "cape.gltf");
        run(app, 60);
        let world = app.world_mut();
        let cloth = world.query_filtered::<(Entity, &Name), With<Cloth>>().single(world).expect("one cloth");
        assert_eq!(cloth.1.as_str(), "Simulated", "the node, which has no material");
        let cloth = cloth.0;
        assert_eq!(report(app, cloth).pinned, 5);
        let meshes = app.world().get::<Children>(cloth).expect("primitives").iter();
        assert!(meshes.map(|child| app.world().get::<Mesh3d>(child)).all(|mesh| mesh.is_none()), "it is not drawn");
        let drawn = primitive(app, "Drawn");
        assert_eq!(app.world().get::<ClothRenderMesh>(drawn), Some(&ClothRenderMesh { cloth }));
        assert!(lowest(&world_positions(app, drawn)) < -0.2, "it hangs");
    });
    assert_eq!(lines, Vec::<String>::new());
    write_gltf(
        &folder.join("wrong.gltf"),
        &[
            drawn("Gone", r#""Nobody""#),
            drawn("Bare", r#""Table""#),
            drawn("Number", "3"),
            node("Table", "{}"),
            node("Both", r#"{"cloth": true, "cloth.pin": [0], "cloth.proxy": "Cloth"}"#),
            node("Cloth", r#"{"cloth": true}"#),
        ],
        "{}",
    );
    let lines = warnings(gltf_app(&folder), |app| {
        load(app, "wrong.gltf");
        run(app, 20);
    });
    for words in [
        ["`Gone`", "`Nobody`", "no other object of that name"],
        ["`Bare`", "`Table`", "set `cloth` to true on that object"],
        ["`Number`", "`cloth.proxy`", "the name of the object"],
        ["`Both`", "`cloth.proxy`", "move them there"],
    ] {
        let count = lines.iter().filter(|line| words.iter().all(|word| line.contains(word))).count();
        assert_eq!(count, 1, "{words:?} in {lines:#?}");
    }
    assert_eq!(lines.len(), 4, "{lines:#?}");
    std::fs::remove_dir_all(&folder).expect("a folder to remove");
}

/// A glTF of a character: an armature with the extras above a body of two primitives, a thigh and a calf, and a skirt on the
/// same skin.
fn write_character(path: &std::path::Path, extras: &str) {
    const COUNT: usize = 21 * 16;
    let mut bytes = Vec::new();
    for part in 0..2 {
        for i in 0..COUNT {
            let (ring, turn) = (i / 16, (i % 16) as f32 / 16.0 * core::f32::consts::TAU);
            let x = 0.5 * (part as f32 + ring as f32 / 20.0);
            bytes.extend([x, 0.1 * turn.cos(), 0.1 * turn.sin()].into_iter().flat_map(f32::to_le_bytes));
        }
    }
    for part in 0..2_u16 {
        bytes.extend([part, 0, 0, 0].repeat(COUNT).into_iter().flat_map(u16::to_le_bytes));
    }
    bytes.extend([1.0_f32, 0.0, 0.0, 0.0].repeat(COUNT).into_iter().flat_map(f32::to_le_bytes));
    for matrix in [Mat4::IDENTITY, Mat4::from_translation(Vec3::X * -0.5)] {
        bytes.extend(matrix.to_cols_array().into_iter().flat_map(f32::to_le_bytes));
    }
    let (points, joints, weights) = (12 * COUNT, 8 * COUNT, 16 * COUNT);
    let (first_joint, first_weight) = (2 * points, 2 * points + 2 * joints);
    let first_bind = first_weight + weights;
    let primitive =
        |part: usize| format!(r#"{{"attributes": {{"POSITION": {part}, "JOINTS_0": {}, "WEIGHTS_0": 4}}}}"#, 2 + part);
    let text = format!(
        r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0]}}],
        "nodes": [
            {{"name": "Armature", "children": [1, 2, 3], "extras": {extras}}},
            {{"name": "Body", "mesh": 0, "skin": 0}},
            {{"name": "Skirt", "mesh": 1, "skin": 0, "extras": {{"cloth": true}}}},
            {{"name": "thigh", "children": [4]}},
            {{"name": "calf", "translation": [0.5, 0, 0]}}],
        "skins": [{{"joints": [3, 4], "inverseBindMatrices": 5}}],
        "meshes": [{{"primitives": [{thigh}, {calf}]}}, {{"primitives": [{thigh}]}}],
        "accessors": [
            {{"bufferView": 0, "componentType": 5126, "count": {COUNT}, "type": "VEC3", "min": [0, -0.1, -0.1], "max": [0.5, 0.1, 0.1]}},
            {{"bufferView": 1, "componentType": 5126, "count": {COUNT}, "type": "VEC3", "min": [0.5, -0.1, -0.1], "max": [1, 0.1, 0.1]}},
            {{"bufferView": 2, "componentType": 5123, "count": {COUNT}, "type": "VEC4"}},
            {{"bufferView": 3, "componentType": 5123, "count": {COUNT}, "type": "VEC4"}},
            {{"bufferView": 4, "componentType": 5126, "count": {COUNT}, "type": "VEC4"}},
            {{"bufferView": 5, "componentType": 5126, "count": 2, "type": "MAT4"}}],
        "bufferViews": [
            {{"buffer": 0, "byteOffset": 0, "byteLength": {points}}},
            {{"buffer": 0, "byteOffset": {points}, "byteLength": {points}}},
            {{"buffer": 0, "byteOffset": {first_joint}, "byteLength": {joints}}},
            {{"buffer": 0, "byteOffset": {second_joint}, "byteLength": {joints}}},
            {{"buffer": 0, "byteOffset": {first_weight}, "byteLength": {weights}}},
            {{"buffer": 0, "byteOffset": {first_bind}, "byteLength": 128}}],
        "buffers": [{{"byteLength": {length}, "uri": "data:application/octet-stream;base64,{data}"}}]}}"#,
        thigh = primitive(0),
        calf = primitive(1),
        second_joint = first_joint + joints,
        length = bytes.len(),
        data = base64(&bytes),
    );
    std::fs::write(path, text).expect("a file");
}

#[test]
fn a_skeleton_is_one_set_of_colliders_for_all_skinned_meshes_below_its_node_that_are_no_cloth() {
    let folder = folder("skeleton");
    write_character(&folder.join("leg.gltf"), r#"{"collider": {"shape": "skeleton", "friction": 0.25}}"#);
    let lines = warnings(gltf_app(&folder), |app| {
        load(app, "leg.gltf");
        run(app, 20);
        let mut bodies = app.world_mut().query::<(&ClothBody, Has<Cloth>)>();
        let bodies: Vec<_> = bodies.iter(app.world()).map(|(body, is_cloth)| (*body, is_cloth)).collect();
        assert_eq!(bodies, [(ClothBody::default().with_friction(0.25), false); 2]);
        let mut colliders = app.world_mut().query_filtered::<&Name, With<ClothCollider>>();
        let mut names: Vec<String> = colliders.iter(app.world()).map(ToString::to_string).collect();
        names.sort();
        assert_eq!(names, ["calf collider", "thigh collider"]);
    });
    assert!(!lines.iter().any(|line| line.contains("leg.gltf")), "{lines:#?}");
    std::fs::remove_dir_all(&folder).expect("a folder to remove");
}

/// A node that stands `place` metres aside, so that it meets no other.
fn aside(name: &str, place: u32, extras: &str) -> String {
    format!(r#"{{"name": "{name}", "mesh": 0, "translation": [{}, 0, 0], "extras": {extras}}}"#, 5 * place)
}

#[test]
fn the_attributes_of_cloth_are_registered_each_with_its_format() {
    use bevy::mesh::VertexFormat;
    let plugin = bevy_drape::gltf::cloth_attributes(GltfPlugin::default());
    let plugin = bevy_drape::gltf::pin_attribute(plugin, "_CUFF");
    let mut ids = Vec::new();
    for (seen, format) in [
        ("PIN", VertexFormat::Float32),
        ("CLOTH_MAXDIST", VertexFormat::Float32),
        ("CLOTH_BACKSTOP", VertexFormat::Float32),
        ("CLOTH_DRIVE", VertexFormat::Float32),
        ("CLOTH_PAINT", VertexFormat::Float32x4),
        ("CUFF", VertexFormat::Float32),
    ] {
        let attribute = plugin.custom_vertex_attributes.get(seen).unwrap_or_else(|| panic!("{seen} is not registered"));
        assert_eq!((attribute.name, attribute.format), (format!("_{seen}").as_str(), format));
        ids.push(attribute.id);
    }
    ids.sort_unstable();
    ids.dedup();
    assert_eq!((ids.len(), plugin.custom_vertex_attributes.len()), (6, 6));
}

#[test]
fn distances_from_the_skin_come_out_of_an_attribute_numbers_and_files() {
    let folder = folder("distances");
    let lined = "(material: (density: 0.9), limits: (max_distance: Uniform(0.5), scale: 0.5), drive: (frequency: Uniform(1)))";
    std::fs::write(folder.join("lined.cloth.ron"), lined).expect("a file");
    write_gltf_of(
        &folder.join("skirt.gltf"),
        r#"{"attributes": {"POSITION": 0, "NORMAL": 1, "_CLOTH_MAXDIST": 5}, "indices": 3}"#,
        &[
            aside("Alone", 0, r#"{"cloth": true}"#),
            aside("Range", 1, r#"{"cloth": true, "cloth.max_distance": [0.01, 0.4], "cloth.backstop": true}"#),
            aside("Number", 2, r#"{"cloth": {"max_distance": 0.3}}"#),
            aside("Driven", 3, r#"{"cloth": {"max_distance": false, "drive": 4}}"#),
            aside("Lined", 4, r#"{"cloth": {"material": "lined.cloth.ron", "max_distance": 0.2}}"#),
        ],
        "{}",
    );
    let lines = warnings(gltf_app(&folder), |app| {
        load(app, "skirt.gltf");
        for _ in 0..90 {
            app.update();
            std::thread::sleep(core::time::Duration::from_millis(2));
        }
        let [alone, range, number, driven, lined] =
            ["Alone", "Range", "Number", "Driven", "Lined"].map(|name| primitive(app, name));
        let limits = |entity: Entity| app.world().get::<ClothLimits>(entity).cloned();
        let drive = |entity: Entity| app.world().get::<ClothDrive>(entity).cloned();
        let painted = |low: f32, high: f32| ClothMap::attribute("_CLOTH_MAXDIST", low, high);
        let within = |max_distance: ClothMap| ClothLimits { max_distance, ..default() };
        assert_eq!(limits(alone), Some(within(painted(0.0, 1.0))));
        let backstop = ClothLimits { backstop_distance: ClothMap::Uniform(0.0), ..within(painted(0.01, 0.4)) };
        assert_eq!(limits(range), Some(backstop));
        assert_eq!(limits(number), Some(within(ClothMap::Uniform(0.3))));
        assert_eq!(limits(driven), None);
        assert_eq!(limits(lined), Some(ClothLimits { scale: 0.5, ..within(ClothMap::Uniform(0.2)) }));
        let springs = |frequency: f32| Some(ClothDrive { frequency: ClothMap::Uniform(frequency), ..default() });
        assert_eq!([alone, range, number].map(drive), [None, None, None]);
        assert_eq!([driven, lined].map(drive), [springs(4.0), springs(1.0)]);
        for cloth in [alone, range, number, driven, lined] {
            assert_eq!(status(app, cloth), ClothStatus::Active, "{:?}", app.world().get::<ClothError>(cloth));
        }
        // Where the paint is 0 it is pinned to the skin.
        assert_eq!([alone, range, number].map(|cloth| report(app, cloth).pinned), [5, 0, 0]);
        let [number, driven] = [number, driven].map(|cloth| lowest(&world_positions(app, cloth)));
        assert!((-0.31..-0.25).contains(&number), "it falls as far as it may, to {number} m");
        assert!((-0.05..-0.005).contains(&driven), "springs of 4 Hz hold it at {driven} m");
    });
    assert_eq!(lines, [""; 0], "{lines:#?}");
    std::fs::remove_dir_all(&folder).expect("a folder to remove");
}

#[test]
fn a_skeleton_without_a_skinned_mesh_is_told_of() {
    let folder = folder("skinless");
    write_gltf(&folder.join("rock.gltf"), &[node("Rock", r#"{"collider": "skeleton"}"#)], "{}");
    let lines = warnings(gltf_app(&folder), |app| {
        load(app, "rock.gltf");
        run(app, 20);
    });
    let lines: Vec<_> = lines.iter().filter(|line| line.contains("rock.gltf")).collect();
    let words = ["`Rock`", "`collider`", "skinned mesh"];
    assert!(lines.len() == 1 && words.iter().all(|word| lines[0].contains(word)), "{lines:#?}");
    std::fs::remove_dir_all(&folder).expect("a folder to remove");
}

#[test]
fn one_colour_holds_four_maps() {
    let folder = folder("paint");
    let all = r#"{"cloth": {"pin": "_PIN", "max_distance": [0.01, 0.3], "backstop": [0, 0.1],
        "drive": {"frequency": [0, 4], "damping_ratio": 2}}}"#;
    write_gltf_of(
        &folder.join("coat.gltf"),
        r#"{"attributes": {"POSITION": 0, "NORMAL": 1, "_CLOTH_PAINT": 4}, "indices": 3}"#,
        &[
            aside("Coat", 0, r#"{"cloth": true}"#),
            aside("All", 1, all),
            aside("Named", 2, r#"{"cloth": {"pin": [0], "max_distance": {"map": "_CLOTH_PAINT.b", "high": 0.2}}}"#),
        ],
        "{}",
    );
    let lines = warnings(gltf_app(&folder), |app| {
        load(app, "coat.gltf");
        run(app, 20);
        let [coat, all, named] = ["Coat", "All", "Named"].map(|name| primitive(app, name));
        let limits = |entity: Entity| app.world().get::<ClothLimits>(entity).cloned();
        let channel = |channel: &str, low: f32, high: f32| ClothMap::attribute(format!("_CLOTH_PAINT.{channel}"), low, high);
        assert_eq!(limits(coat), Some(ClothLimits { max_distance: channel("g", 0.0, 1.0), ..default() }));
        let (max_distance, backstop_distance) = (channel("g", 0.01, 0.3), channel("b", 0.0, 0.1));
        assert_eq!(limits(all), Some(ClothLimits { max_distance, backstop_distance, ..default() }));
        assert_eq!(limits(named), Some(ClothLimits { max_distance: channel("b", 0.0, 0.2), ..default() }));
        let drive = ClothDrive { frequency: channel("a", 0.0, 4.0), damping_ratio: 2.0 };
        assert_eq!(app.world().get::<ClothDrive>(all), Some(&drive));
        for cloth in [coat, all] {
            assert_eq!(app.world().get::<ClothPins>(cloth), Some(&ClothPins::attribute("_CLOTH_PAINT.r")));
        }
        assert_eq!([coat, all, named].map(|cloth| report(app, cloth).pinned), [5, 5, 1]);
        for cloth in [coat, all, named] {
            assert_eq!(status(app, cloth), ClothStatus::Active, "{:?}", app.world().get::<ClothError>(cloth));
        }
    });
    assert_eq!(lines, [""; 0], "{lines:#?}");
    std::fs::remove_dir_all(&folder).expect("a folder to remove");
}

#[test]
fn a_wrong_map_is_one_warning_with_the_key_and_the_cure_and_the_rest_works() {
    let folder = folder("wrong_maps");
    write_gltf_of(
        &folder.join("wrong_maps.gltf"),
        r#"{"attributes": {"POSITION": 0, "NORMAL": 1, "_CLOTH_BACKSTOP": 5}, "indices": 3}"#,
        &[
            aside("Far", 0, r#"{"cloth": {"max_distance": "far", "backstop": {"radius": "big"}, "pin": [0]}}"#),
            aside("Idle", 1, r#"{"cloth": {"drive": {"damping_ratio": 1}}}"#),
            aside("Bare", 2, r#"{"cloth": {"drive": [0, 4], "backstop": false}}"#),
        ],
        "{}",
    );
    let lines = warnings(gltf_app(&folder), |app| {
        load(app, "wrong_maps.gltf");
        run(app, 20);
        for name in ["Far", "Idle", "Bare"] {
            let cloth = primitive(app, name);
            assert_eq!(status(app, cloth), ClothStatus::Active, "{name}");
        }
        let far = primitive(app, "Far");
        assert_eq!(report(app, far).pinned, 1);
        let backstop = ClothLimits { backstop_distance: ClothMap::Uniform(0.0), ..default() };
        assert_eq!(app.world().get::<ClothLimits>(far), Some(&backstop));
    });
    for words in [
        ["wrong_maps.gltf", "`Far`", "`cloth.max_distance` is `far`: it must be metres, [low, high]"],
        ["wrong_maps.gltf", "`Far`", "`cloth.backstop.radius` is `big`: it must be a number"],
        ["wrong_maps.gltf", "`Idle`", "`cloth.drive.frequency` is missing: it must be hertz"],
        ["wrong_maps.gltf", "`Idle`", "`cloth.backstop` is missing beside the attribute `_CLOTH_BACKSTOP`"],
        ["does without `frequency`", "`_CLOTH_DRIVE`", "cloth_attributes"],
    ] {
        let count = lines.iter().filter(|line| words.iter().all(|word| line.contains(word))).count();
        assert_eq!(count, 1, "{words:?} in {lines:#?}");
    }
    assert_eq!(lines.len(), 5, "{lines:#?}");
    std::fs::remove_dir_all(&folder).expect("a folder to remove");
}
