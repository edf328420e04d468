//! Prepare: what each cloth is given in this frame: settings, carrier, anchors, bodies, wind.

use bevy::math::DVec3;
use bevy::prelude::*;

use crate::bind::{AnchorSet, Placement, Transforms, slew_weights};
use crate::components::{
    Cloth, ClothBuildReport, ClothCollisionLayers, ClothDrive, ClothGlobalWind, ClothGravity, ClothLimits, ClothLod,
    ClothMaterial, ClothOnTargetLost, ClothPins, ClothReport, ClothSkipFrame, ClothSolver, ClothTargetLost, ClothTeleportMode,
    ClothTeleported, ClothUntangling, ClothWind, ClothWindZone, ClothWindZoneShape,
};
use crate::notices::{Notices, label};
use crate::schedule::ClothClock;
use crate::simulation::{
    ClothInputs, ClothParticles, ClothRest, TELEPORT_SPEED, TELEPORT_SPIN, WorldAir, WorldBodies, WorldBody, reaches,
};
use crate::solver::body::{Body, Pose};
use crate::solver::state::ClothState;
use crate::solver::wind::{self, Turbulence, Wind, ZoneMode, ZoneShape};
use crate::time::ClothTime;

/// Distance from the origin of the frame at which it is moved along `[m]`. A substep of free fall adds 4e-5 m to a position: at 2 m that is 180
/// units in the last place, at 16 m only 22.
const REBASE: f32 = 2.0;

/// Reads global wind, gravity and zones, and lets the gusts travel.
pub(crate) fn air(
    time: Res<ClothTime>,
    wind: Res<ClothGlobalWind>,
    gravity: Res<ClothGravity>,
    mut air: ResMut<WorldAir>,
    mut notices: ResMut<Notices>,
    zones: Query<(Entity, Option<&Name>, &ClothWindZone, &GlobalTransform)>,
) {
    let WorldAir { wind: air, gravity: pull, zones: known, checked } = &mut *air;
    checked.clear();
    blow(air, &wind.checked(checked));
    *pull = gravity.checked(checked);
    notices.clamped(Entity::PLACEHOLDER, None, "the world", checked);
    air.advance(time.delta_secs());
    known.clear();
    for (entity, name, zone, global) in &zones {
        checked.clear();
        let zone = zone.checked(checked);
        if let Some(placement) = Placement::of(&global.affine()) {
            known.push((entity, scaled(zone, global.scale().abs()), placement.isometry()));
        }
        notices.clamped(entity, name, "wind zone", checked);
    }
    known.sort_unstable_by_key(|(entity, ..)| *entity);
}

