//! The air at triangles, gusts and zones included.

use bevy::prelude::*;

use super::{ClothDebug, ClothGizmos, place, scale};
use crate::components::Cloth;
use crate::simulation::{ClothInputs, ClothParticles, ClothRest};
use crate::solver::wind::WindForces;

pub(super) fn draw(
    debug: Res<ClothDebug>,
    mut gizmos: Gizmos<ClothGizmos>,
    cloths: Query<(&ClothRest, &ClothInputs, &ClothParticles), With<Cloth>>,
    mut field: Local<WindForces>,
) {
    let (seconds, most) = (debug.wind_scale.clamp(0.0, 100.0), debug.arrows.clamp(1, 100_000) as usize);
    for (rest, inputs, particles) in &cloths {
        let faces = &rest.shape().topology.faces;
        for face in faces.iter().step_by(faces.len().div_ceil(most).max(1)) {
            let [Some(a), Some(b), Some(c)] = face.map(|v| particles.state().positions.get(v as usize)) else { continue };
            let middle = (*a + *b + *c).truncate() / 3.0;
            let velocity = field.velocity_at(&inputs.wind, middle);
            let from = place(particles.origin(), middle);
            if velocity.is_finite() && velocity != Vec3::ZERO {
                gizmos.arrow(from, from + velocity * seconds, scale::sequential(scale::speed(velocity.length())));
            }
        }
    }
}
