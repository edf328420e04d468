//! Boxes of the search trees, by level.

use bevy::math::bounding::Aabb3d;
use bevy::prelude::*;

use super::{ClothDebug, ClothGizmos, scale};
use crate::islands::ClothIslands;

pub(super) fn draw(debug: Res<ClothDebug>, mut gizmos: Gizmos<ClothGizmos>, islands: Res<ClothIslands>) {
    for island in &islands.list {
        for (level, bounds) in island.solver.boxes(debug.bvh_levels.min(32)) {
            // Those of a cloth that is nowhere are empty.
            if bounds.min.cmple(bounds.max).all() {
                let place = Transform::from_translation(island.origin.as_vec3());
                gizmos.aabb_3d(Aabb3d { min: bounds.min, max: bounds.max }, place, scale::number(level));
            }
        }
    }
}
