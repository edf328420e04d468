//! Prepare: what each cloth is given in this frame: settings, carrier, anchors, bodies, wind.

use bevy::prelude::*;

use super::skeleton::joint_of;
use crate::bind::{Placement, ramp_weights};
use crate::components::{
    Cloth, ClothBlend, ClothBuildReport, ClothCollisionLayers, ClothDrive, ClothGlobalWind, ClothGravity, ClothInertia,
    ClothLimits, ClothLod, ClothMaterial, ClothPins, ClothReport, ClothSkipFrame, ClothSolver, ClothUntangling, ClothWarmUp,
    ClothWind, ClothWindZone, ClothWindZoneShape,
};
use crate::notices::{Notices, label};
use crate::simulation::{Bones, ClothInputs, ClothParticles, ClothRest, WorldAir, WorldBodies, WorldBody, is_near, reaches};
use crate::solver::body::{Body, Pose};
use crate::solver::skinned::{AvoidBuffers, Surroundings};
use crate::solver::state::ClothState;
use crate::solver::wind::{self, Turbulence, Wind, ZoneMode, ZoneShape};
use crate::time::ClothTime;

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
    notices.clamped_in::<ClothGlobalWind>(checked);
    checked.clear();
    *pull = gravity.checked(checked);
    notices.clamped_in::<ClothGravity>(checked);
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
            (Option<&ClothLimits>, Option<&ClothDrive>, Option<&ClothInertia>, Option<&ClothBlend>, Option<&ClothWarmUp>),
            Option<&ClothWind>,
            &ClothBuildReport,
            &mut ClothInputs,
            &mut ClothReport,
        ),
        With<Cloth>,
    >,
    time: Res<ClothTime>,
) {
    for (
        entity,
        name,
        material,
        solver,
        pins,
        untangle,
        skip,
        lod,
        (limits, drive, inertia, blend, warm_up),
        own_wind,
        build,
        mut inputs,
        mut report,
    ) in &mut cloths
    {
        let inputs = &mut *inputs;
        let checked = &mut inputs.checked;
        checked.clear();
        let fabric = material.fabric(checked);
        inputs.time_scale = solver.time_scale(checked) * inputs.pace;
        if let Some(warm_up) = warm_up {
            warm_up.checked(checked);
        }
        let dt = time.delta_secs() * inputs.time_scale;
        let before = inputs.fabric.prepared();
        let tuned = inputs.ramp.advance(&mut inputs.fabric, &fabric, dt, report.worst_edge);
        let [moved, turned] = ramp_weights(&mut inputs.anchors, &inputs.sets.weights, dt);
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
        inputs.avoids_bodies = limits.is_none_or(|limits| limits.avoid_bodies);
        inputs.blend = blend.map_or_else(ClothBlend::default, |blend| blend.checked(checked));
        skinned.damping_ratio = drive.map_or(1.0, |drive| drive.checked(checked));
        inputs.followed.advance(dt, skinned);
        inputs.inertia = inertia.map(|inertia| inertia.checked(checked));
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
        let faded = inputs.fade;
        inputs.advance_fade(time.delta_secs() * inputs.pace);
        inputs.tuned |= inputs.fade != faded;
        inputs.skinned.scale *= inputs.fade;
        if build.without_warp == build.faces && material.is_directed() && notices.first(entity, "warp") {
            warn!(
                "cloth {} is to be stiffer along its warp (`bend_ratio`, `stretch_ratio`), and no texture coordinates tell where that is: it is as stiff in all \
                 directions; unwrap its mesh (`Mesh::ATTRIBUTE_UV_0`), or set the ratios to 1",
                label(entity, name),
            );
        }
    }
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
        ClothWindZoneShape::Cuboid { half_size } => ClothWindZoneShape::Cuboid { half_size: half_size * scale },
        ClothWindZoneShape::Sphere { radius } => ClothWindZoneShape::Sphere { radius: radius * scale.max_element() },
    };
    ClothWindZone { shape, ..zone }
}

