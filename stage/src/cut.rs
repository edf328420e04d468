//! Meshes for Bevy from those of the scenes, with what a woven texture needs.

use bevy::{
    asset::RenderAssetUsages,
    mesh::{Indices, PrimitiveTopology},
    prelude::*,
};
use bevy_drape::solver::rest::SourceMesh;
use drape_scenes as scenes;

/// A piece of cloth cut for a scene: of `rows` vertices down, and of a size [m] that the texture is laid out on, 1 m to a unit
/// of UV.
pub fn cut(source: &SourceMesh, rows: u32, size: Vec2) -> Result<Mesh> {
    let columns = source.positions.len() as u32 / rows.max(1);
    let last = Vec2::new(columns as f32 - 1.0, rows as f32 - 1.0);
    let uv = |i: u32| (Vec2::new((i / rows) as f32, (i % rows) as f32) / last * size).to_array();
    let uvs: Vec<[f32; 2]> = (0..source.positions.len() as u32).map(uv).collect();
    let positions: Vec<[f32; 3]> = source.positions.iter().map(Vec3::to_array).collect();
    let mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, uvs)
        .with_inserted_indices(Indices::U32(source.triangles.concat()))
        .with_computed_smooth_normals();
    Ok(mesh.with_generated_tangents()?)
}

/// A square sheet of `side` [m] and `n` x `n` vertices, level.
pub fn square(n: u32, side: f32) -> Result<Mesh> {
    cut(&scenes::grid(n, n, |u, v| side * Vec3::new(u - 0.5, 0.0, v - 0.5)), n, Vec2::splat(side))
}

/// A pose of a scene as a transform, with the scene's origin at `origin` [m].
pub fn transform(pose: &bevy_drape::solver::body::Pose, origin: Vec3) -> Transform {
    Transform::from_translation(pose.translation + origin).with_rotation(pose.rotation)
}
