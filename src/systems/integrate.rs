//! Integrate: a frame of every cloth, in parallel over cloths. Each writes only its own data, so the result has the same bits for
//! any number of threads.

use std::sync::Arc;

use bevy::ecs::batching::BatchingStrategy;
use bevy::math::DVec3;
use bevy::prelude::*;

use super::detect::each;
use super::stopwatch;
use crate::components::{Cloth, ClothReport, RecoveryCause, RecoveryLevel};
use crate::groups::{ClothGroup, ClothGroups, Member, Work};
use crate::plugin::ClothClock;
use crate::simulation::{ClothInputs, ClothParticles, ClothRest, ClothScratch};
use crate::solver::group::{self, Members};
use crate::solver::integrate::spring;
use crate::solver::recover::{Cause, Level};
use crate::solver::settings::drape_rate;
use crate::solver::step::{FrameInput, Scratch, StepReport, Stepped, prepare, step};
use crate::time::ClothTime;

type Stepping<'w, 's, 'a> = Query<
    'w,
    's,
    (&'a ClothRest, &'a mut ClothInputs, &'a mut ClothParticles, &'a mut ClothScratch, &'a mut ClothReport),
    With<Cloth>,
>;

/// Steps every cloth, and takes those back that blew up. Cloths that may touch each other or themselves are stepped side by side.
pub(crate) fn integrate(time: Res<ClothTime>, clock: Res<ClothClock>, mut groups: ResMut<ClothGroups>, mut cloths: Stepping) {
    let _span = debug_span!("cloth/integrate").entered();
    let (dt, interpolates) = (time.delta_secs(), clock.interpolates);
    for group in &mut groups.list {
        gather(group, &cloths);
    }
    // Batches of one cloth each all ran on one thread when measured; a few for each thread halve the frame of 50 cloths on two (11.6 to 6.1 ms).
    let batches = BatchingStrategy::new().batches_per_thread(5);
    let list = &groups.list;
    cloths.par_iter_mut().batching_strategy(batches.clone()).for_each(
        |(rest, mut inputs, mut particles, mut scratch, mut report)| {
            let clock = stopwatch();
            if !begin(rest, dt * inputs.time_scale, interpolates, &mut inputs, &mut particles, &mut scratch) {
                return;
            }
            if !scratch.group.is_some_and(|(group, _)| list.get(group as usize).is_some_and(ClothGroup::is_together)) {
                let ClothParticles { state, .. } = &mut *particles;
                let input = inputs.frame(dt);
                let done = step(&rest.0, &inputs.fabric, &inputs.stepping, &inputs.anchors, &input, state, &mut scratch.solver);
                finish(rest, done, &inputs, &mut particles, &mut scratch, &mut report);
                report.integrate_ms = clock();
            }
        },
    );
    if groups.list.iter().any(ClothGroup::is_together) {
        together(&mut groups, dt, &mut cloths);
        cloths.par_iter_mut().batching_strategy(batches).for_each(|(rest, inputs, mut particles, mut scratch, mut report)| {
            if let Some(done) = scratch.done.take() {
                finish(rest, done, &inputs, &mut particles, &mut scratch, &mut report);
            }
        });
    }
}

/// Makes room for the members of a group that are stepped side by side: those of one whose members are all as they were when it was looked at.
fn gather(group: &mut ClothGroup, cloths: &Stepping) {
    group.work.clear();
    if group.asleep {
        return;
    }
    let fits = |member: &Member| {
        cloths.get(member.entity).is_ok_and(|(rest, _, particles, scratch, _)| {
            Arc::ptr_eq(&rest.0, &member.rest) && particles.len() == rest.0.positions.len() && scratch.group.is_some()
        })
    };
    if group.members.iter().any(|m| m.collision.contact) && group.members.iter().all(fits) {
        group.work.resize_with(group.members.len(), Work::default);
    }
}

/// Steps the groups whose members touch, in parallel over groups.
fn together(groups: &mut ClothGroups, dt: f32, cloths: &mut Stepping) {
    for ClothGroup { members, work, .. } in &mut groups.list {
        for (member, work) in members.iter().zip(work) {
            if let Ok((.., mut particles, mut scratch, _)) = cloths.get_mut(member.entity) {
                core::mem::swap(&mut work.state, &mut particles.state);
                core::mem::swap(&mut work.solver, &mut scratch.solver);
            }
        }
    }
    let inputs = cloths.as_readonly();
    each(&mut groups.list, |group| {
        if group.is_together() {
            let clock = stopwatch();
            let ClothGroup { group: solver, members, work, origin, .. } = group;
            solver.step(&mut Together { members, work, inputs: &inputs, origin: *origin, dt });
            group.times[4] = clock();
        }
    });
    for group in &mut groups.list {
        for part in 0..group.work.len() {
            let share = group.share(part) * group.times[4];
            let work = &mut group.work[part];
            if let Ok((.., mut particles, mut scratch, mut report)) = cloths.get_mut(group.members[part].entity) {
                core::mem::swap(&mut work.state, &mut particles.state);
                core::mem::swap(&mut work.solver, &mut scratch.solver);
                scratch.done = work.report.take();
                report.integrate_ms = share;
            }
        }
    }
}

/// The members of a group, as the solver asks for them.
struct Together<'a, 'w, 's, 'q> {
    members: &'a [Member],
    work: &'a mut [Work],
    inputs:
        &'a Query<'w, 's, (&'q ClothRest, &'q ClothInputs, &'q ClothParticles, &'q ClothScratch, &'q ClothReport), With<Cloth>>,
    origin: DVec3,
    dt: f32,
}

