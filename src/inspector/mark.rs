//! The border of the cloth that was picked, for a moment.

use bevy::prelude::*;

use super::state::ClothInspector;
use crate::components::Cloth;
use crate::debug::{border, place};
use crate::simulation::{ClothParticles, ClothRest, ClothShown};

/// How long it is drawn `[s]`.
const MOMENT: f32 = 1.5;

/// Which cloth was picked last, and how long ago `[s]`.
#[derive(Default)]
pub(super) struct Picked {
    cloth: Option<Entity>,
    ago: f32,
}

/// Draws the border of a cloth that was picked just now, in the list or in the scene.
pub(super) fn mark(
    mut gizmos: Gizmos,
    time: Res<Time<Real>>,
    inspector: Res<ClothInspector>,
    cloths: Query<(&ClothRest, &ClothParticles, &ClothShown), With<Cloth>>,
    mut picked: Local<Picked>,
) {
    let cloth = inspector.selected.filter(|_| inspector.open);
    picked.ago += time.delta_secs();
    if picked.cloth != cloth {
        // The first cloth was not picked by the user.
        let ago = if picked.cloth.is_some() { 0.0 } else { MOMENT };
        *picked = Picked { cloth, ago };
    }
    let Some((rest, particles, shown)) = cloth.filter(|_| picked.ago < MOMENT).and_then(|cloth| cloths.get(cloth).ok()) else {
        return;
    };
    let color = Color::WHITE.with_alpha(1.0 - picked.ago / MOMENT);
    for edge in border(rest.shape()) {
        let at = edge.map(|v| shown.particles.get(v as usize).map(|x| place(particles.origin(), *x)));
        if let [Some(a), Some(b)] = at {
            gizmos.line(a, b, color);
        }
    }
}
