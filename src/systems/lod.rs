//! Prepare: level of detail. How many of its substeps a cloth takes, by its distance from the cameras and by whether it is
//! seen.

use bevy::math::DVec3;
use bevy::prelude::*;

use crate::components::{Cloth, ClothCollisionLayers, ClothDetail, ClothLod, ClothReport};
use crate::simulation::{ClothInputs, ClothParticles, IslandPlace, NEAR, WorldBodies, WorldBody, is_near};
use crate::time::ClothTime;

/// Share of a distance at which the next finer level begins, so that nothing flickers at the border.
const NEARER: f64 = 0.9;
/// Time unseen after which it counts `[s]`: what only leaves the picture for a moment is not touched.
const PATIENCE: f32 = 0.5;
/// Fewest substeps per second `[Hz]`.
pub(super) const LEAST_RATE: f32 = 30.0;

/// Scales the substeps of every cloth that has a level of detail, and stops what is far away.
pub(crate) fn detail(
    time: Res<ClothTime>,
    bodies: Res<WorldBodies>,
    cameras: Query<(&Camera, &GlobalTransform), Without<Camera2d>>,
    mut cloths: Query<
        (
            Entity,
            Option<&ViewVisibility>,
            Option<&ClothCollisionLayers>,
            &IslandPlace,
            &mut ClothInputs,
            &mut ClothParticles,
            &mut ClothReport,
        ),
        With<Cloth>,
    >,
    mut eyes: Local<Vec<DVec3>>,
) {
    self::eyes(&cameras, &mut eyes);
    for (entity, seen, layers, place, mut inputs, mut particles, mut report) in &mut cloths {
        let inputs = &mut *inputs;
        let at = DVec3::from(Vec3::from(inputs.placement.isometry().translation));
        // Cloth that is only animated counts as a point.
        let (low, high) = place.bounds.filter(|_| inputs.active).unwrap_or((at, at));
        let by_lod = if let Some(lod) = inputs.lod.filter(|_| !eyes.is_empty()) {
            // What warms up is hidden by that alone.
            let seen = inputs.warmed.is_some() || seen.is_none_or(|seen| seen.get());
            inputs.unseen_for = if seen { 0.0 } else { inputs.unseen_for + time.delta_secs() };
            let distances = eyes.iter().map(|eye| eye.clamp(low, high).distance(*eye));
            let by_distance = at_distance(&lod, distances.fold(f64::INFINITY, f64::min), inputs.by_distance);
            inputs.by_distance = by_distance;
            let unseen = if inputs.unseen_for > PATIENCE { lod.unseen } else { ClothDetail::Full };
            by_distance.max(unseen)
        } else {
            (inputs.by_distance, inputs.unseen_for) = (ClothDetail::Full, 0.0);
            ClothDetail::Full
        };
        let detail = by_lod.max(inputs.share.detail);
        // What a body hangs on or lies in has to hold it, whoever looks.
        inputs.bears = detail > ClothDetail::Full && bears(entity, (low, high), layers, inputs, &bodies);
        let detail = if inputs.bears { ClothDetail::Full } else { detail };
        let detail = if inputs.warmed.is_some() { detail.min(ClothDetail::Quarter) } else { detail };
        let rate = &mut inputs.stepping.substep_rate;
        let all = *rate;
        *rate = (*rate * detail.share()).max(rate.min(LEAST_RATE));
        // So that a frame of a warm-up costs no more than one that is shown.
        inputs.share.taken = if detail == ClothDetail::Still { 0.0 } else { *rate / all * inputs.pace };
        if detail > ClothDetail::Full {
            // Nobody sees from there how it drapes.
            inputs.stepping.inner_rate = inputs.stepping.substep_rate;
        }
        let was = inputs.carried;
        inputs.too_far = detail == ClothDetail::Still && inputs.skin.is_some();
        inputs.carried = detail == ClothDetail::Still && inputs.skin.is_none() && inputs.time_scale > 0.0;
        if inputs.carried {
            inputs.time_scale = 0.0;
            report.idle();
            if !was {
                // It goes on without the speed it had.
                let state = &mut particles.sim.state;
                state.previous.clone_from(&state.positions);
            }
        }
        // What sleeps is not marked as changed.
        if report.detail != detail {
            report.detail = detail;
        }
    }
}

/// Whether a body that takes what cloth gives hangs on a cloth with this box `[m]`, or is near it.
pub(super) fn bears(
    cloth: Entity,
    (low, high): (DVec3, DVec3),
    layers: Option<&ClothCollisionLayers>,
    inputs: &ClothInputs,
    bodies: &WorldBodies,
) -> bool {
    if bodies.rigids.is_empty() {
        return false;
    }
    let (layers, keep) = (layers.copied().unwrap_or_default(), inputs.fabric.thickness + NEAR);
    let takes = |body: &&WorldBody| body.entity != cloth && layers.touches(body.layers) && bodies.taker(body).is_some();
    let mut takers = bodies.bodies.iter().filter(takes);
    inputs.coupled.is_pinned() || takers.any(|body| is_near(body, low.as_vec3() - keep, high.as_vec3() + keep))
}

/// Where active cameras are `[m]`.
pub(super) fn eyes(cameras: &Query<(&Camera, &GlobalTransform), Without<Camera2d>>, places: &mut Vec<DVec3>) {
    places.clear();
    let active = cameras.iter().filter(|(camera, at)| camera.is_active && at.translation().is_finite());
    places.extend(active.map(|(_, at)| at.translation().as_dvec3()));
}

/// The level at a distance `[m]` of a cloth that was at `last`.
fn at_distance(lod: &ClothLod, distance: f64, last: ClothDetail) -> ClothDetail {
    let (near, far) = (f64::from(lod.full_within), f64::from(lod.still_beyond));
    let level = |distance: f64| {
        if distance > far {
            ClothDetail::Still
        } else if distance > 2.0 * near {
            ClothDetail::Quarter
        } else if distance > near {
            ClothDetail::Half
        } else {
            ClothDetail::Full
        }
    };
    level(distance).max(level(distance / NEARER).min(last))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_is_left_for_a_finer_one_a_tenth_nearer_only() {
        use ClothDetail::{Full, Half, Quarter, Still};
        let lod = ClothLod { full_within: 10.0, still_beyond: 100.0, ..ClothLod::default() };
        let walk = |from: ClothDetail, way: &[f64]| {
            let step = |last: &mut ClothDetail, &distance: &f64| {
                *last = at_distance(&lod, distance, *last);
                Some(*last)
            };
            way.iter().scan(from, step).collect::<Vec<_>>()
        };
        assert_eq!(walk(Full, &[0.0, 10.0, 10.1, 20.0, 20.1, 100.0, 101.0]), [Full, Full, Half, Half, Quarter, Quarter, Still]);
        assert_eq!(walk(Still, &[99.0, 91.0, 89.0, 19.0, 17.9, 9.5, 8.9]), [Still, Still, Quarter, Quarter, Half, Half, Full]);
        // Back and forth over a border: once.
        assert_eq!(walk(Full, &[9.9, 10.1, 9.9, 10.1, 9.9]), [Full, Half, Half, Half, Half]);
        // From far away right to the front, and a place that is none.
        assert_eq!(walk(Still, &[1.0, f64::NAN]), [Full, Full]);
        // Where it is to stand still before it is to be coarse, it does.
        let soon = ClothLod { still_beyond: 5.0, ..lod };
        assert_eq!(at_distance(&soon, 6.0, Full), Still);
    }
}
