//! Writes glTF binary files: just what the scenes of this project need.
#![allow(dead_code, reason = "each program uses a part")]

pub mod clip;
pub mod skinned;

use glam::{Quat, Vec3};
use serde_json::{Value, json};

/// A glTF scene under construction.
#[derive(Default)]
pub struct Glb {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    meshes: Vec<Value>,
    materials: Vec<Value>,
    nodes: Vec<Value>,
    /// Nodes that hang below another one.
    children: Vec<usize>,
    skins: Vec<Value>,
    channels: Vec<Value>,
    samplers: Vec<Value>,
    /// Animations with names of their own.
    clips: Vec<Value>,
}

/// A triangle mesh to write.
#[derive(Default)]
pub struct Surface {
    /// Positions [m].
    pub positions: Vec<Vec3>,
    /// Texture coordinates, one per vertex, or none.
    pub uvs: Vec<[f32; 2]>,
    /// Triangles.
    pub triangles: Vec<[u32; 3]>,
    /// Float attributes by name, one value per vertex.
    pub attributes: Vec<(&'static str, Vec<f32>)>,
}

impl Surface {
    /// Area-weighted normals.
    pub fn normals(&self) -> Vec<Vec3> {
        let mut normals = vec![Vec3::ZERO; self.positions.len()];
        for t in &self.triangles {
            let [a, b, c] = t.map(|v| self.positions[v as usize]);
            t.iter().for_each(|&v| normals[v as usize] += (b - a).cross(c - a));
        }
        normals.into_iter().map(|n| n.normalize_or(Vec3::Y)).collect()
    }
}

impl Glb {
    /// A dull surface of one colour (linear RGB).
    pub fn material(&mut self, color: [f32; 3], double_sided: bool) -> usize {
        let [r, g, b] = color;
        self.materials.push(json!({
            "pbrMetallicRoughness": { "baseColorFactor": [r, g, b, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.8 },
            "doubleSided": double_sided,
        }));
        self.materials.len() - 1
    }

    /// A dull or shiny surface of one colour (linear RGB), with a name.
    pub fn named_material(&mut self, name: &str, color: [f32; 3], roughness: f32, double_sided: bool) -> usize {
        let material = self.material(color, double_sided);
        self.materials[material]["name"] = name.into();
        self.materials[material]["pbrMetallicRoughness"]["roughnessFactor"] = roughness.into();
        material
    }

    /// A mesh of one primitive.
    pub fn mesh(&mut self, surface: &Surface, material: usize) -> usize {
        let floats = |points: &[Vec3]| -> Vec<f32> { points.iter().flat_map(Vec3::to_array).collect() };
        let mut attributes = serde_json::Map::new();
        let low = surface.positions.iter().copied().fold(Vec3::INFINITY, Vec3::min);
        let high = surface.positions.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
        let at = self.floats(&floats(&surface.positions), "VEC3");
        self.accessors[at]["min"] = json!(low.to_array());
        self.accessors[at]["max"] = json!(high.to_array());
        attributes.insert("POSITION".into(), at.into());
        attributes.insert("NORMAL".into(), self.floats(&floats(&surface.normals()), "VEC3").into());
        if !surface.uvs.is_empty() {
            let uvs: Vec<f32> = surface.uvs.iter().flatten().copied().collect();
            attributes.insert("TEXCOORD_0".into(), self.floats(&uvs, "VEC2").into());
        }
        for (name, values) in &surface.attributes {
            attributes.insert((*name).into(), self.floats(values, "SCALAR").into());
        }
        let indices: Vec<u8> = surface.triangles.iter().flatten().flat_map(|i| i.to_le_bytes()).collect();
        let indices = self.accessor(&indices, 5125, surface.triangles.len() * 3, "SCALAR");
        self.meshes.push(json!({ "primitives": [{ "attributes": attributes, "indices": indices, "material": material }] }));
        self.meshes.len() - 1
    }

    /// A node with a mesh and extras.
    pub fn node(&mut self, name: &str, mesh: usize, at: Vec3, rotation: Quat, extras: Value) -> usize {
        self.nodes.push(json!({
            "name": name, "mesh": mesh, "translation": at.to_array(), "rotation": rotation.to_array(), "extras": extras,
        }));
        self.nodes.len() - 1
    }

    /// Moves a node through positions at times [s], in a straight line between.
    pub fn animate(&mut self, node: usize, times: &[f32], positions: &[Vec3]) {
        let input = self.floats(times, "SCALAR");
        self.accessors[input]["min"] = json!([times.first()]);
        self.accessors[input]["max"] = json!([times.last()]);
        let output: Vec<f32> = positions.iter().flat_map(Vec3::to_array).collect();
        let output = self.floats(&output, "VEC3");
        self.samplers.push(json!({ "input": input, "output": output, "interpolation": "LINEAR" }));
        self.channels.push(json!({ "sampler": self.samplers.len() - 1, "target": { "node": node, "path": "translation" } }));
    }

    fn floats(&mut self, values: &[f32], kind: &str) -> usize {
        let width = match kind {
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            "MAT4" => 16,
            _ => 1,
        };
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor(&bytes, 5126, values.len() / width, kind)
    }

    fn accessor(&mut self, bytes: &[u8], component: u32, count: usize, kind: &str) -> usize {
        while !self.bytes.len().is_multiple_of(4) {
            self.bytes.push(0);
        }
        self.views.push(json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() }));
        self.bytes.extend_from_slice(bytes);
        self.accessors.push(json!({
            "bufferView": self.views.len() - 1, "componentType": component, "count": count, "type": kind,
        }));
        self.accessors.len() - 1
    }

    /// The file, with extras on its scene.
    pub fn finish(mut self, scene_extras: Value) -> Vec<u8> {
        while !self.bytes.len().is_multiple_of(4) {
            self.bytes.push(0);
        }
        let roots: Vec<usize> = (0..self.nodes.len()).filter(|node| !self.children.contains(node)).collect();
        let mut root = json!({
            "asset": { "version": "2.0", "generator": "bevy_drape" },
            "scene": 0,
            "scenes": [{ "name": "Scene", "nodes": roots, "extras": scene_extras }],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "materials": self.materials,
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{ "byteLength": self.bytes.len() }],
        });
        if !self.channels.is_empty() {
            self.clips.push(json!({ "name": "Motion", "channels": self.channels, "samplers": self.samplers }));
        }
        if !self.clips.is_empty() {
            root["animations"] = json!(self.clips);
        }
        if !self.skins.is_empty() {
            root["skins"] = json!(self.skins);
        }
        let mut text = root.to_string().into_bytes();
        while !text.len().is_multiple_of(4) {
            text.push(b' ');
        }
        let mut file = Vec::new();
        let total = 12 + 8 + text.len() + 8 + self.bytes.len();
        for word in [0x4654_6C67, 2, total as u32, text.len() as u32, 0x4E4F_534A] {
            file.extend_from_slice(&u32::to_le_bytes(word));
        }
        file.extend_from_slice(&text);
        for word in [self.bytes.len() as u32, 0x004E_4942] {
            file.extend_from_slice(&u32::to_le_bytes(word));
        }
        file.extend_from_slice(&self.bytes);
        file
    }
}
