//! Vertices that follow a cloth which is coarser than they are.

use bevy::math::{Affine3A, Vec4};
use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;

use super::VertexBuffers;
use crate::solver::embed::{Embedding, Triangles, cofactors};
use crate::solver::rest::RestShape;

/// Vertices, as far as a mesh has them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Vertices {
    /// `[m]`.
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    /// With the handedness in `w`.
    tangents: Vec<Vec4>,
}

impl Vertices {
    /// Those of a mesh, moved by `place`.
    pub(crate) fn of(mesh: &Mesh, place: &Affine3A) -> Self {
        let vectors = |attribute| match mesh.try_attribute(attribute) {
            Ok(VertexAttributeValues::Float32x3(values)) => values.iter().map(|&v| Vec3::from(v)).collect(),
            _ => Vec::new(),
        };
        let positions: Vec<Vec3> = vectors(Mesh::ATTRIBUTE_POSITION);
        let mut normals: Vec<Vec3> = vectors(Mesh::ATTRIBUTE_NORMAL);
        normals.resize(if normals.len() == positions.len() { positions.len() } else { 0 }, Vec3::ZERO);
        let mut tangents: Vec<Vec4> = match mesh.try_attribute(Mesh::ATTRIBUTE_TANGENT) {
            Ok(VertexAttributeValues::Float32x4(values)) => values.iter().map(|&v| Vec4::from(v)).collect(),
            _ => Vec::new(),
        };
        tangents.resize(if tangents.len() == positions.len() { tangents.len() } else { 0 }, Vec4::ZERO);
        Self { positions, normals, tangents }.moved(place)
    }

    pub(crate) fn moved(&self, by: &Affine3A) -> Self {
        let turn = cofactors(&by.matrix3);
        Self {
            positions: self.positions.iter().map(|p| by.transform_point3(*p)).collect(),
            normals: self.normals.iter().map(|n| turn * *n).collect(),
            tangents: self.tangents.iter().map(|t| by.transform_vector3(t.truncate()).extend(t.w)).collect(),
        }
    }
}

/// Vertices in the frame of a shape at rest, and how its triangles moved.
#[derive(Clone, Debug)]
pub(crate) struct FineMesh {
    rest: Vertices,
    triangles: Triangles,
}

impl FineMesh {
    /// Of vertices in the frame of the shape at rest, its scale included.
    pub(crate) fn new(vertices: Vertices, shape: &RestShape) -> Self {
        Self { rest: vertices, triangles: Triangles::new(&shape.topology.faces, &shape.positions) }
    }

    /// Moves the vertices to where particles at `particles` `[m]` take them, and from there by `place`. Returns the corners of
    /// their box.
    pub(crate) fn shape(
        &mut self,
        faces: &[[u32; 3]],
        embedding: &Embedding,
        particles: &[Vec3],
        place: &Affine3A,
        VertexBuffers { positions, normals, tangents }: &mut VertexBuffers,
    ) -> (Vec3, Vec3) {
        let Self { rest, triangles } = self;
        triangles.find(faces, particles, place);
        positions.resize(rest.positions.len(), [0.0; 3]);
        normals.resize(rest.normals.len(), [0.0; 3]);
        tangents.resize(rest.tangents.len(), Vec4::ZERO);
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for (v, moved) in embedding.blend(&triangles.moved).enumerate().take(rest.positions.len()) {
            let at = moved.transform_point3(rest.positions[v]);
            (low, high) = (low.min(at), high.max(at));
            positions[v] = at.to_array();
            let mut normal = Vec3::ZERO;
            if let (Some(authored), Some(shown)) = (rest.normals.get(v), normals.get_mut(v)) {
                // What is pressed flat keeps the normal it had.
                normal = (cofactors(&moved.matrix3) * *authored).normalize_or(Vec3::from(*shown).normalize_or(Vec3::Y));
                *shown = normal.to_array();
            }
            let Some(tangent) = rest.tangents.get(v) else { continue };
            let along = moved.transform_vector3(tangent.truncate());
            let across = along - normal * normal.dot(along);
            tangents[v] = across
                .try_normalize()
                .unwrap_or_else(|| normal.normalize_or(Vec3::Y).any_orthonormal_vector())
                .extend(tangent.w);
        }
        (low, high)
    }
}
