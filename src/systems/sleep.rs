//! Sleep: a cloth at rest is left alone until something happens to it.
//!
//! ```text
//! Prepare   watch   anything new around a cloth? ─► its rest begins anew; it wakes, and with it its island
//! Respond   doze    at rest for long enough, and so is its island ─► it sleeps
//! ```

use bevy::ecs::batching::BatchingStrategy;
use bevy::ecs::query::QueryData;
use bevy::ecs::system::SystemParam;
use bevy::math::DVec3;
use bevy::prelude::*;

use crate::components::checked::Checked;
use crate::components::{
    Cloth, ClothCollision, ClothCollisionLayers, ClothReport, ClothSleep, ClothSleepDisabled, ClothSlept, ClothSolver,
    ClothUntangling, ClothUntanglingDisabled, ClothWindZone, ClothWoke,
};
use crate::islands::{ClothIslands, Member};
use crate::notices::Notices;
use crate::simulation::{
    ClothInputs, ClothParticles, ClothRest, IslandPlace, NEAR, STILL, Seen, SeenBody, Slumber, WorldAir, WorldBodies,
    WorldBody, is_near, reaches, stays,
};
use crate::solver::sim::ClothSim;
use crate::time::ClothTime;

/// What there is in the world that may wake a cloth.
#[derive(SystemParam)]
pub(crate) struct Around<'w> {
    bodies: Res<'w, WorldBodies>,
    air: Res<'w, WorldAir>,
}

/// A cloth that may sleep.
#[derive(QueryData)]
#[query_data(mutable)]
pub(crate) struct Sleeper {
    entity: Entity,
    name: Option<&'static Name>,
    solver: Ref<'static, ClothSolver>,
    collision: Ref<'static, ClothCollision>,
    untangle: Ref<'static, ClothUntangling>,
    sleep: Ref<'static, ClothSleep>,
    kept_awake: Has<ClothSleepDisabled>,
    not_untangled: Has<ClothUntanglingDisabled>,
    layers: Option<&'static ClothCollisionLayers>,
    rest: &'static ClothRest,
    inputs: &'static mut ClothInputs,
    particles: &'static mut ClothParticles,
    place: &'static IslandPlace,
    slumber: &'static mut Slumber,
    report: &'static mut ClothReport,
}

impl SleeperReadOnlyItem<'_, '_> {
    /// Whether it is paused, was stopped, or stands still for being far away; not while it is carried from one place to
    /// another.
    fn is_still(&self) -> bool {
        (self.inputs.time_scale == 0.0 && !self.inputs.rode) || self.particles.sim.recovery.is_frozen()
    }
}

/// Looks for what is new around every cloth, and wakes those that it concerns.
pub(crate) fn watch(
    mut commands: Commands,
    around: Around,
    mut islands: ResMut<ClothIslands>,
    mut notices: ResMut<Notices>,
    mut cloths: Query<Sleeper, With<Cloth>>,
    mut checked: Local<Checked>,
) {
    for mut cloth in &mut cloths {
        checked.clear();
        let ClothSleep { threshold, delay } = cloth.sleep.checked(&mut checked);
        notices.clamped(cloth.entity, cloth.name, "cloth", &checked);
        let slumber = &mut *cloth.slumber;
        (slumber.threshold, slumber.delay) = (if cloth.kept_awake { 0.0 } else { threshold }, delay);
        let disabled = [cloth.kept_awake, cloth.not_untangled];
        let changed = core::mem::replace(&mut slumber.disabled, disabled) != disabled
            || cloth.solver.is_changed()
            || cloth.collision.is_changed()
            || cloth.untangle.is_changed()
            || cloth.sleep.is_changed()
            || cloth.inputs.stale
            || cloth.inputs.tuned
            || !cloth.inputs.active
            // In the background it is prepared there.
            || !(cloth.inputs.background || cloth.particles.sim.memory.is_prepared_for(&cloth.rest.0))
            || core::mem::take(&mut cloth.particles.disturbed)
            || core::mem::take(&mut slumber.roused);
        let layers = cloth.layers.copied().unwrap_or_default();
        // What is carried along and awake does not rest: what is new around it is seen when it is simulated again.
        let looks = slumber.asleep || !(cloth.inputs.carried || cloth.inputs.is_animated());
        let news = looks && slumber.seen.update(cloth.entity, &cloth.inputs, layers, cloth.place.bounds, &around);
        if changed || news {
            slumber.quiet_for = 0.0;
            slumber.marks.clear();
        }
        if slumber.asleep && (changed || news || !cloth.inputs.asleep) {
            wake(&mut commands, &mut cloth);
        }
    }
    for island in islands.list.iter_mut().filter(|island| island.asleep) {
        let sleeps = |entity: Entity| cloths.get(entity).is_ok_and(|cloth| cloth.slumber.asleep || cloth.is_still());
        if island.members.iter().all(|member| sleeps(member.entity)) {
            continue;
        }
        island.asleep = false;
        for member in &island.members {
            if let Ok(mut cloth) = cloths.get_mut(member.entity)
                && cloth.slumber.asleep
            {
                wake(&mut commands, &mut cloth);
            }
        }
    }
}

fn wake(commands: &mut Commands, cloth: &mut SleeperItem) {
    cloth.slumber.asleep = false;
    cloth.slumber.quiet_for = 0.0;
    cloth.slumber.marks.clear();
    cloth.inputs.asleep = false;
    cloth.report.asleep = false;
    commands.trigger(ClothWoke { entity: cloth.entity });
}

