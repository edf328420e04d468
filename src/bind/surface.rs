//! How the vertices that are drawn hang on the particles that are simulated.

use bevy::math::{Vec2, Vec4};
use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;

use super::Authored;
use crate::solver::surface::TextureAxis;

/// What a mesh wants written.
#[derive(Clone, Debug, Default)]
pub(crate) struct Surface {
    /// Whether it has normals.
    pub normals: bool,
    /// Handedness of each vertex's tangent; empty if it has none.
    pub handedness: Vec<f32>,
    /// How the texture lies on its triangles; empty without tangents.
    pub axes: Vec<TextureAxis>,
}

impl Surface {
    pub(crate) fn new(mesh: &Mesh, authored: &Authored) -> Self {
        let vertices = authored.positions.len();
        let normals = matches!(
            mesh.try_attribute(Mesh::ATTRIBUTE_NORMAL), Ok(VertexAttributeValues::Float32x3(n)) if n.len() == vertices
        );
        let mut surface = Self { normals, ..Self::default() };
        let (Ok(VertexAttributeValues::Float32x4(tangents)), Ok(VertexAttributeValues::Float32x2(uv))) =
            (mesh.try_attribute(Mesh::ATTRIBUTE_TANGENT), mesh.try_attribute(Mesh::ATTRIBUTE_UV_0))
        else {
            return surface;
        };
        if tangents.len() != vertices || uv.len() != vertices {
            return surface;
        }
        surface.handedness = tangents.iter().map(|t| if t[3] < 0.0 { -1.0 } else { 1.0 }).collect();
        let axis = |corners: &[u32; 3]| {
            let uv = corners.map(|v| uv.get(v as usize).map(|&uv| Vec2::from(uv)));
            let [Some(a), Some(b), Some(c)] = uv else { return None };
            TextureAxis::new(*corners, [a, b, c])
        };
        surface.axes = authored.triangles.iter().filter_map(axis).collect();
        surface
    }
}

/// Attributes of the mesh, in its own space.
#[derive(Default)]
pub(crate) struct VertexBuffers {
    pub positions: Vec<[f32; 3]>,
    pub normals: Vec<[f32; 3]>,
    pub tangents: Vec<Vec4>,
}
