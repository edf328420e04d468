//! Frames in the background: on another thread, while the app goes on. They are of cloths that do not fit the budget by
//! themselves.
//!
//! ```text
//! Prepare     budget   too much for a frame? ─► its island runs in the background
//! Integrate   finish   a frame is done ─► it is as if it had been stepped now
//! Respond     begin    nothing is under way ─► the next frame begins, for the time since the last
//! ```
//!
//! Every cloth stays whole meanwhile. The frame under way has the solver of the island and the `ClothSim` of each cloth. The
//! entity keeps its particles, as they are shown, so it may be changed, moved or despawned at any time. What is written to
//! particles is added to what comes of the frame. A frame of cloths that were put elsewhere is dropped, and so is one of an
//! island that is no more. The next one covers its time, too: anchors and bodies begin where the last frame ended that is done.

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy::tasks::AsyncComputeTaskPool;
use bevy::tasks::futures::check_ready;

use super::carriers::off_origin;
use super::integrate::StepQuery;
use super::islands::member;
use super::{evaluate, integrate, stopwatch};
use crate::components::ClothReport;
use crate::islands::{Background, BackgroundCloth, BackgroundFrame, ClothIsland, ClothIslands, Member};
use crate::schedule::ClothClock;
use crate::simulation::{ClothInputs, ClothParticles, ClothRest, IslandPlace, NEAR, STILL};
use crate::solver::anchors::Anchors;
use crate::solver::island::{self, Stage};
use crate::solver::sim::ClothSim;
use crate::solver::state::ClothState;
use crate::time::ClothTime;

/// Takes over what is done, unless its cloths were put elsewhere meanwhile.
pub(crate) fn finish(time: Res<ClothTime>, clock: Res<ClothClock>, mut islands: ResMut<ClothIslands>, mut cloths: StepQuery) {
    let _span = debug_span!("cloth/integrate").entered();
    let dt = time.delta_secs();
    for (_, mut inputs, particles, _, mut report) in &mut cloths {
        let inputs = &mut *inputs;
        inputs.under_way = inputs.background;
        let live = inputs.background && inputs.is_live(&particles.sim.recovery);
        if !inputs.background || inputs.asleep {
            // Nothing is left to be made up for.
            inputs.waited = 0.0;
        } else if live {
            inputs.waited += dt;
        }
        if !inputs.background {
            inputs.share.frames = 1.0;
            inputs.taken = false;
            inputs.pulled_to.clear();
        }
        if report.in_background != live {
            report.in_background = live;
        }
    }
    for island in &mut islands.list {
        let Background { is_on, frame, done, .. } = &mut island.background;
        *done = None;
        let Some(frame) =
            frame.take_if(|task| task.is_finished()).filter(|_| *is_on).and_then(|mut task| check_ready(&mut task))
        else {
            continue;
        };
        if frame.fits(island, &cloths) {
            island.background.done = Some(frame.dt);
            take_over(frame, island, dt, clock.interpolates, &mut cloths);
        }
        // Otherwise it is built anew, where it is needed.
    }
}

impl BackgroundFrame {
    /// Whether it is of the cloths as they are.
    fn fits(&self, island: &ClothIsland, cloths: &StepQuery) -> bool {
        let fits = |cloth: &BackgroundCloth, entity: Entity| {
            cloths.get(entity).is_ok_and(|(rest, inputs, particles, ..)| {
                inputs.taken
                    && rest.is_shared_with(&cloth.rest)
                    && (particles.moves, particles.origin) == (cloth.particles.moves, cloth.particles.origin)
                    && particles.len() == cloth.start.positions.len()
                    && inputs.is_live(&particles.sim.recovery) == cloth.live
            })
        };
        self.island.origin == island.origin
            && self.cloths.len() == island.members.len()
            && self.cloths.iter().zip(&island.members).all(|(cloth, member)| fits(cloth, member.entity))
    }
}

/// Gives an island and its cloths what came of a frame in the background, in a frame of the app of `dt` `[s]`.
fn take_over(frame: BackgroundFrame, island: &mut ClothIsland, dt: f32, interpolates: bool, cloths: &mut StepQuery) {
    let BackgroundFrame { island: ClothIsland { solver, times, .. }, cloths: done, dt: length } = frame;
    (island.solver, island.times) = (solver, times);
    for (cloth, member) in done.into_iter().zip(&island.members) {
        let Ok((_, mut inputs, mut particles, _, mut report)) = cloths.get_mut(member.entity) else { continue };
        let (inputs, particles) = (&mut *inputs, &mut *particles);
        let BackgroundCloth {
            inputs: then,
            particles: ClothParticles { mut sim, written: unjudged, .. },
            report: told,
            start,
            waited,
            ..
        } = cloth;
        let ClothParticles { sim: now, before, written, .. } = particles;
        if interpolates {
            before.clear();
            match now.display.held() {
                Some(held) => before.extend_from_slice(held),
                None => before.extend(now.state.positions.iter().map(|x| x.truncate())),
            }
        }
        // What moves is prepared and judged; what stands still is not yet.
        *written = add_written(&start, &now.state, &mut sim.state) || unjudged;
        inputs.stale |= then.stale;
        inputs.pulled_to.clear();
        inputs.pulled_to.extend(sim.memory.pulls_mut().targets());
        let was = core::mem::replace(now, sim);
        now.memory.take_surroundings(was.memory);
        let number = |before: u32| {
            let entity = then.body_entities.get(before as usize)?;
            u32::try_from(inputs.body_entities.iter().position(|now| now == entity)?).ok()
        };
        now.memory.renumber_bodies(number);
        begin_where_it_ended(inputs, &then);
        (inputs.under_way, inputs.taken, inputs.waited) = (false, false, (inputs.waited - waited).max(0.0));
        inputs.share.frames = length / dt;
        *report = ClothReport {
            asleep: report.asleep,
            detail: report.detail,
            by_budget: report.by_budget,
            in_background: report.in_background,
            bodies: report.bodies,
            pinned: report.pinned,
            sync_ms: report.sync_ms,
            clamped: core::mem::take(&mut report.clamped),
            ..told
        };
    }
}