/// Box in the world `[m]` that a cloth may be in during a frame of `dt` `[s]`, from its speed, its anchors and its skin. Its
/// own radius is to spare for wind and bodies. None when the cloth is nowhere.
fn room(inputs: &ClothInputs, particles: &ClothParticles, dt: f32) -> Option<(Vec3, Vec3)> {
    let ClothState { positions, previous, substep, .. } = &particles.sim.state;
    let substeps = if *substep > 0.0 { dt / substep } else { 0.0 };
    let ends = positions.iter().zip(previous).map(|(x, old)| (*x + (*x - *old) * substeps).truncate());
    let targets = inputs.anchors.to.iter().chain(&inputs.skinned.to).copied();
    let points = positions.iter().map(|x| x.truncate()).chain(ends).chain(targets);
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
        (
            Entity,
            &ClothRest,
            &mut ClothParticles,
            Option<&ClothCollisionLayers>,
            &mut ClothInputs,
            // Without one a cloth meets the bodies of this frame all the same.
            Option<&mut ClothReport>,
        ),
        With<Cloth>,
    >,
    bones: Bones,
    mut near: Local<Vec<usize>>,
    mut buffers: Local<AvoidBuffers>,
) {
    // Of characters there are crowds, and none meets the bones of all.
    let crowded = world.bodies.iter().any(|body| body.character.is_some());
    for (entity, rest, mut particles, layers, mut inputs, report) in &mut cloths {
        if inputs.asleep || inputs.carried {
            continue;
        }
        let inputs = &mut *inputs;
        if inputs.is_animated() {
            // It meets nothing.
            inputs.bodies.clear();
            inputs.body_entities.clear();
            continue;
        }
        let layers = layers.copied().unwrap_or_default();
        let origin = particles.origin;
        let pose = |at: &Isometry3d| {
            let translation = (Vec3::from(at.translation).as_dvec3() - origin).as_vec3();
            Pose::from_parts(translation, at.rotation)
        };
        let dt = time.delta_secs() * inputs.time_scale;
        let waited = (inputs.waited * inputs.time_scale).min(inputs.stepping.max_frame);
        let room = if crowded || !air.zones.is_empty() { room(inputs, &particles, dt.max(waited)) } else { None };
        let (character, carried, jumped) = (inputs.character, inputs.carried_by, inputs.jumped);
        let reaches_it = |body: &WorldBody| {
            let own = body.character.is_none() || body.character == character;
            own || room.is_none_or(|(low, high)| is_near(body, low, high))
        };
        // A cloth does not meet the collider on its own entity.
        let meets = |body: &WorldBody| body.entity != entity && layers.touches(body.layers) && reaches_it(body);
        near.clear();
        near.extend((0..world.bodies.len()).filter(|&index| meets(&world.bodies[index])));
        let listed = || near.iter().map(|&index| &world.bodies[index]);
        // In the background a frame may begin long ago. What jumped since begins where it is.
        let waits = inputs.waited > 0.0;
        let known = inputs.body_entities.iter().zip(&inputs.bodies).filter(|_| waits);
        let earlier: Vec<(Entity, [Pose; 2])> = known.map(|(entity, body)| (*entity, [body.from, body.to])).collect();
        let began = |entity: Entity, from: Pose| {
            let stayed = earlier.iter().find(|(known, [_, to])| *known == entity && *to == from);
            stayed.map_or(from, |(_, [began, _])| *began)
        };
        if !inputs.body_entities.iter().copied().eq(listed().map(|body| body.entity)) {
            let number = |before: u32| {
                let entity = inputs.body_entities.get(before as usize)?;
                let now = near.binary_search_by_key(entity, |&index| world.bodies[index].entity).ok()?;
                u32::try_from(now).ok()
            };
            particles.sim.memory.renumber_bodies(number);
            inputs.body_entities.clear();
            inputs.body_entities.extend(listed().map(|body| body.entity));
            inputs.worn.keep(&inputs.body_entities);
        }
        inputs.bodies.clear();
        // What the cloth does not feel of its carrier's motion, it does not feel of bodies either; after a jump, of those of
        // its character.
        let goes_along =
            |body: &WorldBody| body.rigid.is_none() && (!jumped || (character.is_some() && body.character == character));
        let from = |body: &WorldBody| match carried.filter(|_| goes_along(body)) {
            Some(_) if jumped && body.from == body.to => pose(&body.to),
            Some(carried) => pose(&carried.moved(body.from)),
            None => pose(&body.from),
        };
        let ClothInputs { bodies, worn, skin, fabric, crossfade, joints, joints_before, .. } = inputs;
        let faded = skin.as_ref().filter(|_| crossfade.is_active());
        let on_joint = |body: &WorldBody, places: [Pose; 2]| {
            let joint = joint_of(faded?, body.entity, &bones.parents)?;
            crossfade.carry(joint, [joints_before, joints], places)
        };
        bodies.extend(listed().map(|body| {
            let bone = character.is_some() && body.character == character;
            let keep = fabric.thickness + body.margin;
            let places = [from(body), pose(&body.to)];
            let [from, to] = if bone && body.rigid.is_none() { on_joint(body, places).unwrap_or(places) } else { places };
            Body {
                shape: body.shape.clone(),
                from: if body.rigid.is_none() { began(body.entity, from) } else { from },
                to,
                static_friction: body.static_friction,
                dynamic_friction: body.dynamic_friction,
                margin: body.margin,
                // Its place in the world's list, until `couple` makes a slot of it.
                rigid: body.rigid,
                bone,
                snug: skin.as_ref().filter(|_| bone).and_then(|skin| worn.on(body, keep, skin, &bones)),
            }
        }));
        if inputs.avoids_bodies && inputs.skinned.is_active() {
            let ClothInputs { bodies, fabric, skinned, fade, .. } = inputs;
            let positions = &particles.sim.state.positions;
            let around = Surroundings { bodies, rest: &rest.0, fabric, positions, share: *fade };
            skinned.avoid(&around, dt, &mut buffers);
        }
        if let Some(mut report) = report {
            report.bodies = u32::try_from(inputs.bodies.len()).unwrap_or(u32::MAX);
        }
        inputs.wind.origin = origin;
        inputs.wind.zones.clear();
        let blows = |zone, at| room.is_none_or(|(low, high)| reaches(zone, at, low, high));
        let zones = air.zones.iter().filter(|(_, zone, at)| blows(zone, at));
        inputs.wind.zones.extend(zones.map(|(_, zone, at)| wind::WindZone {
            shape: match zone.shape {
                ClothWindZoneShape::Cuboid { half_size } => ZoneShape::Box { half_extents: half_size },
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
    use std::sync::Arc;

    use bevy::ecs::system::RunSystemOnce;
    use bevy::math::{Affine3A, DVec3, Vec4};

    use super::*;
    use crate::bind::AnchorSets;
    use crate::solver::anchors::Anchors;
    use crate::solver::rest::RestShape;

    /// Numbers of the zones that reach a particle at `at` with the velocity `velocity` `[m/s]` in a frame of 0.1 s.
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
        let particles = ClothParticles::new(state, DVec3::new(100.0, 0.0, 0.0));
        let cloth = world.spawn((Cloth, ClothRest(Arc::new(RestShape::default())), inputs, particles)).id();
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