/// Settings in SI that the solver can use.
pub(crate) fn settings(
    air: Res<WorldAir>,
    mut notices: ResMut<Notices>,
    mut cloths: Query<
        (
            Entity,
            Option<&Name>,
            &ClothMaterial,
            &ClothSolver,
            &ClothPins,
            &ClothUntangling,
            &ClothSkipFrame,
            Option<&ClothLod>,
            (Option<&ClothLimits>, Option<&ClothDrive>),
            Option<&ClothWind>,
            &ClothBuildReport,
            &mut ClothInputs,
            &mut ClothReport,
        ),
        With<Cloth>,
    >,
    time: Res<ClothTime>,
) {
    for (entity, name, material, solver, pins, untangle, skip, lod, (limits, drive), own_wind, build, mut inputs, mut report) in
        &mut cloths
    {
        let inputs = &mut *inputs;
        let checked = &mut inputs.checked;
        checked.clear();
        let fabric = material.fabric(checked);
        inputs.time_scale = solver.time_scale(checked);
        let dt = time.delta_secs() * inputs.time_scale;
        let before = inputs.fabric.prepared();
        let tuned = inputs.slew.advance(&mut inputs.fabric, &fabric, dt, report.worst_edge);
        let [moved, turned] = slew_weights(&mut inputs.anchors, &inputs.sets.weights, dt);
        inputs.tuned = tuned || moved;
        inputs.stale |= turned || before != inputs.fabric.prepared();
        inputs.stepping = solver.stepping(checked);
        inputs.limits = solver.limits(checked);
        inputs.untangle = untangle.settings(checked);
        inputs.evaluate = skip.settings(checked);
        let scale = inputs.followed.scale;
        let skinned = &mut inputs.skinned;
        (skinned.backstop_radius, skinned.scale) = limits.map_or((scale, 1.0), |limits| {
            let (radius, distances) = limits.checked(checked);
            (radius * scale, distances)
        });
        skinned.damping_ratio = drive.map_or(1.0, |drive| drive.checked(checked));
        inputs.followed.advance(dt, skinned);
        inputs.lod = lod.map(|lod| lod.checked(checked));
        inputs.teleport = solver.teleport_limits(checked);
        inputs.gravity = solver.gravity(air.gravity, checked);
        pins.checked(checked);
        let zones = core::mem::take(&mut inputs.wind.zones);
        match own_wind {
            Some(own) => {
                let travel = inputs.wind.travel;
                inputs.wind = Wind { travel, time: air.wind.time, ..air.wind.clone() };
                blow(&mut inputs.wind, &own.0.checked(checked));
                inputs.wind.travel += inputs.wind.velocity.as_dvec3() * time.delta_secs_f64();
            }
            None => inputs.wind = air.wind.clone(),
        }
        inputs.wind.zones = zones;
        if report.clamped != checked.clamped {
            report.clamped.clone_from(&checked.clamped);
        }
        notices.clamped(entity, name, "cloth", checked);
        if build.without_warp == build.faces && material.is_directed() && notices.first(entity, "warp") {
            warn!(
                "cloth {} is to be stiffer along its warp (`bend_ratio`, `stretch_ratio`), and no texture coordinates tell where that is: it is as stiff in all \
                 directions; unwrap its mesh (`Mesh::ATTRIBUTE_UV_0`), or set the ratios to 1",
                label(entity, name),
            );
        }
    }
}

/// Moves what carries the cloth: its anchors, and after a jump the cloth itself.
pub(crate) fn anchors(
    mut commands: Commands,
    time: Res<ClothTime>,
    clock: Res<ClothClock>,
    transforms: Transforms,
    mut cloths: Query<
        (Entity, &ClothRest, &ClothSolver, &ClothPins, &mut ClothInputs, &mut ClothParticles, &mut ClothReport),
        With<Cloth>,
    >,
) {
    let dt = time.delta_secs();
    for (entity, rest, solver, pins, mut inputs, mut particles, mut report) in &mut cloths {
        let (inputs, particles) = (&mut *inputs, &mut *particles);
        if !inputs.active || (inputs.time_scale == 0.0 && !inputs.carried) {
            continue;
        }
        if follow_targets(&mut commands, &transforms, entity, pins, inputs) {
            commands.entity(entity).try_despawn();
            continue;
        }
        let pinned = u32::try_from(inputs.anchors.particles.len()).unwrap_or(u32::MAX);
        if report.pinned != pinned {
            report.pinned = pinned;
        }
        inputs.rode = inputs.carried && ride(inputs, particles, clock.interpolates);
        if inputs.carried {
            continue;
        }
        let jump = jump(inputs, particles, solver, dt);
        if let Some(jump) = &jump {
            if solver.teleport == ClothTeleportMode::Keep {
                carry(jump, inputs, particles);
            }
            commands.trigger(ClothTeleported { entity, distance: jump.distance, angle: jump.angle });
        }
        rebase(inputs, particles);
        if let Some(skin) = inputs.skin.take() {
            skin.matrices(&transforms, particles.origin, &mut inputs.joints);
            inputs.skin = Some(skin);
        }
        inputs.aim(particles.origin);
        inputs.follow(&rest.0, particles.origin);
        if jump.is_some() && solver.teleport == ClothTeleportMode::Reset {
            particles.place(inputs.pose(&rest.0, particles.origin));
            inputs.stay();
        }
    }
}

