//! Boxes of the search trees, by level.

use bevy::math::bounding::Aabb3d;
use bevy::prelude::*;

use super::{ClothDebug, ClothGizmos, scale};
use crate::groups::ClothGroups;

pub(super) fn draw(debug: Res<ClothDebug>, mut gizmos: Gizmos<ClothGizmos>, groups: Res<ClothGroups>) {
    for group in &groups.list {
        for (level, bounds) in group.group.boxes(debug.bvh_levels.min(32)) {
            // Those of a cloth that is nowhere are empty.
            if bounds.min.cmple(bounds.max).all() {
                let place = Transform::from_translation(group.origin.as_vec3());
                gizmos.aabb_3d(Aabb3d { min: bounds.min, max: bounds.max }, place, scale::number(level));
            }
        }
    }
}
