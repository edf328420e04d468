//! Meshes that follow joints: skins, weights, and nodes that hang below others.

use glam::{Mat4, Quat, Vec3};
use serde_json::{Map, Value, json};

use super::Glb;

/// Vertices of a skinned mesh, shared by its primitives.
#[derive(Default, Clone)]
pub struct SkinnedSurface {
    /// Positions [m].
    pub positions: Vec<Vec3>,
    /// Unit normals.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, or none.
    pub uvs: Vec<[f32; 2]>,
    /// Linear colours, or none.
    pub colors: Vec<[f32; 4]>,
    /// Four joints of the skin for each vertex.
    pub joints: Vec<[u8; 4]>,
    /// Their shares; they sum to 1.
    pub weights: Vec<[f32; 4]>,
    /// Float attributes by name, one value per vertex.
    pub maps: Vec<(&'static str, Vec<f32>)>,
    /// Attributes of four floats by name.
    pub paints: Vec<(&'static str, Vec<[f32; 4]>)>,
}

/// Triangles of one material.
pub struct Primitive {
    /// Triangles; they index the vertices of the surface.
    pub triangles: Vec<[u32; 3]>,
    /// Material.
    pub material: usize,
}

impl Glb {
    /// A node without a mesh.
    pub fn joint(&mut self, name: &str, at: Vec3) -> usize {
        self.nodes.push(json!({ "name": name, "translation": at.to_array(), "rotation": Quat::IDENTITY.to_array() }));
        self.nodes.len() - 1
    }

    /// Gives a node extras.
    pub fn describe(&mut self, node: usize, extras: Value) {
        self.nodes[node]["extras"] = extras;
    }

    /// Hangs a node below another one.
    pub fn attach(&mut self, child: usize, parent: usize) {
        let node = &mut self.nodes[parent];
        match node["children"].as_array_mut() {
            Some(children) => children.push(child.into()),
            None => node["children"] = json!([child]),
        }
        self.children.push(child);
    }

    /// A skin over nodes, with the places of the joints in the bind pose.
    pub fn skin(&mut self, joints: &[usize], binds: &[Mat4]) -> usize {
        let inverse: Vec<f32> = binds.iter().flat_map(|bind| bind.inverse().to_cols_array()).collect();
        let inverse = self.floats(&inverse, "MAT4");
        self.skins.push(json!({ "joints": joints, "skeleton": joints[0], "inverseBindMatrices": inverse }));
        self.skins.len() - 1
    }

    /// A mesh of several primitives; each gets the vertices that it uses.
    pub fn skinned_mesh(&mut self, name: &str, surface: &SkinnedSurface, primitives: &[Primitive]) -> usize {
        let written: Vec<Value> = primitives.iter().map(|primitive| self.primitive(surface, primitive)).collect();
        self.meshes.push(json!({ "name": name, "primitives": written }));
        self.meshes.len() - 1
    }

    /// A node with a skinned mesh.
    pub fn skinned_node(&mut self, name: &str, mesh: usize, skin: usize, extras: Value) -> usize {
        self.nodes.push(json!({ "name": name, "mesh": mesh, "skin": skin, "extras": extras }));
        self.nodes.len() - 1
    }

    fn primitive(&mut self, surface: &SkinnedSurface, primitive: &Primitive) -> Value {
        let mut place = vec![u32::MAX; surface.positions.len()];
        let mut used: Vec<usize> = Vec::new();
        for &vertex in primitive.triangles.iter().flatten() {
            let slot = &mut place[vertex as usize];
            if *slot == u32::MAX {
                *slot = used.len() as u32;
                used.push(vertex as usize);
            }
        }
        let mut attributes = Map::new();
        let points: Vec<Vec3> = used.iter().map(|&v| surface.positions[v]).collect();
        let low = points.iter().copied().fold(Vec3::INFINITY, Vec3::min);
        let high = points.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
        let at = self.floats(&flat(points.iter().map(Vec3::to_array)), "VEC3");
        self.accessors[at]["min"] = json!(low.to_array());
        self.accessors[at]["max"] = json!(high.to_array());
        attributes.insert("POSITION".into(), at.into());
        let normals = flat(used.iter().map(|&v| surface.normals[v].to_array()));
        attributes.insert("NORMAL".into(), self.floats(&normals, "VEC3").into());
        if !surface.uvs.is_empty() {
            attributes.insert("TEXCOORD_0".into(), self.floats(&flat(used.iter().map(|&v| surface.uvs[v])), "VEC2").into());
        }
        if !surface.colors.is_empty() {
            attributes.insert("COLOR_0".into(), self.floats(&flat(used.iter().map(|&v| surface.colors[v])), "VEC4").into());
        }
        let joints: Vec<u8> = used.iter().flat_map(|&v| surface.joints[v]).collect();
        attributes.insert("JOINTS_0".into(), self.accessor(&joints, 5121, used.len(), "VEC4").into());
        attributes.insert("WEIGHTS_0".into(), self.floats(&flat(used.iter().map(|&v| surface.weights[v])), "VEC4").into());
        for (name, values) in &surface.maps {
            let values: Vec<f32> = used.iter().map(|&v| values[v]).collect();
            attributes.insert((*name).into(), self.floats(&values, "SCALAR").into());
        }
        for (name, values) in &surface.paints {
            attributes.insert((*name).into(), self.floats(&flat(used.iter().map(|&v| values[v])), "VEC4").into());
        }
        let corners = primitive.triangles.iter().flatten().map(|&v| place[v as usize]);
        let count = primitive.triangles.len() * 3;
        let indices = if used.len() < usize::from(u16::MAX) {
            let bytes: Vec<u8> = corners.flat_map(|i| (i as u16).to_le_bytes()).collect();
            self.accessor(&bytes, 5123, count, "SCALAR")
        } else {
            let bytes: Vec<u8> = corners.flat_map(u32::to_le_bytes).collect();
            self.accessor(&bytes, 5125, count, "SCALAR")
        };
        json!({ "attributes": attributes, "indices": indices, "material": primitive.material })
    }
}

fn flat<const N: usize>(rows: impl Iterator<Item = [f32; N]>) -> Vec<f32> {
    rows.flatten().collect()
}
