//! Where cloth is held.

use bevy::prelude::*;

use super::{ClothDebug, ClothGizmos, place, scale};
use crate::components::Cloth;
use crate::simulation::{ClothInputs, ClothParticles};

/// A cross is this much smaller than the other lines.
const SHARE: f32 = 0.3;

pub(super) fn draw(
    debug: Res<ClothDebug>,
    mut gizmos: Gizmos<ClothGizmos>,
    cloths: Query<(&ClothInputs, &ClothParticles), With<Cloth>>,
) {
    for (inputs, particles) in &cloths {
        let anchors = &inputs.anchors;
        for ((&p, &weight), &to) in anchors.particles.iter().zip(&anchors.weights).zip(&anchors.to) {
            let Some(x) = particles.state().positions.get(p as usize) else { continue };
            let color = scale::sequential(weight);
            let [x, to] = [x.truncate(), to].map(|x| place(particles.origin(), x));
            gizmos.cross(Isometry3d::from_translation(to), SHARE * debug.length.clamp(0.0, 100.0), color);
            if x != to {
                gizmos.line(x, to, color);
            }
        }
    }
}
