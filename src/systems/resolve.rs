//! Resolve: takes crossing cloths apart.

use bevy::math::Vec3;
use bevy::prelude::*;

use super::detect::each;
use super::stopwatch;
use crate::components::{Cloth, ClothUntangling, ClothUntanglingDisabled};
use crate::groups::{ClothGroup, ClothGroups, Member};
use crate::simulation::{ClothInputs, ClothParticles, ClothRest, ClothScratch};
use crate::solver::evaluate::Resort;
use crate::solver::fit::fit;
use crate::solver::group::BLEND_TIME;
use crate::solver::load::relax_edges;
use crate::solver::step::{displace, relax};
use crate::time::ClothTime;

type Springs<'w, 's, 'q> = Query<
    'w,
    's,
    (&'q ClothRest, &'q ClothInputs, &'q ClothScratch, &'q ClothParticles, &'q ClothUntangling, Has<ClothUntanglingDisabled>),
    With<Cloth>,
>;

/// Iterations at load, at most.
const AT_LOAD: u32 = 300;

/// Untangles, in parallel over groups.
pub(crate) fn resolve(time: Res<ClothTime>, mut groups: ResMut<ClothGroups>, cloths: Springs) {
    let _span = debug_span!("cloth/resolve").entered();
    let dt = time.delta_secs();
    each(&mut groups.list, |group| {
        if group.asleep {
            return;
        }
        let clock = stopwatch();
        if !group.group.total().is_clean() && group.members.iter().any(|m| is_new(m, &cloths)) {
            at_load(group, &cloths);
        }
        let outcome = |m: &Member| cloths.get(m.entity).map(|cloth| cloth.3.display.outcome()).unwrap_or_default();
        let resort = group.members.iter().map(|m| outcome(m).resort).max().unwrap_or_default();
        group.group.escalate(resort);
        let (members, settings) = (&group.members, group.settings);
        group.group.resolve(&settings, |part, positions| {
            if let Some(member) = members.get(part)
                && let Ok((rest, inputs, scratch, ..)) = cloths.get(member.entity)
            {
                relax(&rest.0, &inputs.fabric, &scratch.solver, positions);
            }
        });
        if resort == Resort::Blend {
            blend(group, &cloths, dt);
        }
        group.times[1] = clock();
    });
}

/// Gives what moved back to the cloths, and keeps it out of bodies.
pub(crate) fn scatter(
    mut groups: ResMut<ClothGroups>,
    mut cloths: Query<(&ClothInputs, &mut ClothParticles, &mut ClothScratch), With<Cloth>>,
) {
    for group in groups.list.iter_mut().filter(|g| !g.asleep && g.group.has_moved()) {
        for part in 0..group.members.len() {
            if let Ok((inputs, mut particles, mut scratch)) = cloths.get_mut(group.members[part].entity) {
                let offset = group.offset(particles.origin);
                let (state, solver) = (&mut particles.state, &mut scratch.solver);
                if displace(&inputs.fabric, &inputs.bodies, state, solver, |state| group.group.scatter(part, state, offset)) {
                    group.group.regather(part, state, offset);
                }
            }
        }
        if group.group.stay() {
            for part in 0..group.members.len() {
                if let Ok((_, mut particles, _)) = cloths.get_mut(group.members[part].entity) {
                    let offset = group.offset(particles.origin);
                    group.group.scatter(part, &mut particles.state, offset);
                }
            }
        }
    }
}

/// Whether a cloth asks for being untangled at load, and this is its first frame.
fn is_new(member: &Member, cloths: &Springs) -> bool {
    cloths
        .get(member.entity)
        .is_ok_and(|(.., particles, untangle, not_untangled)| !not_untangled && untangle.at_load && particles.display.is_new())
}

fn at_load(group: &mut ClothGroup, cloths: &Springs) {
    let (members, settings) = (&group.members, group.settings);
    group.group.untangle_at_load(&settings, AT_LOAD, |part, positions| {
        if let Some(Ok((rest, ..))) = members.get(part).map(|member| cloths.get(member.entity)) {
            relax_edges(&rest.0, positions);
        }
    });
}

/// Draws what nothing could take apart to the animated pose, or to the shape at rest where it is.
#[cold]
fn blend(group: &mut ClothGroup, cloths: &Springs, dt: f32) {
    let mut pose: Vec<Vec3> = Vec::new();
    for part in 0..group.members.len() {
        let Ok((rest, inputs, _, particles, ..)) = cloths.get(group.members[part].entity) else { continue };
        match &inputs.skin {
            Some(_) => {
                pose.clear();
                pose.extend(inputs.pose(&rest.0, particles.origin));
            }
            None => fit(&rest.0, &particles.state.positions, &mut pose),
        }
        // First around the tangle, then more and more of the cloth.
        let whole = (particles.display.outcome().tangled_for / inputs.evaluate.last_resort - 4.0).clamp(0.0, 1.0);
        let offset = group.offset(particles.origin);
        group.group.blend(part, &pose, offset, dt / BLEND_TIME, whole);
    }
}