/// Reads where the targets are. True when one is gone and the cloth is to go with it.
fn follow_targets(
    commands: &mut Commands,
    transforms: &Transforms,
    entity: Entity,
    pins: &ClothPins,
    inputs: &mut ClothInputs,
) -> bool {
    let own = AnchorSet::own(&inputs.placement);
    let mut released = false;
    for set in &mut inputs.sets.sets {
        let Some(target) = set.target else {
            set.at = own.at;
            continue;
        };
        match transforms.get(target) {
            Ok(global) => {
                set.lost = false;
                // A target that is flat or not finite holds where it was.
                if Placement::of(&global.affine()).is_some() {
                    set.at = global.affine();
                }
            }
            Err(_) if set.lost => {}
            Err(_) => {
                set.lost = true;
                commands.trigger(ClothTargetLost { entity, target });
                match pins.on_target_lost {
                    ClothOnTargetLost::Hold => {}
                    ClothOnTargetLost::Release => {
                        set.released = true;
                        released = true;
                    }
                    ClothOnTargetLost::Despawn => return true,
                }
            }
        }
    }
    if released {
        inputs.drop_released();
    }
    false
}

/// A carrier that moved too far in a frame to have been there in between.
struct Jump {
    from: Isometry3d,
    to: Isometry3d,
    distance: f32,
    angle: f32,
}

impl Jump {
    /// The rigid motion of the jump, as seen from `origin`.
    fn motion(&self, origin: DVec3) -> impl Fn(Vec3) -> Vec3 + use<> {
        let seen = |at: &Isometry3d| (Vec3::from(at.translation).as_dvec3() - origin).as_vec3();
        let (from, to) = (seen(&self.from), seen(&self.to));
        let turn = self.to.rotation * self.from.rotation.inverse();
        move |x| turn * (x - from) + to
    }
}

/// Carries a cloth that stands still along with what it hangs on; whether it went anywhere. One that is pinned nowhere stays.
fn ride(inputs: &mut ClothInputs, particles: &mut ClothParticles, interpolates: bool) -> bool {
    let to = inputs.carrier();
    let from = particles.carrier.replace(to).filter(|from| *from != to && !inputs.anchors.particles.is_empty());
    let mut before = core::mem::take(&mut particles.before);
    before.clear();
    if let Some(from) = from {
        if interpolates {
            before.extend(particles.state.positions.iter().map(|x| x.truncate()));
        }
        carry(&Jump { from, to, distance: 0.0, angle: 0.0 }, inputs, particles);
    }
    particles.before = before;
    if from.is_some() {
        rebase(inputs, particles);
    }
    from.is_some()
}

/// Moves a cloth and its anchors rigidly along.
fn carry(jump: &Jump, inputs: &mut ClothInputs, particles: &mut ClothParticles) {
    let motion = jump.motion(particles.origin);
    particles.carry(&motion);
    inputs.carry(&motion);
    let turn = jump.to.rotation * jump.from.rotation.inverse();
    inputs.skinned.normals_to.iter_mut().for_each(|normal| *normal = turn * *normal);
}

/// Whether the carrier jumped in the last `dt` `[s]`: far and fast. Further than 1 m and three radii, or by more than 60 degrees, by default; and faster than
/// anything that moves legally, since a frame may be long.
fn jump(inputs: &ClothInputs, particles: &mut ClothParticles, solver: &ClothSolver, dt: f32) -> Option<Jump> {
    let to = inputs.carrier();
    let from = particles.carrier.replace(to)?;
    let (least, turn) = inputs.teleport;
    let middle = |at: &Isometry3d| Vec3::from(at.translation) + at.rotation * inputs.center;
    let distance = middle(&from).distance(middle(&to));
    let angle = from.rotation.angle_between(to.rotation);
    // Written so that what is not a number is a jump.
    let far = !(distance <= least.max(3.0 * inputs.radius).max(TELEPORT_SPEED * dt));
    let turned = !(angle <= turn.max(TELEPORT_SPIN * dt));
    ((far || turned) && solver.teleport != ClothTeleportMode::None).then_some(Jump { from, to, distance, angle })
}

