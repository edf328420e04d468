//! Reads positions and triangles of any mesh, or says why that cannot be.

use bevy::mesh::{Indices, MeshAccessError, PrimitiveTopology, VertexAttributeValues};
use bevy::prelude::*;

use crate::components::{ClothError, ClothErrorKind};

/// A mesh as its author made it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Authored {
    /// Positions in the space of the mesh `[m]`.
    pub positions: Vec<Vec3>,
    /// Corners of its triangles; indices may be past the end.
    pub triangles: Vec<[u32; 3]>,
    /// Texture coordinates, `Mesh::ATTRIBUTE_UV_0`; empty without.
    pub uvs: Vec<Vec2>,
}

/// Triangle lists and strips, indexed or not; anything else is an error.
pub(crate) fn read(mesh: &Mesh) -> Result<Authored, ClothError> {
    let topology = mesh.primitive_topology();
    if !matches!(topology, PrimitiveTopology::TriangleList | PrimitiveTopology::TriangleStrip) {
        return Err(ClothError {
            kind: ClothErrorKind::NotTriangles,
            detail: format!(
                "its mesh is a {topology:?}; cloth needs triangles: build it as a `TriangleList` or `TriangleStrip`"
            ),
        });
    }
    let positions = match mesh.try_attribute(Mesh::ATTRIBUTE_POSITION) {
        Ok(VertexAttributeValues::Float32x3(positions)) => positions.iter().map(|&p| Vec3::from(p)).collect::<Vec<_>>(),
        Ok(other) => {
            return Err(ClothError {
                kind: ClothErrorKind::NoPositions,
                detail: format!("its mesh has positions as {:?}; cloth needs Float32x3", wgpu_name(other)),
            });
        }
        Err(error) => return Err(unreadable(&error)),
    };
    let indices = match mesh.try_indices_option() {
        Ok(indices) => indices,
        Err(error) => return Err(unreadable(&error)),
    };
    let triangles = match (topology, indices) {
        (PrimitiveTopology::TriangleStrip, Some(Indices::U16(indices))) => {
            strip(indices.iter().map(|&i| (i != u16::MAX).then_some(u32::from(i))))
        }
        (PrimitiveTopology::TriangleStrip, Some(Indices::U32(indices))) => {
            strip(indices.iter().map(|&i| (i != u32::MAX).then_some(i)))
        }
        (PrimitiveTopology::TriangleStrip, None) => strip((0..positions.len()).map(|i| Some(i as u32))),
        (_, Some(indices)) => list(indices.iter().map(|i| i as u32)),
        (_, None) => list((0..positions.len()).map(|i| i as u32)),
    };
    let uvs = match mesh.try_attribute(Mesh::ATTRIBUTE_UV_0) {
        Ok(VertexAttributeValues::Float32x2(uvs)) => uvs.iter().map(|&uv| Vec2::from(uv)).collect(),
        _ => Vec::new(),
    };
    Ok(Authored { positions, triangles, uvs })
}

/// Why mesh data cannot be read, and what helps.
pub(crate) fn unreadable(error: &MeshAccessError) -> ClothError {
    match error {
        MeshAccessError::ExtractedToRenderWorld => ClothError {
            kind: ClothErrorKind::RenderWorldOnly,
            detail: "its mesh is only in the render world: load it with `RenderAssetUsages::default()` \
                (in a glTF `GltfLoaderSettings::load_meshes`), which keeps it in the main world too"
                .into(),
        },
        _ => ClothError {
            kind: ClothErrorKind::NoPositions,
            detail: "its mesh has no positions: insert `Mesh::ATTRIBUTE_POSITION`".into(),
        },
    }
}

fn wgpu_name(values: &VertexAttributeValues) -> bevy::mesh::VertexFormat {
    values.into()
}

fn list(indices: impl Iterator<Item = u32>) -> Vec<[u32; 3]> {
    let indices: Vec<u32> = indices.collect();
    indices.as_chunks::<3>().0.to_vec()
}

/// Every second triangle of a strip is turned round; `None` starts a new strip.
fn strip(indices: impl Iterator<Item = Option<u32>>) -> Vec<[u32; 3]> {
    let mut triangles = Vec::new();
    let mut run: Vec<u32> = Vec::new();
    for index in indices {
        let Some(index) = index else {
            run.clear();
            continue;
        };
        run.push(index);
        if let [.., a, b, c] = run[..] {
            triangles.push(if run.len() % 2 == 1 { [a, b, c] } else { [b, a, c] });
        }
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_second_triangle_of_a_strip_is_turned_round_and_a_restart_begins_anew() {
        let given = [Some(0), Some(1), Some(2), Some(3), None, Some(4), Some(5), Some(6)];
        assert_eq!(strip(given.into_iter()), [[0, 1, 2], [2, 1, 3], [4, 5, 6]]);
    }
}
