//! Normals of particles, as light sees them.

use bevy::prelude::*;

use super::{ClothDebug, ClothGizmos, place};
use crate::components::Cloth;
use crate::simulation::{ClothParticles, ClothRest};
use crate::solver::surface;

/// The colour of normals.
pub(super) const COLOR: Color = Color::srgb(0.45, 0.30, 1.0);

pub(super) fn draw(
    debug: Res<ClothDebug>,
    mut gizmos: Gizmos<ClothGizmos>,
    cloths: Query<(&ClothRest, &ClothParticles), With<Cloth>>,
    mut positions: Local<Vec<Vec3>>,
    mut sums: Local<Vec<Vec3>>,
    mut normals: Local<Vec<Vec3>>,
) {
    let length = debug.length.clamp(0.0, 100.0);
    for (rest, particles) in &cloths {
        let faces = &rest.shape().topology.faces;
        positions.clear();
        positions.extend(particles.state().positions.iter().map(|x| x.truncate()));
        if positions.len() != rest.shape().positions.len() {
            continue;
        }
        // A mesh without normals has none that are kept.
        surface::normals(faces, &positions, &mut sums, &mut normals);
        for (&x, &n) in positions.iter().zip(normals.iter()) {
            let from = place(particles.origin(), x);
            gizmos.line(from, from + n * length, COLOR);
        }
    }
}