/// Moves the frame of simulation along with the cloth, by whole metres, so that numbers stay small and exact.
fn rebase(inputs: &mut ClothInputs, particles: &mut ClothParticles) {
    let Some(first) = particles.state.positions.first().map(|x| x.truncate()) else { return };
    if first.length() <= REBASE.max(2.0 * inputs.radius) || !first.is_finite() {
        return;
    }
    let shift = first.round();
    particles.origin += shift.as_dvec3();
    particles.carry(|x| x - shift);
    inputs.carry(|x| x - shift);
    // A joint that is gone keeps its matrix.
    inputs.joints.iter_mut().for_each(|joint| joint.translation -= Vec3A::from(shift));
}

fn blow(air: &mut Wind, wind: &ClothGlobalWind) {
    air.velocity = wind.velocity;
    air.density = wind.air_density;
    air.turbulence = Turbulence {
        intensity: wind.turbulence,
        length: wind.gust_length,
        frequency: wind.gust_frequency,
        seed: u64::from(wind.seed),
    };
}

/// A zone as its entity's scale makes it.
fn scaled(zone: ClothWindZone, scale: Vec3) -> ClothWindZone {
    let shape = match zone.shape {
        ClothWindZoneShape::Box { half_size } => ClothWindZoneShape::Box { half_size: half_size * scale },
        ClothWindZoneShape::Sphere { radius } => ClothWindZoneShape::Sphere { radius: radius * scale.max_element() },
    };
    ClothWindZone { shape, ..zone }
}

/// Box in the world that a cloth may be in during a frame of `dt` `[s]`, as far as its speed and its anchors tell, with its own radius to spare for
/// what wind and bodies do `[m]`; none when it is nowhere.
fn room(inputs: &ClothInputs, particles: &ClothParticles, dt: f32) -> Option<(Vec3, Vec3)> {
    let ClothState { positions, previous, substep, .. } = &particles.state;
    let substeps = if *substep > 0.0 { dt / substep } else { 0.0 };
    let ends = positions.iter().zip(previous).map(|(x, old)| (*x + (*x - *old) * substeps).truncate());
    let points = positions.iter().map(|x| x.truncate()).chain(ends).chain(inputs.anchors.to.iter().copied());
    let (low, high) = points.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    let spare = Vec3::splat(inputs.radius + inputs.gravity.length() * dt * dt);
    let seen = |p: Vec3| (particles.origin + p.as_dvec3()).as_vec3();
    let (low, high) = (seen(low - spare), seen(high + spare));
    low.cmple(high).all().then_some((low, high))
}

/// Brings bodies, and wind zones that may reach it, into the frame of each cloth.
pub(crate) fn surroundings(
    time: Res<ClothTime>,
    world: Res<WorldBodies>,
    air: Res<WorldAir>,
    mut cloths: Query<
        (Entity, &ClothParticles, Option<&ClothCollisionLayers>, &mut ClothInputs, &mut ClothReport),
        With<Cloth>,
    >,
) {
    for (entity, particles, layers, mut inputs, mut report) in &mut cloths {
        if inputs.asleep || inputs.carried {
            continue;
        }
        let inputs = &mut *inputs;
        let layers = layers.copied().unwrap_or_default();
        let origin = particles.origin;
        let pose = |at: &Isometry3d| {
            let translation = (Vec3::from(at.translation).as_dvec3() - origin).as_vec3();
            Pose::from_parts(translation, at.rotation)
        };
        inputs.bodies.clear();
        // A cloth does not meet the collider on its own entity.
        let meets = |body: &&WorldBody| body.entity != entity && layers.touches(body.layers);
        inputs.body_entities.clear();
        inputs.body_entities.extend(world.bodies.iter().filter(meets).map(|body| body.entity));
        inputs.bodies.extend(world.bodies.iter().filter(meets).map(|body| Body {
            shape: body.shape.clone(),
            from: pose(&body.from),
            to: pose(&body.to),
            static_friction: body.static_friction,
            dynamic_friction: body.dynamic_friction,
            margin: body.margin,
            // Its place in the world's list, until `couple` makes a slot of it.
            rigid: body.rigid,
        }));
        report.bodies = u32::try_from(inputs.bodies.len()).unwrap_or(u32::MAX);
        inputs.wind.origin = origin;
        inputs.wind.zones.clear();
        let dt = time.delta_secs() * inputs.time_scale;
        let room = if air.zones.is_empty() { None } else { room(inputs, particles, dt) };
        let blows = |zone, at| room.is_none_or(|(low, high)| reaches(zone, at, low, high));
        let zones = air.zones.iter().filter(|(_, zone, at)| blows(zone, at));
        inputs.wind.zones.extend(zones.map(|(_, zone, at)| wind::WindZone {
            shape: match zone.shape {
                ClothWindZoneShape::Box { half_size } => ZoneShape::Box { half_extents: half_size },
                ClothWindZoneShape::Sphere { radius } => ZoneShape::Sphere { radius },
            },
            center: (Vec3::from(at.translation).as_dvec3() - origin).as_vec3(),
            rotation: at.rotation,
            velocity: at.rotation * zone.velocity,
            falloff: zone.falloff,
            mode: if zone.replace { ZoneMode::Replace } else { ZoneMode::Add },
        }));
    }
}

