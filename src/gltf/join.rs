//! The primitives of a node, one for each material, joined into the mesh of one cloth.

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, MeshVertexAttribute, PrimitiveTopology, VertexAttributeValues};
use bevy::prelude::*;

/// Several meshes as one.
pub(super) struct Joined {
    /// All vertices, one mesh after the other.
    pub mesh: Mesh,
    /// Which of them is the first of each mesh.
    pub firsts: Vec<u32>,
}

/// Joins meshes of triangles, with the attributes that all of them have. Bevy makes tangents where the material has a normal
/// map: the others get any, since those of cloth are computed anew.
pub(super) fn join(meshes: &[&Mesh]) -> Result<Joined, String> {
    let mut joined: Option<Mesh> = None;
    let mut firsts = Vec::new();
    let common = common(meshes)?;
    for mesh in meshes {
        let part = part(mesh, &common)?;
        firsts.push(joined.as_ref().map_or(0, Mesh::count_vertices) as u32);
        match &mut joined {
            None => joined = Some(part),
            Some(joined) => joined.merge(&part).map_err(|error| error.to_string())?,
        }
    }
    let mesh = joined.ok_or("there is none")?;
    Ok(Joined { mesh, firsts })
}

/// The attributes that all meshes have, in the same format.
fn common(meshes: &[&Mesh]) -> Result<Vec<MeshVertexAttribute>, String> {
    let mut common: Option<Vec<MeshVertexAttribute>> = None;
    for mesh in meshes {
        let own: Vec<MeshVertexAttribute> =
            mesh.try_attributes().map_err(|error| error.to_string())?.map(|(attribute, _)| *attribute).collect();
        match &mut common {
            None => common = Some(own),
            Some(common) => common.retain(|one| own.iter().any(|other| (one.id, one.format) == (other.id, other.format))),
        }
    }
    let mut common = common.unwrap_or_default();
    let has = |mesh: &&Mesh| matches!(mesh.try_attribute(Mesh::ATTRIBUTE_TANGENT), Ok(VertexAttributeValues::Float32x4(_)));
    if meshes.iter().any(has) && !common.iter().any(|one| one.id == Mesh::ATTRIBUTE_TANGENT.id) {
        // After the positions, whose number it takes.
        common.push(Mesh::ATTRIBUTE_TANGENT);
    }
    Ok(common)
}

/// A list of triangles with some attributes of a mesh.
fn part(mesh: &Mesh, attributes: &[MeshVertexAttribute]) -> Result<Mesh, String> {
    if mesh.primitive_topology() != PrimitiveTopology::TriangleList {
        return Err(format!("one is a {:?}", mesh.primitive_topology()));
    }
    let mut part = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::MAIN_WORLD);
    for &attribute in attributes {
        if attribute.id == Mesh::ATTRIBUTE_TANGENT.id && !mesh.contains_attribute(attribute.id) {
            part.insert_attribute(attribute, vec![[1.0, 0.0, 0.0, 1.0]; part.count_vertices()]);
            continue;
        }
        let values = mesh.try_attribute(attribute.id).map_err(|error| error.to_string())?;
        part.insert_attribute(attribute, values.clone());
    }
    let indices = match mesh.try_indices_option().map_err(|error| error.to_string())? {
        Some(indices) => indices.iter().map(|i| i as u32).collect(),
        None => (0..part.count_vertices() as u32).collect(),
    };
    part.insert_indices(Indices::U32(indices));
    Ok(part)
}

/// Meshes that were joined, while cloths have them: scenes of one file share them, and with them their shape at rest.
#[derive(Default)]
pub(crate) struct Known(Vec<AssetId<Mesh>>);

impl Known {
    /// A mesh like this one.
    pub(super) fn find(&mut self, assets: &mut Assets<Mesh>, mesh: Mesh) -> Handle<Mesh> {
        self.0.retain(|id| assets.contains(*id));
        let like = self.0.iter().copied().find(|id| assets.get(*id) == Some(&mesh));
        let handle = like.and_then(|id| assets.get_strong_handle(id)).unwrap_or_else(|| assets.add(mesh));
        if !self.0.contains(&handle.id()) {
            self.0.push(handle.id());
        }
        handle
    }
}
