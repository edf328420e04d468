//! What is wrong with a mesh beside its shape: numbers, attributes that are missing, too short, or strange.

use bevy::mesh::{Indices, MeshVertexAttribute, VertexAttributeValues, VertexFormat};
use bevy::prelude::*;
use fastrand::Rng;

use super::shapes;
use super::wild::{number, once_in, signed, wild_vector};

/// What pins and maps may be painted in.
pub const PAINT: MeshVertexAttribute = MeshVertexAttribute::new("_PAINT", 0x00c1_07e5, VertexFormat::Float32);

/// A mesh, and what it is called.
pub fn mesh(rng: &mut Rng, wildly: bool) -> (Mesh, String) {
    let (parts, mut name) = if wildly {
        let (parts, name) = shapes::any(rng);
        (parts, name.to_owned())
    } else {
        (shapes::tame(rng), "sheet".to_owned())
    };
    let mut mesh = parts.mesh(rng.bool());
    let count = parts.points.len();
    attributes(rng, &mut mesh, count, !wildly);
    if wildly && once_in(rng, 3) {
        name = format!("{name}, {}", damage(rng, &mut mesh, count));
    }
    (mesh, name)
}

/// Colours, paint, normals and tangents, some of the time.
fn attributes(rng: &mut Rng, mesh: &mut Mesh, count: usize, tame: bool) {
    let value = |rng: &mut Rng| if tame || !once_in(rng, 30) { rng.f32() } else { number(rng) };
    if once_in(rng, 3) {
        let colors: Vec<[f32; 4]> = (0..count).map(|_| [(); 4].map(|()| value(rng))).collect();
        mesh.insert_attribute(Mesh::ATTRIBUTE_COLOR, colors);
    }
    if once_in(rng, 3) {
        let paint: Vec<f32> = (0..count).map(|_| value(rng)).collect();
        mesh.insert_attribute(PAINT, paint);
    }
    if once_in(rng, 3) {
        mesh.insert_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0, 1.0, 0.0]; count]);
        if rng.bool() {
            mesh.insert_attribute(Mesh::ATTRIBUTE_TANGENT, vec![[1.0, 0.0, 0.0, 1.0]; count]);
        }
    }
}

/// Breaks something; says what.
fn damage(rng: &mut Rng, mesh: &mut Mesh, count: usize) -> &'static str {
    match rng.u32(0..9) {
        0 => {
            if let Ok(VertexAttributeValues::Float32x3(points)) = mesh.try_attribute_mut(Mesh::ATTRIBUTE_POSITION)
                && !points.is_empty()
            {
                let which = rng.usize(0..points.len());
                points[which] = wild_vector(rng).to_array();
            }
            "a wild position"
        }
        1 => {
            let short = rng.usize(0..=count);
            mesh.insert_attribute(Mesh::ATTRIBUTE_UV_0, vec![[0.0, 0.0]; short]);
            "few texture coordinates"
        }
        2 => {
            let uvs: Vec<[f32; 2]> = (0..count).map(|_| [number(rng), number(rng)]).collect();
            mesh.insert_attribute(Mesh::ATTRIBUTE_UV_0, uvs);
            "wild texture coordinates"
        }
        3 => {
            mesh.insert_attribute(Mesh::ATTRIBUTE_COLOR, vec![[1.0, 0.5, 0.0, 1.0]; rng.usize(0..2 * count + 2)]);
            "colours of another length"
        }
        4 => {
            mesh.insert_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0, f32::NAN, 1.0]; rng.usize(0..2 * count + 2)]);
            "normals of another length"
        }
        5 => {
            mesh.insert_attribute(Mesh::ATTRIBUTE_TANGENT, vec![[f32::NAN; 4]; rng.usize(0..2 * count + 2)]);
            "tangents of another length"
        }
        6 => {
            if let Some(Indices::U32(indices)) = mesh.indices_mut() {
                indices.truncate(rng.usize(0..=indices.len()));
            }
            "indices that are cut off"
        }
        7 => {
            mesh.remove_attribute(Mesh::ATTRIBUTE_POSITION);
            "no positions"
        }
        _ => {
            mesh.asset_usage = bevy::asset::RenderAssetUsages::RENDER_WORLD;
            "for the render world alone"
        }
    }
}

/// Joints and weights for a skin of `joints` joints; wildly, some that are none.
pub fn skin(rng: &mut Rng, mesh: &mut Mesh, joints: u16, wildly: bool) {
    let count = mesh.count_vertices();
    let joint = |rng: &mut Rng| if wildly && once_in(rng, 20) { rng.u16(..) } else { rng.u16(0..joints.max(1)) };
    let mut indices: Vec<[u16; 4]> = (0..count).map(|_| [(); 4].map(|()| joint(rng))).collect();
    let weight = |rng: &mut Rng| if wildly && once_in(rng, 40) { number(rng) } else { 0.25 + signed(rng, 0.2) };
    let weights: Vec<[f32; 4]> = (0..count).map(|_| [(); 4].map(|()| weight(rng))).collect();
    if wildly && once_in(rng, 8) {
        indices.truncate(rng.usize(0..=count));
    }
    mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, VertexAttributeValues::Uint16x4(indices));
    mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, weights);
}
