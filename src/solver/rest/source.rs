//! What comes in: a triangle soup, and what was wrong with it.

use glam::{Vec2, Vec3};

/// Farthest coordinate of a vertex `[m]`: squares of areas of what is farther out would overflow.
pub(super) const FARTHEST: f32 = 1.0e9;

/// A triangle soup as an asset delivers it, already scaled to world units.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct SourceMesh {
    /// Positions `[m]` of the render vertices, scaled to world size, unrotated.
    pub positions: Vec<Vec3>,
    /// Corners of each triangle; may be out of range, degenerate or repeated: [`RestShape::build`](super::RestShape::build)
    /// cleans up.
    pub triangles: Vec<[u32; 3]>,
    /// Texture coordinates of the vertices (dimensionless), which tell the threads' directions: `u` runs along the weft, `v`
    /// along the warp. As many as positions, or none.
    pub uvs: Vec<Vec2>,
}

/// What had to be repaired while a [`RestShape`](super::RestShape) was built.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct BuildReport {
    /// Render vertices given.
    pub vertices: usize,
    /// Particles left after welding vertices at one position.
    pub particles: usize,
    /// Triangles simulated.
    pub faces: usize,
    /// Triangles dropped because an index was past the end of the vertices.
    pub out_of_range: usize,
    /// Triangles dropped because they had no area or a repeated corner.
    pub degenerate: usize,
    /// Triangles dropped because another had the same corners.
    pub duplicate: usize,
    /// Vertices no simulated triangle refers to; they ride on the nearest particle.
    pub isolated: usize,
    /// Triangles simulated whose texture coordinates tell no direction of the threads: all of them without coordinates.
    pub without_warp: usize,
}

/// Why a mesh cannot become a cloth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RestError {
    /// Fewer than three vertices.
    #[error("the mesh has {0} vertices; a cloth needs at least 3")]
    TooFewVertices(usize),
    /// No triangle was left after dropping the invalid ones.
    #[error(
        "none of the mesh's {given} triangles can be simulated ({out_of_range} with indices past the end, {degenerate} without area)"
    )]
    NoTriangles {
        /// Triangles given.
        given: usize,
        /// Of these, with an index past the end.
        out_of_range: usize,
        /// Of these, without area or with a repeated corner.
        degenerate: usize,
    },
    /// A vertex position is not finite.
    #[error("vertex {0} has a position that is not finite")]
    NotFinite(usize),
    /// A vertex is too far out for its distance to others to be a number.
    #[error("vertex {0} is more than {FARTHEST:e} m from the origin of its mesh: correct it, or the scale of the mesh")]
    TooFar(usize),
}
