//! Runs a stage of the frame of every island, in parallel over islands. Each writes only the data of its own cloths, so the result has the same bits for
//! any number of threads.

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy::tasks::ComputeTaskPool;

use super::stopwatch;
use crate::components::Cloth;
use crate::islands::{ClothIsland, ClothIslands, Member, Work};
use crate::simulation::{ClothInputs, ClothParticles, ClothRest, ClothScratch};
use crate::solver::fit::fit;
use crate::solver::island::{self, Members};
use crate::solver::step::{FrameInput, StepReport, Stepped};

/// What islands read and write of their cloths.
pub(super) type Cloths<'w, 's, 'a> =
    Query<'w, 's, (&'a ClothRest, &'a ClothInputs, &'a mut ClothParticles, &'a mut ClothScratch), With<Cloth>>;

/// An island in a stage, with its members.
pub(super) struct Stage<'a> {
    pub solver: &'a mut island::Island,
    pub settings: &'a island::UntangleSettings,
}

/// Runs a `stage` of a frame of `dt` `[s]` of the islands that are `wanted`, and notes the time it took at `slot` of [`ClothIsland::times`].
pub(super) fn run(
    islands: &mut ClothIslands,
    cloths: &mut Cloths,
    slot: usize,
    dt: f32,
    wanted: impl Fn(&ClothIsland) -> bool + Sync,
    stage: impl Fn(Stage<'_>, &mut InWorld<'_, '_, '_, '_>) + Sync,
) {
    // Members are read by all while each island writes what it borrowed.
    islands.list.iter_mut().filter(|island| wanted(island)).for_each(|island| borrow(island, cloths));
    let read = cloths.as_readonly();
    each(&mut islands.list, |island| {
        if wanted(island) {
            let clock = stopwatch();
            let ClothIsland { solver, settings, members, work, origin, .. } = island;
            stage(Stage { solver, settings }, &mut InWorld { members, work, cloths: &read, origin: *origin, dt });
            island.times[slot] = clock();
        }
    });
    islands.list.iter_mut().filter(|island| wanted(island)).for_each(|island| borrow(island, cloths));
}

/// Whether an island has a frame: not all of its members sleep or stand still.
pub(super) fn is_awake(island: &ClothIsland) -> bool {
    !island.asleep
}

/// Takes particles and buffers of all members, or gives them back.
fn borrow(island: &mut ClothIsland, cloths: &mut Cloths) {
    for (member, work) in island.members.iter().zip(&mut island.work) {
        if let Ok((.., mut particles, mut scratch)) = cloths.get_mut(member.entity) {
            core::mem::swap(&mut work.state, &mut particles.state);
            core::mem::swap(&mut work.solver, &mut scratch.solver);
        }
    }
}

/// Works on every island, in parallel when there are several.
pub(super) fn each(islands: &mut [ClothIsland], work: impl Fn(&mut ClothIsland) + Sync) {
    if let [only] = islands {
        work(only);
        return;
    }
    let work = &work;
    ComputeTaskPool::get().scope(|scope| {
        for island in islands {
            scope.spawn(async move { work(island) });
        }
    });
}

/// The members of an island, as the solver asks for them.
pub(super) struct InWorld<'a, 'w, 's, 'q> {
    members: &'a [Member],
    work: &'a mut [Work],
    cloths: &'a Query<'w, 's, (&'q ClothRest, &'q ClothInputs, &'q ClothParticles, &'q ClothScratch), With<Cloth>>,
    origin: DVec3,
    dt: f32,
}

impl Members for InWorld<'_, '_, '_, '_> {
    fn member(&mut self, part: usize) -> Option<island::Member<'_>> {
        let (member, work) = (self.members.get(part)?, self.work.get_mut(part)?);
        let (rest, inputs, particles, _) = self.cloths.get(member.entity).ok()?;
        let moves = inputs.active && !inputs.asleep && !particles.recovery.is_frozen() && inputs.time_scale > 0.0;
        let input = inputs.frame(self.dt);
        let input = FrameInput { dt: if moves { input.dt } else { 0.0 }, ..input };
        Some(island::Member {
            cloth: Stepped { rest: &rest.0, fabric: &inputs.fabric, anchors: &inputs.anchors, input },
            stepping: &inputs.stepping,
            state: &mut work.state,
            scratch: &mut work.solver,
            offset: (particles.origin - self.origin).as_vec3(),
            moves,
            clock: self.dt * inputs.time_scale,
            fixed: member.fixed,
            still: member.still,
            contact: member.collision.contact,
            at_load: member.at_load && particles.display.is_new(),
            outcome: particles.display.outcome(),
            last_resort: inputs.evaluate.last_resort,
        })
    }

    fn done(&mut self, part: usize, report: StepReport) {
        if let Some(work) = self.work.get_mut(part) {
            work.report = Some(report);
        }
    }

    fn pose(&mut self, part: usize, pose: &mut Vec<Vec3>) {
        pose.clear();
        let (Some(member), Some(work)) = (self.members.get(part), self.work.get(part)) else { return };
        let Ok((rest, inputs, particles, _)) = self.cloths.get(member.entity) else { return };
        match &inputs.skin {
            Some(_) => pose.extend(inputs.pose(&rest.0, particles.origin)),
            None => fit(&rest.0, &work.state.positions, pose),
        }
    }
}
