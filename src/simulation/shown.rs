//! Shown: what the mesh of a cloth gets.

use bevy::math::{Affine3A, DVec3, Vec4};
use bevy::prelude::*;

use crate::bind::{FineMesh, Surface, VertexBuffers};

/// Shown: what the mesh gets.
#[derive(Component, Default)]
#[component(clone_behavior = Ignore)]
pub(crate) struct ClothShown {
    /// How vertices hang on particles.
    pub surface: Surface,
    /// The vertices, where they are finer than the cloth.
    pub fine: Option<FineMesh>,
    /// Shown positions of the particles `[m]`, in the frame of simulation.
    pub particles: Vec<Vec3>,
    /// Normals of the particles.
    pub normals: Vec<Vec3>,
    /// Their sums before they are normalized.
    pub sums: Vec<Vec3>,
    /// Buffers that change places with the attributes of the mesh.
    pub vertices: VertexBuffers,
    /// Bounds of the vertices, in the space of the mesh.
    pub bounds: (Vec3, Vec3),
    /// Where the entity was when the vertices were written.
    pub affine: Affine3A,
    /// Origin when the vertices were written `[m]`.
    pub origin: DVec3,
    /// Whether the vertices are newer than those of the mesh.
    pub fresh: bool,
    /// How often the mesh was written.
    pub writes: u32,
    /// Whether to write even if nothing moved.
    pub forced: bool,
    /// Whether nothing moved since it fell asleep.
    pub still: bool,
}

impl ClothShown {
    /// Sizes the buffers for the surface.
    pub(crate) fn fit(&mut self, vertices: usize) {
        let buffers = &mut self.vertices;
        buffers.positions.resize(vertices, [0.0; 3]);
        buffers.normals.resize(if self.surface.normals { vertices } else { 0 }, [0.0; 3]);
        let handedness = &self.surface.handedness;
        buffers.tangents.clear();
        buffers.tangents.extend(handedness.iter().map(|&w| Vec4::new(1.0, 0.0, 0.0, w)));
    }
}