#[cfg(test)]
mod tests {
    use bevy::ecs::system::RunSystemOnce;
    use bevy::math::{Affine3A, Vec4};

    use super::*;
    use crate::bind::AnchorSets;
    use crate::solver::anchors::Anchors;
    use crate::solver::island::Display;
    use crate::solver::recover::Recovery;

    /// Numbers of the zones that a particle at `at` with the speed `velocity` `[m/s]` is told of in a frame of 0.1 s.
    fn told(at: Vec3, velocity: Vec3, zones: &[(Vec3, f32)]) -> Vec<usize> {
        let mut world = World::new();
        let mut time = ClothTime::default();
        time.advance_by(core::time::Duration::from_millis(100));
        world.insert_resource(time);
        world.init_resource::<WorldBodies>();
        let zone = |&(at, radius): &(Vec3, f32)| {
            let zone = ClothWindZone::sphere(radius, Vec3::Y * radius);
            (Entity::PLACEHOLDER, zone, Isometry3d::from_translation(at))
        };
        world.insert_resource(WorldAir { zones: zones.iter().map(zone).collect(), ..WorldAir::default() });
        let placement = Placement::of(&Affine3A::IDENTITY).expect("a placement");
        let inputs = ClothInputs::new(placement, 0.5, Anchors::default(), AnchorSets::default(), None, Vec::new());
        let positions: Vec<Vec4> = vec![at.extend(1.0)];
        let previous = vec![(at - velocity * 0.01).extend(1.0)];
        let state = ClothState { positions, previous, substep: 0.01, ..ClothState::default() };
        let particles = ClothParticles {
            state,
            origin: DVec3::new(100.0, 0.0, 0.0),
            before: Vec::new(),
            recovery: Recovery::default(),
            display: Display::default(),
            carrier: None,
            disturbed: false,
        };
        let cloth = world.spawn((Cloth, inputs, particles)).id();
        world.run_system_once(surroundings).expect("a system");
        let seen = &world.get::<ClothInputs>(cloth).expect("inputs").wind.zones;
        seen.iter().filter_map(|seen| zones.iter().position(|(_, radius)| *radius == seen.velocity.y)).collect()
    }

    #[test]
    fn only_zones_that_a_cloth_may_come_to_within_the_frame_are_listed() {
        // At 101 m in the world, with 0.5 m to spare.
        let x = |x: f32, radius: f32| (Vec3::X * x, radius);
        let zones = [x(101.0, 0.1), x(103.0, 1.6), x(103.1, 1.4), x(500.0, 2.0), x(0.0, 90.0), x(0.0, 101.0)];
        assert_eq!(told(Vec3::X, Vec3::ZERO, &zones), [0, 1, 5]);
        // At 3 m/s it comes 0.3 m further.
        assert_eq!(told(Vec3::X, Vec3::X * 3.0, &zones), [0, 1, 2, 5]);
        let nowhere = told(Vec3::NAN, Vec3::ZERO, &zones);
        assert_eq!(nowhere.len(), zones.len(), "a cloth that is nowhere: {nowhere:?}");
    }
}
