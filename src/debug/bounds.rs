//! The boxes by which cameras cull.

use bevy::camera::primitives::Aabb;
use bevy::math::bounding::Aabb3d;
use bevy::prelude::*;

use super::ClothGizmos;
use crate::components::Cloth;

/// The colour of boxes.
pub(super) const COLOR: Color = Color::srgb(0.0, 0.75, 0.35);

pub(super) fn draw(mut gizmos: Gizmos<ClothGizmos>, cloths: Query<(&Aabb, &GlobalTransform), With<Cloth>>) {
    for (aabb, global) in &cloths {
        gizmos.aabb_3d(Aabb3d { min: aabb.min(), max: aabb.max() }, *global, COLOR);
    }
}
