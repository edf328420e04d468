//! How far cloth may be from the skin, where the skin is.

use bevy::prelude::*;

use super::{ClothGizmos, place, scale};
use crate::components::Cloth;
use crate::simulation::{ClothInputs, ClothParticles, ClothRest};

pub(super) fn draw(mut gizmos: Gizmos<ClothGizmos>, cloths: Query<(&ClothRest, &ClothInputs, &ClothParticles), With<Cloth>>) {
    for (rest, inputs, particles) in &cloths {
        let skinned = &inputs.skinned;
        let distances = (0..skinned.to.len()).map(|i| skinned.distance(i)).filter(|distance| distance.is_finite());
        let farthest = distances.fold(f32::MIN_POSITIVE, f32::max);
        for &[a, b] in &rest.shape().topology.edges {
            let ends = [a, b].map(|i| skinned.to.get(i as usize).map(|q| place(particles.origin(), *q)));
            let [Some(p), Some(q)] = ends else { continue };
            let distance = skinned.distance(a as usize).max(skinned.distance(b as usize));
            // What has no limit is not drawn.
            if distance.is_finite() {
                gizmos.line(p, q, scale::sequential(distance / farthest));
            }
        }
    }
}
