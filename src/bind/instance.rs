//! The mesh that belongs to one cloth alone.

use bevy::asset::RenderAssetUsages;
use bevy::camera::primitives::Aabb;
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

/// The box between two corners; finite for all that are, as a sum or a difference of theirs need not be.
pub(crate) fn bounds_between(low: Vec3, high: Vec3) -> Aabb {
    let (low, high) = (0.5 * low, 0.5 * high);
    Aabb { center: (high + low).into(), half_extents: (high - low).into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_as_large_as_numbers_are_is_finite() {
        let (low, high) = (Vec3::splat(f32::MIN), Vec3::new(1.0, 0.0, f32::MAX));
        let bounds = bounds_between(low, high);
        assert!(bounds.center.is_finite() && bounds.half_extents.is_finite(), "{bounds:?}");
        let ordinary = bounds_between(Vec3::NEG_ONE, Vec3::new(3.0, 1.0, 0.0));
        assert_eq!(ordinary, Aabb::from_min_max(Vec3::NEG_ONE, Vec3::new(3.0, 1.0, 0.0)));
    }
}
