//! Runs a stage of the frame of every island, in parallel over islands. Each writes only the data of its own cloths, so the
//! result has the same bits for any number of threads. Where one island dominates, threads share its
//! looks for pairs.

use bevy::prelude::*;
use bevy::tasks::ComputeTaskPool;

use super::jobs::compute_pool;
use super::stopwatch;
use crate::components::Cloth;
use crate::islands::{ClothIsland, ClothIslands};
use crate::simulation::{ClothInputs, ClothParticles, ClothRest, IslandPlace};
use crate::solver::island::{self, Stage};
use crate::solver::step::{FrameInput, Stepped};

/// What islands read and write of their cloths.
pub(super) type Cloths<'w, 's, 'a> =
    Query<'w, 's, (&'a ClothRest, &'a ClothInputs, &'a mut ClothParticles, &'a IslandPlace), With<Cloth>>;

/// Runs a `stage` of a frame of `dt` `[s]` of the islands that are `wanted`, and notes the time it took. An island that lost a
/// cloth since it was formed waits until it is formed anew.
pub(super) fn run(
    islands: &mut ClothIslands,
    cloths: &mut Cloths,
    stage: Stage,
    dt: f32,
    wanted: impl Fn(&ClothIsland) -> bool,
) {
    let mut placed: Vec<_> = cloths
        .iter_mut()
        .filter_map(|(rest, inputs, particles, place)| {
            let (number, part) = place.island?;
            let island = islands.list.get(number as usize).filter(|island| wanted(island))?;
            Some(((number, part), member(island, part, dt, rest, inputs, particles.into_inner())?))
        })
        .collect();
    placed.sort_unstable_by_key(|(at, _)| *at);
    let (places, mut members): (Vec<_>, Vec<_>) = placed.into_iter().unzip();
    let mut tasks = Vec::new();
    let (mut places, mut members) = (places.as_slice(), members.as_mut_slice());
    for (number, island) in (0..).zip(&mut islands.list) {
        let count = places.iter().take_while(|(of, _)| *of == number).count();
        let (mine, others) = members.split_at_mut(count);
        (places, members) = (&places[count..], others);
        if count > 0 && count == island.members.len() {
            tasks.push((island, mine));
        }
    }
    each(
        tasks,
        |(island, _)| island,
        |(ClothIsland { solver, settings, times, .. }, members)| {
            let clock = stopwatch();
            solver.run(stage, dt, settings, members);
            times[stage as usize] = clock();
        },
    );
}

/// Runs a `stage` that needs no cloths of all islands that are awake.
pub(super) fn run_without_cloths(islands: &mut ClothIslands, stage: Stage, dt: f32) {
    let awake = islands.list.iter_mut().filter(|island| is_awake(island)).collect();
    each(
        awake,
        |island| island,
        |ClothIsland { solver, settings, times, .. }| {
            let clock = stopwatch();
            solver.run(stage, dt, settings, &mut []);
            times[stage as usize] = clock();
        },
    );
}

/// Whether an island has a frame: not all of its members sleep or stand still, and it does not run in the background.
pub(super) fn is_awake(island: &ClothIsland) -> bool {
    !island.asleep && !island.background.is_on
}

/// Share of the time of all islands from which on threads share one, rather than take islands (dimensionless). Two threads
/// share 57 % of the frame of a pile **`[measured]`**: while the others take less than half of its time, that is the sooner.
const DOMINANT: f32 = 2.0 / 3.0;

/// Does all of the work, in parallel when there is more than one task. An `island` that dominates comes last, by itself, and all
/// threads share it: who waits for them within a task would begin with the frame of another island.
fn each<T: Send>(mut tasks: Vec<T>, island: impl Fn(&mut T) -> &mut ClothIsland, work: impl Fn(T) + Sync) {
    tasks.iter_mut().for_each(|task| island(task).solver.share(None));
    let times: Vec<f32> = tasks.iter_mut().map(|task| island(task).last_ms).collect();
    let large = dominant(&times).filter(|number| island(&mut tasks[*number]).solver.is_worth_sharing());
    let large = large.map(|number| {
        let mut task = tasks.swap_remove(number);
        island(&mut task).solver.share(Some(compute_pool()));
        task
    });
    if tasks.len() > 1 {
        let work = &work;
        ComputeTaskPool::get().scope(|scope| {
            for task in tasks {
                scope.spawn(async move { work(task) });
            }
        });
    } else {
        tasks.into_iter().for_each(&work);
    }
    large.into_iter().for_each(work);
}

/// The island that takes most of the time, from those that islands took in the last frame `[ms]`; none where threads rather
/// take islands.
fn dominant(times: &[f32]) -> Option<usize> {
    let all: f32 = times.iter().sum();
    times.iter().position(|&time| times.len() == 1 || time > DOMINANT * all)
}

/// Cloth `part` of an island, as the solver sees it in a frame of `dt` `[s]`.
pub(super) fn member<'a>(
    island: &ClothIsland,
    part: u32,
    dt: f32,
    rest: &'a ClothRest,
    inputs: &'a ClothInputs,
    particles: &'a mut ClothParticles,
) -> Option<island::Member<'a>> {
    let member = island.members.get(part as usize)?;
    let moves = inputs.moves(&particles.sim.recovery);
    let input = inputs.frame(dt);
    let input = FrameInput { dt: if moves { input.dt } else { 0.0 }, ..input };
    Some(island::Member {
        cloth: Stepped { rest: &rest.0, fabric: &inputs.fabric, anchors: &inputs.anchors, input },
        stepping: &inputs.stepping,
        offset: (particles.origin - island.origin).as_vec3(),
        at_load: member.at_load,
        sim: &mut particles.sim,
        animation: if inputs.skin.is_some() { Some(inputs) } else { None },
        moves,
        clock: dt * inputs.time_scale,
        fixed: member.fixed,
        still: member.still,
        contact: member.collision.contact,
        last_resort: inputs.evaluate.last_resort,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_share_an_island_that_is_alone_or_takes_more_than_two_thirds_of_the_time() {
        assert_eq!([dominant(&[]), dominant(&[0.0]), dominant(&[3.0])], [None, Some(0), Some(0)]);
        assert_eq!([dominant(&[0.0, 0.0]), dominant(&[1.0, 1.9]), dominant(&[1.0, 2.1])], [None, None, Some(1)]);
        assert_eq!(dominant(&[f32::NAN, 1.0]), None);
    }
}