impl Seen {
    /// Takes in what there is now; whether it differs from what there was.
    fn update(
        &mut self,
        entity: Entity,
        inputs: &ClothInputs,
        layers: ClothCollisionLayers,
        bounds: Option<(DVec3, DVec3)>,
        around: &Around,
    ) -> bool {
        let wind = &inputs.wind;
        let air = Some((wind.velocity, wind.density, wind.turbulence));
        let mut news = self.gravity != inputs.gravity || self.air != air || self.layers != layers;
        (self.gravity, self.air, self.layers) = (inputs.gravity, air, layers);
        let still = |(a, b): (&Vec3, &Vec3)| a.distance(*b) <= STILL;
        if self.anchors.len() != inputs.anchors.to.len() || !self.anchors.iter().zip(&inputs.anchors.to).all(still) {
            self.anchors.clone_from(&inputs.anchors.to);
            news = true;
        }
        let Some((low, high)) = bounds.map(|(low, high)| (low.as_vec3(), high.as_vec3())) else { return true };
        let keep = inputs.fabric.thickness + NEAR;
        let near = || {
            let others = around.bodies.bodies.iter().filter(|b| b.entity != entity && layers.touches(b.layers));
            others.filter(|body| is_near(body, low - keep, high + keep))
        };
        let taker = |body: &WorldBody| around.bodies.taker(body);
        let mut known = self.bodies.iter();
        let same = near().all(|body| known.next().is_some_and(|seen| seen.is(body, taker(body)))) && known.next().is_none();
        if !same {
            self.bodies.clear();
            self.bodies.extend(near().map(|body| SeenBody::of(body, taker(body))));
            news = true;
        }
        let blows = || around.air.zones.iter().filter(|(_, zone, at)| reaches(zone, at, low, high));
        let same =
            |((e, zone, at), (f, seen, was)): (&(Entity, ClothWindZone, Isometry3d), &(Entity, ClothWindZone, Isometry3d))| {
                e == f && zone == seen && stays(at, was)
            };
        if blows().count() != self.zones.len() || !blows().zip(&self.zones).all(same) {
            self.zones.clear();
            self.zones.extend(blows().copied());
            news = true;
        }
        let windy = wind.velocity != Vec3::ZERO || self.zones.iter().any(|(_, zone, _)| zone.velocity != Vec3::ZERO);
        news || (windy && wind.density > 0.0 && wind.turbulence.intensity > 0.0)
    }
}

/// Lets those sleep that have been at rest for long enough, islands as a whole.
pub(crate) fn doze(
    mut commands: Commands,
    time: Res<ClothTime>,
    mut islands: ResMut<ClothIslands>,
    mut cloths: Query<Sleeper, With<Cloth>>,
) {
    let dt = time.delta_secs();
    let list = &islands.list;
    cloths.par_iter_mut().batching_strategy(BatchingStrategy::new().batches_per_thread(5)).for_each(|mut cloth| {
        if !cloth.slumber.asleep {
            let done = cloth.place.island.and_then(|(island, _)| list.get(island as usize)?.background.done);
            rest(&mut cloth, done.unwrap_or(dt));
        }
    });
    for island in islands.list.iter_mut().filter(|island| !island.asleep) {
        let rests = |m: &Member| cloths.get(m.entity).is_ok_and(|cloth| cloth.slumber.ready || cloth.is_still());
        island.asleep = island.members.iter().all(rests);
        if island.asleep {
            for member in &island.members {
                if let Ok(mut cloth) = cloths.get_mut(member.entity)
                    && cloth.slumber.ready
                {
                    fall_asleep(&mut commands, &mut cloth);
                }
            }
        }
    }
    for mut cloth in &mut cloths {
        if cloth.slumber.ready && cloth.place.island.is_none() {
            fall_asleep(&mut commands, &mut cloth);
        }
    }
}

/// Measures how long a cloth has been at rest, by its own clock. One that gives a body something bears a load: asleep it would
/// let go of it.
fn rest(cloth: &mut SleeperItem, dt: f32) {
    let slumber = &mut *cloth.slumber;
    let dt = dt * cloth.inputs.time_scale;
    if dt == 0.0 || cloth.inputs.under_way {
        // What is paused, or stepped in the background, may be in flight.
        slumber.ready = false;
        return;
    }
    let positions = &cloth.particles.sim.state.positions;
    let whole = cloth.report.crossings == 0 && cloth.particles.sim.display.held().is_none();
    let free = cloth.inputs.active
        && whole
        && cloth.particles.sim.memory.is_prepared_for(&cloth.rest.0)
        && slumber.threshold > 0.0
        && !cloth.inputs.coupled.gives();
    let limit = slumber.threshold * slumber.delay;
    let near = |(x, mark): (&Vec4, &Vec3)| x.truncate().distance_squared(*mark) <= limit * limit;
    let rests = free && slumber.marks.len() == positions.len() && positions.iter().zip(&slumber.marks).all(near);
    if rests {
        slumber.quiet_for += dt;
    } else {
        slumber.quiet_for = 0.0;
        slumber.marks.clear();
        slumber.marks.extend(positions.iter().map(|x| x.truncate()));
    }
    slumber.ready = rests && slumber.quiet_for >= slumber.delay;
}

fn fall_asleep(commands: &mut Commands, cloth: &mut SleeperItem) {
    cloth.slumber.ready = false;
    if core::mem::replace(&mut cloth.slumber.asleep, true) {
        return;
    }
    cloth.inputs.asleep = true;
    // It wakes without the speed it had.
    let ClothParticles { sim: ClothSim { state, .. }, before, .. } = &mut *cloth.particles;
    state.previous.clone_from(&state.positions);
    before.clear();
    cloth.report.asleep = true;
    cloth.report.idle();
    commands.trigger(ClothSlept { entity: cloth.entity });
}
