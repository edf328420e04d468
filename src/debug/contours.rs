//! What crosses: curves and the points they go through, by how a curve ends.

use bevy::prelude::*;

use super::{ClothDebug, ClothGizmos, place, scale};
use crate::islands::ClothIslands;

/// A cross is this much smaller than the other lines.
const SHARE: f32 = 0.1;

pub(super) fn draw(debug: Res<ClothDebug>, mut gizmos: Gizmos<ClothGizmos>, islands: Res<ClothIslands>) {
    for (kind, [from, to]) in islands.contours().filter(|_| debug.contours) {
        gizmos.line(from.as_vec3(), to.as_vec3(), scale::contour(kind));
    }
    for island in islands.list.iter().filter(|_| debug.crossings) {
        for (kind, point) in island.solver.crossing_points() {
            let at = Isometry3d::from_translation(place(island.origin, point));
            gizmos.cross(at, SHARE * debug.length.clamp(0.0, 100.0), scale::contour(kind));
        }
    }
}
