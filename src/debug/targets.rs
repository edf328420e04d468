//! Where the skin wants cloth, and how much of the way there is used up.

use bevy::prelude::*;

use super::{ClothGizmos, place, scale};
use crate::components::Cloth;
use crate::simulation::{ClothInputs, ClothParticles};

pub(super) fn draw(mut gizmos: Gizmos<ClothGizmos>, cloths: Query<(&ClothInputs, &ClothParticles), With<Cloth>>) {
    for (inputs, particles) in &cloths {
        let skinned = &inputs.skinned;
        for (i, (x, &target)) in particles.state().positions.iter().zip(&skinned.to).enumerate() {
            let x = x.truncate();
            let share = x.distance(target) / skinned.distance(i).max(f32::MIN_POSITIVE);
            let [x, target] = [x, target].map(|x| place(particles.origin(), x));
            if x != target {
                gizmos.line(x, target, scale::sequential(share));
            }
        }
    }
}
