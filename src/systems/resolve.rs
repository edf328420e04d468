//! Resolve: takes crossing cloths apart.

use bevy::prelude::*;

use super::detect::each;
use super::stopwatch;
use crate::components::Cloth;
use crate::groups::ClothGroups;
use crate::simulation::{ClothInputs, ClothParticles, ClothRest, ClothScratch};
use crate::solver::step::relax;

/// Untangles, in parallel over groups, and gives back what moved.
pub(crate) fn resolve(
    mut groups: ResMut<ClothGroups>,
    springs: Query<(&ClothRest, &ClothInputs, &ClothScratch), With<Cloth>>,
    mut cloths: Query<&mut ClothParticles, With<Cloth>>,
) {
    each(&mut groups.list, |group| {
        let clock = stopwatch();
        let (members, settings) = (&group.members, group.settings);
        group.group.resolve(&settings, |part, positions| {
            if let Some(member) = members.get(part)
                && let Ok((rest, inputs, scratch)) = springs.get(member.entity)
            {
                relax(&rest.0, &inputs.fabric, &scratch.solver, positions);
            }
        });
        group.times[1] = clock();
    });
    for group in groups.list.iter().filter(|g| g.group.has_moved()) {
        for (part, member) in group.members.iter().enumerate() {
            if let Ok(mut particles) = cloths.get_mut(member.entity) {
                let offset = group.offset(particles.origin);
                group.group.scatter(part, &mut particles.state, offset);
            }
        }
    }
}
