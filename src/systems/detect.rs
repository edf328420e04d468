//! Detect: which cloths can meet, and where they cross.

use bevy::prelude::*;

use super::islands::{Cloths, is_awake, run};
use crate::components::{Cloth, ClothCollision, ClothCollisionLayers, ClothUntangling, ClothUntanglingDisabled};
use crate::islands::{ClothIslands, Member};
use crate::simulation::{ClothInputs, ClothParticles, ClothRest, IslandPlace, Slumber};
use crate::solver::island::Stage;
use crate::time::ClothTime;

/// Takes cloths out of their islands from which a component was removed that meeting others takes.
pub(crate) fn leave(
    mut cloths: Query<(&mut IslandPlace, Has<ClothRest>, Has<ClothCollision>, Has<ClothUntangling>, Has<Slumber>), With<Cloth>>,
) {
    for (mut place, rest, collision, untangle, slumber) in &mut cloths {
        if place.island.is_some() && !(rest && collision && untangle && slumber) {
            (place.island, place.bounds) = (None, None);
        }
    }
}

/// Finds the cloths that can meet.
pub(crate) fn form_islands(
    mut islands: ResMut<ClothIslands>,
    mut cloths: Query<
        (
            Entity,
            &ClothRest,
            &mut ClothInputs,
            &ClothParticles,
            &ClothCollision,
            &ClothUntangling,
            Has<ClothUntanglingDisabled>,
            Option<&ClothCollisionLayers>,
            &mut IslandPlace,
            &mut Slumber,
        ),
        With<Cloth>,
    >,
) {
    let _span = debug_span!("cloth/detect").entered();
    islands.begin();
    for (entity, rest, inputs, particles, collision, untangle, not_untangled, layers, mut place, _) in &mut cloths {
        let last = place.island.take().map(|(island, _)| island);
        let last_box = place.bounds.take();
        if !inputs.active || particles.sim.state.positions.len() != rest.0.positions.len() {
            continue;
        }
        let still = particles.sim.recovery.is_frozen() || inputs.time_scale == 0.0;
        let fixed = still || not_untangled;
        let (asleep, thickness) = (inputs.asleep, inputs.fabric.thickness);
        let at_load = !not_untangled && untangle.at_load;
        let (rest, rode) = (rest.0.clone(), inputs.rode);
        let member = Member { entity, rest, collision: *collision, thickness, fixed, still, rode, asleep, at_load };
        let layers = layers.copied().unwrap_or_default();
        place.alone |= !still;
        place.bounds = islands.add(member, &inputs, particles, layers, (last, last_box), &mut place.motion);
    }
    islands.form(|entity, island, part, roused| {
        if let Ok((.., mut place, mut slumber)) = cloths.get_mut(entity) {
            (place.island, place.alone) = (Some((island, part)), false);
            slumber.roused |= roused;
        }
    });
    // Who comes to meet what is stepped in the background goes there, too.
    for member in islands.list.iter().filter(|island| island.background.is_on).flat_map(|island| &island.members) {
        if let Ok((_, _, mut inputs, ..)) = cloths.get_mut(member.entity)
            && !inputs.background
        {
            (inputs.background, inputs.under_way) = (true, true);
        }
    }
}

/// Looks for crossings and for what may touch in the next frame.
pub(crate) fn detect(time: Res<ClothTime>, mut islands: ResMut<ClothIslands>, mut cloths: Cloths) {
    let _span = debug_span!("cloth/detect").entered();
    run(&mut islands, &mut cloths, Stage::Detect, time.delta_secs(), is_awake);
}
