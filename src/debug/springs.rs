//! Edges, by how much longer or shorter they are than at rest.

use bevy::prelude::*;

use super::{ClothDebug, ClothGizmos, place, scale};
use crate::components::Cloth;
use crate::simulation::{ClothParticles, ClothRest};

/// Strain at the ends of the scale (dimensionless).
pub(super) fn full_scale(strain: f32) -> f32 {
    strain.clamp(1.0e-4, 10.0)
}

pub(super) fn draw(
    debug: Res<ClothDebug>,
    mut gizmos: Gizmos<ClothGizmos>,
    cloths: Query<(&ClothRest, &ClothParticles), With<Cloth>>,
) {
    let range = full_scale(debug.strain);
    for (rest, particles) in &cloths {
        let (shape, x) = (rest.shape(), &particles.state().positions);
        for edge in &shape.topology.edges {
            let [Some(a), Some(b)] = edge.map(|v| x.get(v as usize).map(|x| x.truncate())) else { continue };
            let [p, q] = edge.map(|v| shape.positions[v as usize]);
            let strain = a.distance(b) / p.distance(q) - 1.0;
            let [a, b] = [a, b].map(|x| place(particles.origin(), x));
            gizmos.line(a, b, scale::diverging(strain / range));
        }
    }
}
