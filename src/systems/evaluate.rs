//! Evaluate: judges what is about to be shown, holds what pokes through within bounds, and tells of it.

use bevy::ecs::batching::BatchingStrategy;
use bevy::prelude::*;

use super::islands::run_without_cloths;
use super::stopwatch;
use crate::components::{
    Cloth, ClothError, ClothErrorKind, ClothFailed, ClothHeld, ClothRecovered, ClothRecoveryCause, ClothRecoveryLevel,
    ClothReport, ClothStatus, ClothTangled, ClothUntangled, ClothUntanglingDisabled, ClothUntanglingEscalated,
};
use crate::islands::{ClothIsland, ClothIslands};
use crate::notices::{Notices, label};
use crate::simulation::{ClothInputs, ClothParticles, IslandPlace};
use crate::solver::evaluate::{Pose, Shown};
use crate::solver::island::Stage;
use crate::solver::recover::{Cause, Level};
use crate::solver::verdict::Verdict;
use crate::time::ClothTime;

/// Looks again where something moved, in parallel over islands.
pub(crate) fn look(time: Res<ClothTime>, mut islands: ResMut<ClothIslands>) {
    let _span = debug_span!("cloth/evaluate").entered();
    run_without_cloths(&mut islands, Stage::Evaluate, time.delta_secs());
}

/// Decides what every cloth shows, in parallel over cloths.
pub(crate) fn judge(
    time: Res<ClothTime>,
    islands: Res<ClothIslands>,
    mut cloths: Query<(&ClothInputs, &IslandPlace, &mut ClothParticles, &mut ClothReport), With<Cloth>>,
) {
    let _span = debug_span!("cloth/evaluate").entered();
    let dt = time.delta_secs();
    cloths.par_iter_mut().batching_strategy(BatchingStrategy::new().batches_per_thread(5)).for_each(
        |(inputs, place, mut particles, mut report)| {
            if !inputs.active || inputs.is_idle() || inputs.background {
                return;
            }
            let at = place.island.and_then(|(g, part)| islands.list.get(g as usize).map(|island| (island, part as usize)));
            decide(dt, at, inputs, &mut particles, &mut report);
        },
    );
}

/// Decides what a cloth shows after a frame of `dt` `[s]`; `at`: its island, and its number there.
pub(super) fn decide(
    dt: f32,
    at: Option<(&ClothIsland, usize)>,
    inputs: &ClothInputs,
    particles: &mut ClothParticles,
    report: &mut ClothReport,
) {
    let clock = stopwatch();
    let (verdict, weights) = match at {
        Some((island, part)) => (island.solver.verdict(part), island.solver.weights(part)),
        None => (Verdict::default(), [].as_slice()),
    };
    if matches!(particles.sim.recovery.taken_back(), Some((Level::Rest | Level::Frozen, _))) {
        particles.sim.display.reset();
    }
    let carrier = inputs.carrier();
    let translation = (Vec3::from(carrier.translation).as_dvec3() - particles.origin).as_vec3();
    let pose = Pose { translation, rotation: carrier.rotation };
    if let Some(skin) = inputs.skin.as_ref().filter(|_| !verdict.is_clean()) {
        // Held shapes stay on a character that moves.
        let moves = [inputs.joints_before.as_slice(), inputs.joints.as_slice()];
        particles.sim.display.follow(pose, |i, x| skin.motion(moves, i).map(|motion| motion.transform_point3(x)));
    }
    let outcome = particles.sim.display.decide(&verdict, &particles.sim.state, weights, pose, dt, &inputs.evaluate);

    report.crossings = verdict.all_crossings();
    report.authored = at.map_or(0, |(island, part)| island.solver.authored(part));
    report.contours = verdict.contours;
    report.contour_length = verdict.contour_length;
    report.regions = verdict.regions;
    report.held = outcome.shown == Shown::Held;
    report.held_frames = outcome.held_frames;
    report.iterations = at.map_or(0, |(island, _)| island.solver.iterations());
    report.deferred = at.is_some_and(|(island, _)| !island.solver.deferred().is_nothing());
    let of = |stage: Stage| at.map_or(0.0, |(island, part)| island.cost(stage, part));
    (report.detect_ms, report.resolve_ms) = (of(Stage::Detect), of(Stage::Resolve));
    (report.respond_ms, report.contacts) = (0.0, 0);
    report.evaluate_ms = of(Stage::Evaluate) + clock();
}