/// Adds what was written to particles since a frame began to what came of it: places `[m]` and velocities. Whether anything was.
fn add_written(start: &ClothState, written: &ClothState, state: &mut ClothState) -> bool {
    let scale = if written.substep > 0.0 { state.substep / written.substep } else { 1.0 };
    let came = state.positions.iter_mut().zip(&mut state.previous);
    let before = start.positions.iter().zip(&start.previous);
    let now = written.positions.iter().zip(&written.previous);
    let mut any = false;
    for (((x, old), (x0, old0)), (x1, old1)) in came.zip(before).zip(now) {
        if (x0, old0) != (x1, old1) {
            any = true;
            let by = (*x1 - *x0).truncate();
            let velocity = by - (*old1 - *old0).truncate();
            *x += by.extend(0.0);
            *old += (by - velocity * scale).extend(0.0);
        }
    }
    any
}

/// Lets the next frame begin its anchors and bodies where one ended.
fn begin_where_it_ended(inputs: &mut ClothInputs, then: &ClothInputs) {
    let Anchors { from, particles, .. } = &mut inputs.anchors;
    for (from, particle) in from.iter_mut().zip(particles) {
        if let Ok(anchor) = then.anchors.particles.binary_search(particle) {
            *from = then.anchors.to[anchor];
        }
    }
    for (entity, body) in inputs.body_entities.iter().zip(&mut inputs.bodies).filter(|(_, body)| body.rigid.is_none()) {
        let ended = then.body_entities.iter().zip(&then.bodies).find(|(known, _)| *known == entity);
        // One that jumped since begins where it is.
        if let Some((_, ended)) = ended.filter(|(_, ended)| ended.from == body.from) {
            body.from = ended.to;
        }
    }
}

/// Begins the next frame of every island in the background that has none under way.
pub(crate) fn begin(time: Res<ClothTime>, mut islands: ResMut<ClothIslands>, mut cloths: StepQuery) {
    let _span = debug_span!("cloth/respond").entered();
    let Some(pool) = AsyncComputeTaskPool::try_get() else { return };
    let dt = time.delta_secs();
    let is_free = |island: &&mut ClothIsland| island.background.is_on && island.background.frame.is_none() && !island.asleep;
    for island in islands.list.iter_mut().filter(is_free) {
        let fits = |member: &Member| {
            cloths.get(member.entity).is_ok_and(|(rest, inputs, particles, place, _)| {
                // What left its origin gets another one first.
                member.is_as_seen(rest, particles, place)
                    && inputs.share.to_background
                    && off_origin(inputs, particles).is_none()
            })
        };
        if !island.members.iter().all(fits) {
            continue;
        }
        let length = length(island, dt, &cloths);
        let mut frame = BackgroundFrame {
            island: ClothIsland {
                members: island.members.clone(),
                settings: island.settings,
                origin: island.origin,
                solver: core::mem::take(&mut island.solver),
                ..default()
            },
            cloths: Vec::with_capacity(island.members.len()),
            dt: length,
        };
        // Frames of the app are not to wait for it.
        frame.island.solver.share(None);
        let solver = &frame.island.solver;
        (island.background.total, island.background.touching) = (solver.total(), solver.contacts().touching());
        for member in &island.members {
            let Ok((rest, mut inputs, mut particles, _, report)) = cloths.get_mut(member.entity) else { continue };
            frame.cloths.push(take(rest, &mut inputs, &mut particles, &report, length));
        }
        island.background.frame = Some(pool.spawn(async move {
            frame.run();
            frame
        }));
    }
}

