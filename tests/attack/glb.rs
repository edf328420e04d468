//! glTF files in one piece, before they are changed: a small one with every key, and those of the project.

use bevy::prelude::*;

use super::shapes;

/// Nodes of the small one: every key that the plugin reads.
const NODES: &str = r#"
    {"name": "curtain", "mesh": 0, "extras": {"cloth": {"material": "cotton", "pin": [0, 1, 2], "thickness": 0.002, "substep_rate": 480, "layer": 1}}},
    {"name": "flag", "mesh": 0, "translation": [2, 0, 0], "extras": {"cloth": true, "cloth.pin": "_PIN", "cloth.material": {"density": 0.2, "drag": 1.5}}},
    {"name": "cape", "mesh": 0, "translation": [4, 0, 0], "extras": {"cloth": {"pin": "color.r", "max_distance": [0.0, 0.3], "backstop":
        {"distance": 0.02, "radius": 0.1}, "drive": {"frequency": 4, "damping_ratio": 1, "map": "color.a"}, "self_collision": false}}},
    {"name": "ball", "mesh": 0, "translation": [0, -1, 0], "scale": [0.5, 0.5, 0.5], "extras": {"collider": "ball"}},
    {"name": "hull", "mesh": 0, "translation": [2, -1, 0], "extras": {"collider": {"shape": "convex", "friction": 0.3}}},
    {"name": "floor", "mesh": 0, "translation": [0, -2, 0], "rotation": [0, 0, 0, 1], "extras": {"collider": "trimesh"}},
    {"name": "doll", "mesh": 0, "extras": {"collider": "skeleton"}}"#;

/// The JSON and the data of a small file: a sheet of 5 x 5 vertices, used by all nodes.
pub fn small() -> (Vec<u8>, Vec<u8>) {
    let sheet = shapes::sheet(5, 5, 1.0);
    let count = sheet.points.len();
    let mut data = Vec::new();
    let mut views = Vec::new();
    let mut add = |data: &mut Vec<u8>, bytes: Vec<u8>| {
        views.push(format!(r#"{{"buffer": 0, "byteOffset": {}, "byteLength": {}}}"#, data.len(), bytes.len()));
        data.extend(bytes);
    };
    let bytes = |values: &mut dyn Iterator<Item = f32>| values.flat_map(f32::to_le_bytes).collect::<Vec<u8>>();
    add(&mut data, bytes(&mut sheet.points.iter().flat_map(Vec3::to_array)));
    add(&mut data, bytes(&mut sheet.points.iter().flat_map(|_| [0.0, 1.0, 0.0])));
    add(&mut data, bytes(&mut sheet.points.iter().map(|p| f32::from(u8::from(p.z < -0.49)))));
    add(&mut data, bytes(&mut sheet.points.iter().flat_map(|p| [f32::from(u8::from(p.z < -0.49)), p.z + 0.5, 0.5, 0.25])));
    add(&mut data, sheet.indices.iter().flat_map(|&i| u16::try_from(i).unwrap_or(0).to_le_bytes()).collect());
    let accessor = |view: usize, kind: &str, component: u32, count: usize| {
        format!(
            r#"{{"bufferView": {view}, "componentType": {component}, "count": {count}, "type": "{kind}",
                 "min": [-0.5, 0, -0.5], "max": [0.5, 0, 0.5]}}"#
        )
    };
    let accessors = [
        accessor(0, "VEC3", 5126, count),
        accessor(1, "VEC3", 5126, count),
        accessor(2, "SCALAR", 5126, count),
        accessor(3, "VEC4", 5126, count),
        accessor(4, "SCALAR", 5123, sheet.indices.len()),
    ];
    let json = format!(
        r#"{{"asset": {{"version": "2.0"}}, "scene": 0,
            "scenes": [{{"nodes": [0, 1, 2, 3, 4, 5, 6], "extras": {{"gravity": [0, -9.81, 0], "wind": [1, 0, 2]}}}}],
            "nodes": [{NODES}],
            "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0, "NORMAL": 1, "_PIN": 2, "COLOR_0": 3}}, "indices": 4}}]}}],
            "accessors": [{}], "bufferViews": [{}], "buffers": [{{"byteLength": {}}}]}}"#,
        accessors.join(","),
        views.join(","),
        data.len()
    );
    (json.into_bytes(), data)
}

/// The JSON and the data of a file in one piece; none if it is not one.
pub fn split(file: &[u8]) -> Option<(Vec<u8>, Vec<u8>)> {
    let word = |at: usize| Some(u32::from_le_bytes(file.get(at..at + 4)?.try_into().ok()?) as usize);
    let json = word(12)?;
    let data = word(20 + json)?;
    Some((file.get(20..20 + json)?.to_vec(), file.get(28 + json..28 + json + data)?.to_vec()))
}

/// A file in one piece.
pub fn join(json: &[u8], data: &[u8]) -> Vec<u8> {
    let padded = |bytes: &[u8], with: u8| {
        let mut bytes = bytes.to_vec();
        bytes.resize(bytes.len().next_multiple_of(4), with);
        bytes
    };
    let (json, data) = (padded(json, b' '), padded(data, 0));
    let word = |n: usize| u32::try_from(n).unwrap_or(u32::MAX).to_le_bytes();
    let mut file = b"glTF".to_vec();
    for part in [word(2), word(28 + json.len() + data.len()), word(json.len()), *b"JSON"] {
        file.extend(part);
    }
    file.extend(&json);
    file.extend(word(data.len()));
    file.extend(b"BIN\0");
    file.extend(&data);
    file
}
