//! Integrate: a frame of every cloth, in parallel over cloths. Each writes only its own data, so the result has the same bits
//! for any number of threads.

use bevy::ecs::batching::BatchingStrategy;
use bevy::prelude::*;

use super::islands::{Cloths, is_awake, run};
use super::stopwatch;
use crate::components::{Cloth, ClothReport};
use crate::islands::{ClothIsland, ClothIslands, Member};
use crate::schedule::ClothClock;
use crate::simulation::{ClothInputs, ClothParticles, ClothRest, IslandPlace};
use crate::solver::integrate::spring;
use crate::solver::island::Stage;
use crate::solver::recover::{Level, Limits, diagnose};
use crate::solver::settings::drape_rate;
use crate::solver::sim::ClothSim;
use crate::solver::state::ClothState;
use crate::solver::step::{StepReport, prepare, step};
use crate::time::ClothTime;

/// What stepping reads and writes of cloths, in the frame and in the background.
pub(crate) type StepQuery<'w, 's, 'a> = Query<
    'w,
    's,
    (&'a ClothRest, &'a mut ClothInputs, &'a mut ClothParticles, &'a IslandPlace, &'a mut ClothReport),
    With<Cloth>,
>;

/// Prepares every cloth, and steps those that touch no other.
pub(crate) fn alone(time: Res<ClothTime>, clock: Res<ClothClock>, mut islands: ResMut<ClothIslands>, mut cloths: StepQuery) {
    let _span = debug_span!("cloth/integrate").entered();
    let (dt, interpolates) = (time.delta_secs(), clock.interpolates);
    for island in &mut islands.list {
        let in_background = |member: &Member| cloths.get(member.entity).is_ok_and(|(_, inputs, ..)| inputs.background);
        island.background.is_on = island.members.iter().any(in_background);
        if !(island.background.is_on || island.is_built()) {
            island.build();
        }
        island.together = steps_together(island, &cloths);
    }
    let list = &islands.list;
    cloths.par_iter_mut().batching_strategy(batches()).for_each(|(rest, mut inputs, mut particles, place, mut report)| {
        let clock = stopwatch();
        if !begin(rest, dt * inputs.time_scale, interpolates, &mut inputs, &mut particles, &mut report) {
            return;
        }
        if !place.island.is_some_and(|(island, _)| list.get(island as usize).is_some_and(|island| island.together)) {
            step_alone(rest, dt, &inputs, &mut particles, &mut report);
            report.integrate_ms = clock();
        }
    });
}

/// Steps the islands whose members touch.
pub(crate) fn together(time: Res<ClothTime>, mut islands: ResMut<ClothIslands>, mut cloths: Cloths) {
    let _span = debug_span!("cloth/integrate").entered();
    let wanted = |island: &ClothIsland| island.together;
    run(&mut islands, &mut cloths, Stage::Integrate, time.delta_secs(), wanted);
}

/// Judges what stepping side by side did, and takes those back that blew up.
pub(crate) fn judge(islands: Res<ClothIslands>, mut cloths: StepQuery) {
    let _span = debug_span!("cloth/integrate").entered();
    if !islands.list.iter().any(|island| island.together) {
        return;
    }
    for island in islands.list.iter().filter(|island| island.together) {
        for (part, member) in island.members.iter().enumerate() {
            if let Ok((.., mut report)) = cloths.get_mut(member.entity) {
                report.integrate_ms = island.cost(Stage::Integrate, part);
            }
        }
    }
    cloths.par_iter_mut().batching_strategy(batches()).for_each(|(rest, inputs, mut particles, _, mut report)| {
        if let Some(done) = particles.sim.report.take() {
            finish(rest, done, &inputs, &mut particles, &mut report);
        }
    });
}

/// Batches of one cloth each all ran on one thread when measured. A few batches for each thread halve the frame of 50 cloths on
/// two (11.6 to 6.1 ms).
fn batches() -> BatchingStrategy {
    BatchingStrategy::new().batches_per_thread(5)
}

/// Whether the members of an island are stepped side by side: they touch, and all are as they were when it was looked at.
fn steps_together(island: &ClothIsland, cloths: &StepQuery) -> bool {
    let fits = |member: &Member| {
        cloths.get(member.entity).is_ok_and(|(rest, _, particles, place, _)| member.is_as_seen(rest, particles, place))
    };
    is_awake(island) && island.has_contact() && island.members.iter().all(fits)
}

/// Steps a cloth by a frame of `dt` `[s]` that touches no other, and itself neither.
pub(super) fn step_alone(
    rest: &ClothRest,
    dt: f32,
    inputs: &ClothInputs,
    particles: &mut ClothParticles,
    report: &mut ClothReport,
) {
    let ClothSim { state, memory, .. } = &mut particles.sim;
    let input = inputs.frame(dt);
    let done = step(&rest.0, &inputs.fabric, &inputs.stepping, &inputs.anchors, &input, state, memory);
    finish(rest, done, inputs, particles, report);
}

/// Prepares a frame of `dt` `[s]`; false when the cloth does not move in it.
pub(super) fn begin(
    rest: &ClothRest,
    dt: f32,
    interpolates: bool,
    inputs: &mut ClothInputs,
    particles: &mut ClothParticles,
    report: &mut ClothReport,
) -> bool {
    let fits =
        [&particles.sim.state.positions, &particles.sim.state.previous].iter().all(|all| all.len() == rest.0.positions.len());
    if !(inputs.moves(&particles.sim.recovery) && fits && dt > 0.0) {
        // Nothing moved, unless it was carried: there is nothing to interpolate.
        if !inputs.carried {
            particles.before.clear();
        }
        return false;
    }
    inputs.waited = 0.0;
    judge_written(rest, inputs, particles, report);
    if interpolates {
        particles.before.clear();
        match particles.sim.display.held() {
            Some(held) => particles.before.extend_from_slice(held),
            None => particles.before.extend(particles.sim.state.positions.iter().map(|x| x.truncate())),
        }
    }
    let ClothSim { state, memory, .. } = &mut particles.sim;
    if inputs.stale || !memory.is_prepared_for(&rest.0) {
        prepare(&rest.0, &inputs.fabric, &inputs.anchors, state, memory);
        inputs.stale = false;
    }
    true
}

/// Takes a cloth back whose state the app wrote, if it is no longer physical: before others meet it there.
fn judge_written(rest: &ClothRest, inputs: &ClothInputs, particles: &mut ClothParticles, report: &mut ClothReport) {
    if core::mem::take(&mut particles.written) {
        // What an app writes may have another, or none; kernels take it from either.
        let ClothState { positions, previous, .. } = &mut particles.sim.state;
        positions.iter().zip(previous).for_each(|(x, old)| old.w = x.w);
        let edges = spring::strain(&rest.0.springs, &particles.sim.state.positions);
        // How fast it is shows when it was stepped.
        let limits = Limits { speed: f32::INFINITY, ..inputs.limits };
        if diagnose(&particles.sim.state, edges.0, &limits).is_some() {
            take_back(rest, edges, &limits, inputs, particles, report);
        }
    }
}

/// Judges a state with these longest and mean edges, and takes it back if it is bad. Those of what is there then.
fn take_back(
    rest: &ClothRest,
    edges: (f32, f32),
    limits: &Limits,
    inputs: &ClothInputs,
    particles: &mut ClothParticles,
    report: &mut ClothReport,
) -> (f32, f32) {
    let origin = particles.origin;
    let ClothSim { state, memory, recovery, .. } = &mut particles.sim;
    let recovered = recovery.judge(state, edges.0, limits, |pose| {
        pose.clear();
        pose.extend(inputs.pose(&rest.0, origin));
    });
    let Some((level, _)) = recovered else { return edges };
    // Forces and contacts that are held over frames may have seen the bad state.
    memory.forget();
    match level {
        Level::LastGood => report.restores += 1,
        Level::Rest | Level::Frozen => report.resets += 1,
    }
    spring::strain(&rest.0.springs, &state.positions)
}

/// Judges and records what a frame did.
pub(super) fn finish(
    rest: &ClothRest,
    done: StepReport,
    inputs: &ClothInputs,
    particles: &mut ClothParticles,
    report: &mut ClothReport,
) {
    let edges = take_back(rest, (done.worst_edge, done.mean_edge), &inputs.limits, inputs, particles, report);
    report.substeps = done.substeps;
    report.inner_steps = done.inner_steps;
    report.drape_rate = drape_rate(rest.0.mean_edge);
    report.bend_held = done.bend_held;
    (report.worst_edge, report.mean_edge) = edges;
    report.body_contacts = done.body_contacts;
    report.lost_time += done.lost_time;
    report.time = particles.sim.state.time as f32;
}