/// How long the next frame of an island is `[s]`, in a frame of the app of `dt` `[s]`: the time since the last that is done, as
/// far as it is simulated. Untangling goes by frames. So one of what crosses, or was never looked at, is no longer than the
/// app's, unless pins or bodies go on meanwhile.
fn length(island: &ClothIsland, dt: f32, cloths: &StepQuery) -> f32 {
    let members = || island.members.iter().filter_map(|member| cloths.get(member.entity).ok());
    let live = || members().filter(|(_, inputs, particles, ..)| inputs.is_live(&particles.sim.recovery));
    let waited = |inputs: &ClothInputs| inputs.waited.min(inputs.stepping.max_frame / inputs.time_scale);
    let waited = live().map(|(_, inputs, ..)| waited(inputs)).fold(dt, f32::max);
    let is_clean = island.is_built() && island.solver.total().is_clean();
    let stands = |(_, inputs, particles, place, _): (_, &ClothInputs, &ClothParticles, &IslandPlace, _)| {
        pins_stand(inputs) && bodies_stand(inputs, particles.origin, place)
    };
    if !is_clean && live().all(stands) { dt } else { waited }
}

fn pins_stand(inputs: &ClothInputs) -> bool {
    let Anchors { from, to, .. } = &inputs.anchors;
    from.iter().zip(to).all(|(from, to)| from.distance(*to) <= STILL)
}

/// Whether no body that moves is near.
fn bodies_stand(inputs: &ClothInputs, origin: DVec3, place: &IslandPlace) -> bool {
    let Some((low, high)) = place.bounds else { return true };
    let [low, high] = [low, high].map(|corner| (corner - origin).as_vec3());
    inputs.bodies.iter().filter(|body| body.from != body.to).all(|body| {
        let boxes = [&body.from, &body.to].map(|at| body.shape.compute_aabb(at));
        let keep = inputs.fabric.thickness + body.margin + NEAR;
        let (least, most) = (boxes[0].mins.min(boxes[1].mins) - keep, boxes[0].maxs.max(boxes[1].maxs) + keep);
        least.cmpgt(high).any() || most.cmplt(low).any()
    })
}

/// Takes what a frame of `length` `[s]` needs of a cloth, and leaves its particles as they are shown.
fn take(
    rest: &ClothRest,
    inputs: &mut ClothInputs,
    particles: &mut ClothParticles,
    report: &ClothReport,
    length: f32,
) -> BackgroundCloth {
    let mut own = inputs.clone();
    // The copy is prepared for what it is stale of.
    (own.background, own.under_way, own.waited) = (false, false, 0.0);
    (inputs.taken, inputs.stale) = (true, false);
    let live = inputs.is_live(&particles.sim.recovery);
    let ClothSim { state, display, recovery, .. } = &particles.sim;
    let start = state.clone();
    let stays = ClothSim { state: start.clone(), display: display.clone(), recovery: recovery.clone(), ..ClothSim::default() };
    let mut sim = core::mem::replace(&mut particles.sim, stays);
    sim.memory.pulls_mut().begin_at(&inputs.pulled_to);
    let particles = ClothParticles { sim, before: Vec::new(), ..*particles };
    let waited = inputs.waited;
    let mut report = report.clone();
    if live {
        report.lost_time += (waited - length).max(0.0) * inputs.time_scale;
    }
    BackgroundCloth { rest: rest.clone(), inputs: own, particles, report, start, waited, live }
}

impl BackgroundFrame {
    /// Steps and untangles the cloths, and decides what they show.
    fn run(&mut self) {
        let Self { island, cloths, dt } = self;
        let dt = *dt;
        if !island.is_built() {
            island.build();
        }
        let together = island.is_built() && island.has_contact();
        for BackgroundCloth { rest, inputs, particles, report, .. } in cloths.iter_mut() {
            let clock = stopwatch();
            if integrate::begin(rest, dt * inputs.time_scale, false, inputs, particles, report) && !together {
                integrate::step_alone(rest, dt, inputs, particles, report);
                report.integrate_ms = clock();
            }
        }
        if together {
            run(island, &[Stage::Integrate], dt, cloths);
            for (part, BackgroundCloth { rest, inputs, particles, report, .. }) in cloths.iter_mut().enumerate() {
                if let Some(done) = particles.sim.report.take() {
                    integrate::finish(rest, done, inputs, particles, report);
                    report.integrate_ms = island.cost(Stage::Integrate, part);
                }
            }
        }
        run(island, &Stage::AFTER_INTEGRATE, dt, cloths);
        for (part, BackgroundCloth { inputs, particles, report, .. }) in cloths.iter_mut().enumerate() {
            evaluate::decide(dt, Some((island, part)), inputs, particles, report);
            report.respond_ms = island.cost(Stage::Respond, part);
            report.contacts = island.solver.contacts().touching();
        }
    }
}

/// Runs `stages` of a frame of `dt` `[s]`.
fn run(island: &mut ClothIsland, stages: &[Stage], dt: f32, cloths: &mut [BackgroundCloth]) {
    let cloths = (0..).zip(cloths);
    let seen = cloths.filter_map(|(part, BackgroundCloth { rest, inputs, particles, .. })| {
        member(island, part, dt, rest, inputs, particles)
    });
    let mut members: Vec<island::Member<'_>> = seen.collect();
    for &stage in stages {
        let clock = stopwatch();
        island.solver.run(stage, dt, &island.settings, &mut members);
        island.times[stage as usize] = clock();
    }
}