/// Events for cloths that became tangled, held or clean.
pub(crate) fn tell(
    mut commands: Commands,
    mut cloths: Query<(Entity, &ClothInputs, &ClothParticles, Has<ClothUntanglingDisabled>, &mut ClothReport), With<Cloth>>,
) {
    for (entity, inputs, particles, not_untangled, mut report) in &mut cloths {
        // Of a cloth that was not judged there is nothing new.
        if !inputs.active || inputs.is_idle() {
            continue;
        }
        let outcome = particles.sim.display.outcome();
        if outcome.became_tangled {
            let ClothReport { crossings, contour_length, .. } = *report;
            commands.trigger(ClothTangled { entity, crossings, contour_length });
        }
        if outcome.became_held {
            commands.trigger(ClothHeld { entity });
        }
        // What takes no part has no escalations.
        if outcome.became_last_resort && !not_untangled {
            commands.trigger(ClothUntanglingEscalated { entity, crossings: report.crossings });
        }
        if outcome.became_clean {
            commands.trigger(ClothUntangled { entity, after: report.tangled_for });
        }
        report.tangled_for = outcome.tangled_for;
    }
}

/// Says whose layers cannot come into order.
pub(crate) fn overruled_layers(mut notices: ResMut<Notices>, islands: Res<ClothIslands>, names: Query<&Name>) {
    for island in &islands.list {
        for pair in island.solver.overruled_layers() {
            let [Some(outer), Some(inner)] = pair.map(|part| island.members.get(part)) else { continue };
            if notices.first(outer.entity, "ClothCollision::garment_layer") {
                let [over, under] = [outer, inner].map(|member| label(member.entity, names.get(member.entity).ok()));
                warn!(
                    "cloth {over} has `ClothCollision::garment_layer` {}, to be worn over {under} with {}, but pins of both hold it under it: their \
                     order is let be; swap the layers or the pins, or turn triangles whose front is not outside",
                    outer.collision.garment_layer, inner.collision.garment_layer
                );
            }
        }
    }
}

/// Events for recoveries, and an error for a cloth that was stopped.
pub(crate) fn recoveries(
    mut commands: Commands,
    mut notices: ResMut<Notices>,
    mut cloths: Query<(Entity, Option<&Name>, &mut ClothParticles, &mut ClothStatus), With<Cloth>>,
) {
    for (entity, name, mut particles, mut status) in &mut cloths {
        let Some((level, cause)) = particles.sim.recovery.taken_back() else { continue };
        particles.sim.recovery.end_frame();
        let (level, cause) = (ClothRecoveryLevel::from(level), ClothRecoveryCause::from(cause));
        commands.trigger(ClothRecovered { entity, level, cause });
        if level != ClothRecoveryLevel::Frozen {
            if notices.first(entity, "recovered") {
                warn!(
                    "cloth {} blew up, as {} ({cause:?}), and was taken back ({level:?}): if it does so again, raise `ClothSolver::substep_rate` or \
                     let what pushes it be slower or lighter; this is said once, `ClothReport` counts on",
                    label(entity, name),
                    cause.because()
                );
            }
            continue;
        }
        *status = ClothStatus::Failed;
        let error = ClothError {
            kind: ClothErrorKind::Unstable,
            detail: format!(
                "it blew up again and again ({cause:?}) and was stopped at its pose at rest: raise `ClothSolver::substep_rate` or \
                 `ClothMaterial::density`, or lower its stiffness; changing either starts it again"
            ),
        };
        if notices.first(entity, error.kind.name()) {
            warn!("cloth {} was stopped: {error}", label(entity, name));
        }
        commands.entity(entity).try_insert(error.clone());
        commands.trigger(ClothFailed { entity, error });
    }
}

impl From<Level> for ClothRecoveryLevel {
    fn from(level: Level) -> Self {
        match level {
            Level::LastGood => Self::LastGood,
            Level::Rest => Self::Rest,
            Level::Frozen => Self::Frozen,
        }
    }
}

impl From<Cause> for ClothRecoveryCause {
    fn from(cause: Cause) -> Self {
        match cause {
            Cause::NotFinite => Self::NotFinite,
            Cause::TooFast => Self::TooFast,
            Cause::Overstretched => Self::Overstretched,
        }
    }
}
