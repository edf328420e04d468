//! The mesh that belongs to one cloth alone.

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{MeshAccessError, VertexAttributeValues};
use bevy::prelude::*;

/// A copy of `source` without skin and morph targets: simulated positions must not be skinned again.
pub(crate) fn instance_of(source: &Mesh, usage: RenderAssetUsages) -> Result<Mesh, MeshAccessError> {
    let mut instance = Mesh::new(source.primitive_topology(), usage);
    instance.enable_raytracing = source.enable_raytracing;
    for (attribute, values) in source.try_attributes()? {
        let skin = [Mesh::ATTRIBUTE_JOINT_INDEX.id, Mesh::ATTRIBUTE_JOINT_WEIGHT.id];
        if !skin.contains(&attribute.id) {
            instance.try_insert_attribute(*attribute, values.clone())?;
        }
    }
    if let Some(indices) = source.try_indices_option()? {
        instance.try_insert_indices(indices.clone())?;
    }
    Ok(instance)
}

/// Smallest and largest corner of the positions of a mesh, for the bounds until the first sync.
pub(crate) fn corners(mesh: &Mesh) -> Option<(Vec3, Vec3)> {
    let Ok(VertexAttributeValues::Float32x3(positions)) = mesh.try_attribute(Mesh::ATTRIBUTE_POSITION) else {
        return None;
    };
    let fold = |(low, high): (Vec3, Vec3), p: &[f32; 3]| (low.min(Vec3::from(*p)), high.max(Vec3::from(*p)));
    let (low, high) = positions.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), fold);
    (low.is_finite() && high.is_finite()).then_some((low, high))
}
