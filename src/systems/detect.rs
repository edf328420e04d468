//! Detect: which cloths can meet, and where they cross.

use bevy::prelude::*;
use bevy::tasks::ComputeTaskPool;

use super::sleep::Slumber;
use super::stopwatch;
use crate::components::{Cloth, ClothCollision, ClothCollisionLayers, ClothUntangling, ClothUntanglingDisabled};
use crate::groups::{ClothGroup, ClothGroups, Member};
use crate::simulation::{ClothInputs, ClothParticles, ClothRest, ClothScratch};
use crate::solver::body::Touch;
use crate::time::ClothTime;

/// Takes cloths out of their groups from which a component was removed that meeting others takes.
pub(crate) fn leave(
    mut cloths: Query<
        (&mut ClothScratch, Has<ClothRest>, Has<ClothCollision>, Has<ClothUntangling>, Has<Slumber>),
        With<Cloth>,
    >,
) {
    for (mut scratch, rest, collision, untangle, slumber) in &mut cloths {
        if scratch.group.is_some() && !(rest && collision && untangle && slumber) {
            (scratch.group, scratch.bounds) = (None, None);
        }
    }
}

/// Groups cloths that can meet.
pub(crate) fn group(
    mut groups: ResMut<ClothGroups>,
    mut cloths: Query<
        (
            Entity,
            &ClothRest,
            &ClothInputs,
            &ClothParticles,
            &ClothCollision,
            Has<ClothUntanglingDisabled>,
            Option<&ClothCollisionLayers>,
            &mut ClothScratch,
            &mut Slumber,
        ),
        (With<Cloth>, With<ClothUntangling>),
    >,
) {
    let _span = debug_span!("cloth/detect").entered();
    groups.begin();
    for (entity, rest, inputs, particles, collision, not_untangled, layers, mut scratch, _) in &mut cloths {
        let last = scratch.group.take().map(|(group, _)| group);
        let last_box = scratch.bounds.take();
        if !inputs.active || particles.state.positions.len() != rest.0.positions.len() {
            continue;
        }
        let still = particles.recovery.is_frozen() || inputs.time_scale == 0.0;
        let fixed = still || not_untangled;
        let (asleep, thickness) = (inputs.asleep, inputs.fabric.thickness);
        let member =
            Member { entity, rest: rest.0.clone(), collision: *collision, thickness, fixed, still, rode: inputs.rode, asleep };
        let layers = layers.copied().unwrap_or_default();
        scratch.bounds = groups.add(member, inputs, particles, layers, last_box, last);
    }
    groups.form(|entity, group, part, roused| {
        if let Ok((.., mut scratch, mut slumber)) = cloths.get_mut(entity) {
            scratch.group = Some((group, part));
            slumber.roused |= roused;
        }
    });
}

/// Looks for crossings and for what may touch in the next frame, in parallel over groups. Each writes only its own data, so the result has
/// the same bits for any number of threads.
pub(crate) fn detect(
    time: Res<ClothTime>,
    mut groups: ResMut<ClothGroups>,
    cloths: Query<(&ClothParticles, &ClothInputs), With<Cloth>>,
) {
    let _span = debug_span!("cloth/detect").entered();
    let dt = time.delta_secs();
    each(&mut groups.list, |group| {
        if group.asleep {
            return;
        }
        let clock = stopwatch();
        group.touch.clear();
        let mut longest = 0.0f32;
        for part in 0..group.members.len() {
            let Member { entity, fixed, still, .. } = group.members[part];
            let Ok((particles, inputs)) = cloths.get(entity) else { continue };
            let offset = group.offset(particles.origin);
            group.group.gather(part, &particles.state, offset, fixed);
            if still {
                group.group.hold(part);
            }
            group.touch.push(Touch::of(&inputs.fabric));
            longest = longest.max((dt * inputs.time_scale).min(inputs.stepping.max_frame));
        }
        group.group.expect(longest, &group.touch, |part| group.members[part].collision.contact);
        group.group.detect();
        group.times[0] = clock();
    });
}

/// Works on every group, in parallel when there are several.
pub(super) fn each(groups: &mut [ClothGroup], work: impl Fn(&mut ClothGroup) + Sync) {
    if let [only] = groups {
        work(only);
        return;
    }
    let work = &work;
    ComputeTaskPool::get().scope(|scope| {
        for group in groups {
            scope.spawn(async move { work(group) });
        }
    });
}
