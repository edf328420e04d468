//! Respond: looks for what may touch in the next frame.

use bevy::prelude::*;

use super::detect::each;
use super::stopwatch;
use crate::components::{Cloth, ClothReport};
use crate::groups::ClothGroups;
use crate::simulation::ClothInputs;
use crate::solver::body::Touch;

/// Finds the contacts of every group, in parallel over groups.
pub(crate) fn respond(time: Res<Time>, mut groups: ResMut<ClothGroups>, inputs: Query<&ClothInputs, With<Cloth>>, mut reports: Query<&mut ClothReport, With<Cloth>>) {
    let dt = time.delta_secs();
    each(&mut groups.list, |group| {
        let clock = stopwatch();
        group.touch.clear();
        for member in &group.members {
            let touch = inputs.get(member.entity).map(|inputs| Touch::of(&inputs.fabric)).unwrap_or_default();
            group.touch.push(touch);
        }
        group.group.respond(dt, &group.touch, |part| group.members[part].collision.contact);
        group.times[3] = clock();
    });
    for group in &groups.list {
        for (part, member) in group.members.iter().enumerate() {
            if let Ok(mut report) = reports.get_mut(member.entity) {
                report.respond_ms = group.share(part) * group.times[3];
                report.contacts = group.group.contacts().touching();
            }
        }
    }
}
