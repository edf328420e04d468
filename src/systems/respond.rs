//! Respond: what may touch in the next frame. Detect looked for it along with crossings; where something was untangled since, it is looked for again.

use bevy::prelude::*;

use super::islands::each;
use super::stopwatch;
use crate::components::{Cloth, ClothReport};
use crate::islands::ClothIslands;

/// Makes up the contacts of every island, in parallel over islands.
pub(crate) fn respond(mut islands: ResMut<ClothIslands>, mut reports: Query<&mut ClothReport, With<Cloth>>) {
    let _span = debug_span!("cloth/respond").entered();
    each(&mut islands.list, |island| {
        if island.asleep {
            return;
        }
        let clock = stopwatch();
        island.solver.respond();
        island.times[3] = clock();
    });
    for island in islands.list.iter().filter(|island| !island.asleep) {
        for (part, member) in island.members.iter().enumerate() {
            if let Ok(mut report) = reports.get_mut(member.entity) {
                report.respond_ms = island.share(part) * island.times[3];
                report.contacts = island.solver.contacts().touching();
            }
        }
    }
}