impl Members for Together<'_, '_, '_, '_> {
    fn member(&mut self, part: usize) -> Option<group::Member<'_>> {
        let (member, work) = (self.members.get(part)?, self.work.get_mut(part)?);
        let (rest, inputs, particles, ..) = self.inputs.get(member.entity).ok()?;
        let moves = inputs.active && !inputs.asleep && !particles.recovery.is_frozen() && inputs.time_scale > 0.0;
        let input = FrameInput { dt: if moves { self.dt * inputs.time_scale } else { 0.0 }, ..inputs.frame(self.dt) };
        Some(group::Member {
            cloth: Stepped { rest: &rest.0, fabric: &inputs.fabric, anchors: &inputs.anchors, input },
            stepping: &inputs.stepping,
            state: &mut work.state,
            scratch: &mut work.solver,
            offset: (particles.origin - self.origin).as_vec3(),
            moves,
        })
    }

    fn done(&mut self, part: usize, report: StepReport) {
        if let Some(work) = self.work.get_mut(part) {
            work.report = Some(report);
        }
    }
}

/// Prepares a frame of `dt` `[s]`; false when the cloth does not move in it.
fn begin(
    rest: &ClothRest,
    dt: f32,
    interpolates: bool,
    inputs: &mut ClothInputs,
    particles: &mut ClothParticles,
    scratch: &mut ClothScratch,
) -> bool {
    let fits = particles.state.positions.len() == rest.0.positions.len();
    if !(inputs.active && !inputs.asleep && fits && dt > 0.0) || particles.recovery.is_frozen() {
        // Nothing moved, unless it was carried: there is nothing to interpolate.
        if !inputs.carried {
            particles.before.clear();
        }
        return false;
    }
    if interpolates {
        particles.before.clear();
        match particles.display.held() {
            Some(held) => particles.before.extend_from_slice(held),
            None => particles.before.extend(particles.state.positions.iter().map(|x| x.truncate())),
        }
    }
    if inputs.stale || scratch.fresh {
        prepare(&rest.0, &inputs.fabric, &inputs.anchors, &mut particles.state, &mut scratch.solver);
        inputs.stale = false;
        scratch.fresh = false;
    }
    true
}

/// Judges and records what a frame did.
fn finish(
    rest: &ClothRest,
    done: StepReport,
    inputs: &ClothInputs,
    particles: &mut ClothParticles,
    scratch: &mut ClothScratch,
    report: &mut ClothReport,
) {
    let (origin, state) = (particles.origin, &mut particles.state);
    let recovered = particles.recovery.judge(state, done.worst_edge, &inputs.limits, |pose| {
        pose.clear();
        pose.extend(inputs.pose(&rest.0, origin));
    });
    scratch.recovered = recovered.map(|(level, cause)| (level.into(), cause.into()));
    if recovered.is_some() {
        // Forces and contacts that are held over frames may have seen the bad state.
        scratch.solver = Scratch::default();
        scratch.fresh = true;
    }
    // Of what is there now.
    let edges = if recovered.is_some() {
        spring::strain(&rest.0.springs, &particles.state.positions)
    } else {
        (done.worst_edge, done.mean_edge)
    };
    report.substeps = done.substeps;
    report.inner_steps = done.inner_steps;
    report.drape_rate = drape_rate(rest.0.mean_edge);
    report.bend_held = done.bend_held;
    (report.worst_edge, report.mean_edge) = edges;
    report.body_contacts = done.body_contacts;
    report.lost_time += done.lost_time;
    report.time = particles.state.time as f32;
    match recovered {
        None => {}
        Some((Level::LastGood, _)) => report.restores += 1,
        Some((Level::Rest | Level::Frozen, _)) => report.resets += 1,
    }
}

impl From<Level> for RecoveryLevel {
    fn from(level: Level) -> Self {
        match level {
            Level::LastGood => Self::LastGood,
            Level::Rest => Self::Rest,
            Level::Frozen => Self::Frozen,
        }
    }
}

impl From<Cause> for RecoveryCause {
    fn from(cause: Cause) -> Self {
        match cause {
            Cause::NotFinite => Self::NotFinite,
            Cause::TooFast => Self::TooFast,
            Cause::Overstretched => Self::Overstretched,
        }
    }
}
