//! Respond: what may touch in the next frame. Detect looked for it along with crossings; where something was untangled since, it is looked for again.

use bevy::prelude::*;

use super::detect::each;
use super::stopwatch;
use crate::components::{Cloth, ClothReport};
use crate::groups::ClothGroups;

/// Makes up the contacts of every group, in parallel over groups.
pub(crate) fn respond(mut groups: ResMut<ClothGroups>, mut reports: Query<&mut ClothReport, With<Cloth>>) {
    let _span = debug_span!("cloth/respond").entered();
    each(&mut groups.list, |group| {
        if group.asleep {
            return;
        }
        let clock = stopwatch();
        group.group.respond();
        group.times[3] = clock();
    });
    for group in groups.list.iter().filter(|group| !group.asleep) {
        for (part, member) in group.members.iter().enumerate() {
            if let Ok(mut report) = reports.get_mut(member.entity) {
                report.respond_ms = group.share(part) * group.times[3];
                report.contacts = group.group.contacts().touching();
            }
        }
    }
}
