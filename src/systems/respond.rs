//! Respond: what may touch in the next frame. Detect looked for it along with crossings; where something was untangled since,
//! it is looked for again.

use bevy::prelude::*;

use super::islands::{is_awake, run_without_cloths};
use crate::components::{Cloth, ClothReport};
use crate::islands::ClothIslands;
use crate::solver::island::Stage;
use crate::time::ClothTime;

/// Makes up the contacts of every island, in parallel over islands.
pub(crate) fn respond(
    time: Res<ClothTime>,
    mut islands: ResMut<ClothIslands>,
    mut reports: Query<&mut ClothReport, With<Cloth>>,
) {
    let _span = debug_span!("cloth/respond").entered();
    run_without_cloths(&mut islands, Stage::Respond, time.delta_secs());
    for island in islands.list.iter().filter(|island| is_awake(island)) {
        for (part, member) in island.members.iter().enumerate() {
            if let Ok(mut report) = reports.get_mut(member.entity) {
                report.respond_ms = island.cost(Stage::Respond, part);
                report.contacts = island.solver.contacts().touching();
            }
        }
    }
}
