//! Prepare: simulates more than a frame of cloth that is not shown yet, and hides it until then.

use bevy::ecs::query::QueryData;
use bevy::prelude::*;

use super::lod::bears;
use crate::components::checked::Checked;
use crate::components::{
    Cloth, ClothCollisionLayers, ClothDisabled, ClothPiece, ClothRenderMesh, ClothReport, ClothSolver, ClothStatus, ClothWarmUp,
};
use crate::simulation::{ClothInputs, ClothParticles, ClothRest, IslandPlace, WorldBodies};
use crate::solver::settings::{Stepping, drape_rate};
use crate::time::ClothTime;

/// Particles moved in a frame by all cloths that warm up together, once for each step: about 2 ms at 50 ns each.
const SLICE: f32 = 40_000.0;

#[derive(QueryData)]
#[query_data(mutable)]
pub(crate) struct Warming {
    entity: Entity,
    warm_up: Option<&'static ClothWarmUp>,
    solver: &'static ClothSolver,
    layers: Option<&'static ClothCollisionLayers>,
    rest: &'static ClothRest,
    particles: &'static ClothParticles,
    place: &'static IslandPlace,
    report: &'static ClothReport,
    inputs: &'static mut ClothInputs,
}

impl WarmingItem<'_, '_> {
    /// Length of a frame by the clock `[s]`.
    fn by_clock(&self, time: &ClothTime) -> f32 {
        time.delta_secs() * self.solver.time_scale(&mut Checked::default())
    }

    /// Whether it was warmed up for as long as it is to be, or there is nothing to simulate.
    fn is_done(&self) -> bool {
        let stands = self.inputs.asleep || self.inputs.is_animated() || self.particles.sim.recovery.is_frozen();
        stands || self.left() <= 0.0
    }

    /// Time that is to be simulated before it is shown `[s]`.
    fn left(&self) -> f32 {
        let seconds = self.warm_up.map_or(0.0, |warm_up| warm_up.checked(&mut Checked::default()));
        seconds - self.inputs.warmed.unwrap_or(0.0)
    }

    /// Particles moved in a second, once for each step.
    fn work(&self) -> f32 {
        let Stepping { substep_rate, inner_rate, .. } = self.inputs.stepping;
        let inner_steps = (drape_rate(self.rest.0.mean_edge).min(inner_rate) / substep_rate).ceil().max(1.0);
        self.particles.len() as f32 * substep_rate * inner_steps
    }

    fn island(&self) -> Option<usize> {
        self.place.island.map(|(island, _)| island as usize)
    }
}

/// Sets the pace of every cloth that warms up, and ends the warm-up of those that are done. Before its first frame its
/// settings were not read. Two-way bodies, and cloth that is shown beside it, go by the clock.
pub(crate) fn pace(
    mut commands: Commands,
    time: Res<ClothTime>,
    bodies: Res<WorldBodies>,
    mut cloths: Query<Warming, With<Cloth>>,
    mut is_shown: Local<Vec<bool>>,
) {
    is_shown.clear();
    for mut cloth in &mut cloths {
        let warms_up = cloth.warm_up.is_some();
        let done = warms_up && cloth.is_done();
        if done {
            commands.entity(cloth.entity).try_remove::<ClothWarmUp>();
        }
        cloth.inputs.pace = 1.0;
        cloth.inputs.warmed = cloth.inputs.warmed.or(Some(0.0)).filter(|_| warms_up && !done);
        if cloth.inputs.warmed.is_none()
            && cloth.inputs.active
            && !cloth.inputs.asleep
            && let Some(island) = cloth.island()
        {
            let count = is_shown.len().max(island + 1);
            is_shown.resize(count, false);
            is_shown[island] = true;
        }
    }
    let keeps_time = |cloth: &WarmingItem| {
        let beside = cloth.island().is_some_and(|island| is_shown.get(island).copied().unwrap_or(false));
        let bounds = cloth.place.bounds;
        let bears = || bounds.is_none_or(|bounds| bears(cloth.entity, bounds, cloth.layers, &cloth.inputs, &bodies));
        cloth.report.substeps == 0 || beside || bears()
    };
    let mut work = 0.0;
    for cloth in &mut cloths {
        if cloth.inputs.warmed.is_some() && cloth.inputs.active && !keeps_time(&cloth) {
            work += cloth.work();
        }
    }
    for mut cloth in &mut cloths {
        let (dt, Some(warmed)) = (cloth.by_clock(&time), cloth.inputs.warmed) else { continue };
        if cloth.inputs.active && dt > 0.0 {
            let longest = (SLICE / work).min(cloth.inputs.stepping.max_frame).min(cloth.left());
            let frame = if keeps_time(&cloth) { dt } else { longest.max(dt) };
            (cloth.inputs.warmed, cloth.inputs.pace) = (Some(warmed + frame), frame / dt);
        }
    }
}

/// What the visibility was of what a warm-up hides.
#[derive(Component, Clone)]
pub(crate) struct ShownAfter(Visibility);

/// Entities that may show a cloth that warms up, and those that did.
type Drawn<'w, 's, 'a> = Query<
    'w,
    's,
    (Entity, &'a mut Visibility, Option<&'a ShownAfter>, Option<&'a ClothPiece>, Option<&'a ClothRenderMesh>),
    Or<(With<ClothWarmUp>, With<ClothPiece>, With<ClothRenderMesh>, With<ShownAfter>)>,
>;

/// Hides cloth that warms up, with what shows it, and shows what was hidden for that.
pub(crate) fn hide(
    mut commands: Commands,
    mut drawn: Drawn,
    cloths: Query<&ClothStatus, (With<Cloth>, With<ClothWarmUp>, Without<ClothDisabled>)>,
) {
    for (entity, mut visibility, before, piece, render_mesh) in &mut drawn {
        let cloth = render_mesh.map(|mesh| mesh.cloth).or(piece.map(|piece| piece.cloth)).unwrap_or(entity);
        let warms_up = cloths.get(cloth).is_ok_and(|status| *status != ClothStatus::Failed);
        match before {
            None if warms_up => {
                commands.entity(entity).try_insert(ShownAfter(*visibility));
                *visibility = Visibility::Hidden;
            }
            Some(ShownAfter(before)) if !warms_up => {
                commands.entity(entity).try_remove::<ShownAfter>();
                // Another one is what the app wants.
                if *visibility == Visibility::Hidden {
                    *visibility = *before;
                }
            }
            _ => {}
        }
    }
}
