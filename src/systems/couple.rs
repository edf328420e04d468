//! What cloth gives bodies: who takes it (Prepare), and their sums (Integrate).

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use super::release::forget;
use crate::components::fitted::{ColliderBody, CoupledBody};
use crate::components::{Cloth, ClothCoupling, ClothReaction, ClothRigidBody};
use crate::notices::Notices;
use crate::simulation::{ClothInputs, ClothParticles, WorldBodies, WorldRigid, jumped};
use crate::solver::couple::{Reaction, Rigid};
use crate::time::ClothTime;

/// Finds the entity that takes what is done to another: itself or the nearest ancestor that says so.
#[derive(SystemParam)]
pub(crate) struct Takers<'w, 's> {
    couplings: Query<'w, 's, &'static ClothCoupling>,
    parents: Query<'w, 's, &'static ChildOf>,
}

impl Takers<'_, '_> {
    fn of(&self, entity: Entity) -> Option<Entity> {
        let mut at = entity;
        loop {
            match self.couplings.get(at) {
                Ok(ClothCoupling::TwoWay) => return Some(at),
                Ok(ClothCoupling::OneWay) => return None,
                Err(_) => at = self.parents.get(at).ok()?.parent(),
            }
        }
    }
}

/// Lists the bodies that take part, and tells colliders which is theirs.
pub(crate) fn bodies(
    time: Res<ClothTime>,
    mut world: ResMut<WorldBodies>,
    mut notices: ResMut<Notices>,
    takers: Takers,
    mut coupled: Query<(
        Entity,
        Option<&Name>,
        &ClothCoupling,
        &ClothRigidBody,
        &GlobalTransform,
        &mut CoupledBody,
        &mut ClothReaction,
    )>,
) {
    let WorldBodies { bodies, rigids, checked } = &mut *world;
    rigids.clear();
    let dt = time.delta_secs();
    for (entity, name, coupling, rigid, global, mut body, mut reaction) in &mut coupled {
        let (_, rotation, translation) = global.to_scale_rotation_translation();
        if *coupling == ClothCoupling::OneWay || !(rotation.is_finite() && translation.is_finite()) {
            *body = CoupledBody::default();
            // It is given nothing any more: an impulse that stays would be taken over in every frame.
            reaction.set_if_neq(ClothReaction::default());
            continue;
        }
        let to = Isometry3d::new(translation, rotation.normalize());
        let known = body.pose.filter(|from| !jumped(from, &to, 0.0, dt));
        let from = known.unwrap_or(to);
        body.pose = Some(to);
        checked.clear();
        rigids.push(in_world(entity, &rigid.checked(checked), from, to, known.is_some(), body.givers));
        notices.clamped(entity, name, "coupled body", checked);
    }
    rigids.sort_unstable_by_key(|rigid| rigid.entity);
    if rigids.is_empty() {
        return;
    }
    for body in bodies {
        let taker = takers.of(body.entity);
        body.rigid = taker.and_then(|taker| index_of(rigids, taker));
    }
}

fn in_world(entity: Entity, rigid: &ClothRigidBody, from: Isometry3d, to: Isometry3d, known: bool, givers: u32) -> WorldRigid {
    let axes = Mat3::from_quat(to.rotation);
    WorldRigid {
        entity,
        from: from * rigid.center_of_mass,
        to: to * rigid.center_of_mass,
        velocity: rigid.velocity.filter(|_| known),
        inverse_mass: rigid.inverse_mass,
        inverse_inertia: axes * rigid.inverse_inertia * axes.transpose(),
        own_inertia: rigid.inverse_inertia,
        center_of_mass: rigid.center_of_mass,
        givers,
        given: Reaction::default(),
        gave: 0,
    }
}

fn index_of(rigids: &[WorldRigid], entity: Entity) -> Option<u32> {
    rigids.binary_search_by_key(&entity, |rigid| rigid.entity).ok().and_then(|i| u32::try_from(i).ok())
}

/// Tells each cloth which bodies take what it gives, and which of its pins are on them.
pub(crate) fn couple(
    world: Res<WorldBodies>,
    takers: Takers,
    mut cloths: Query<(Entity, &mut ClothParticles, &mut ClothInputs), With<Cloth>>,
) {
    for (entity, mut particles, mut inputs) in &mut cloths {
        let ClothInputs { asleep, carried, bodies, sets, skin, coupled, stale, .. } = &mut *inputs;
        let origin = particles.origin;
        let coupling = particles.sim.memory.coupling_mut();
        coupling.clear();
        coupled.begin();
        for body in bodies.iter_mut() {
            // The bodies of a cloth that sleeps or is carried along are those of an older frame. Their places now belong to
            // others, or to none.
            body.rigid = body.rigid.filter(|_| !*asleep && !*carried).map(|index| coupled.slot_of(index));
        }
        if !world.rigids.is_empty() {
            for (set, at) in sets.sets.iter().enumerate() {
                let Some(holder) = at.target.or_else(|| skin.is_none().then_some(entity)) else { continue };
                if let Some(index) = takers.of(holder).and_then(|taker| index_of(&world.rigids, taker)) {
                    let slot = coupled.slot_of(index);
                    coupled.pinned.push((set as u32, slot));
                }
            }
        }
        for &index in &coupled.rigids {
            let body = &world.rigids[index as usize];
            let others = body.givers.saturating_sub(u32::from(coupled.gave.contains(&body.entity)));
            let share = (others + 1) as f32;
            coupled.shares.push(share);
            let seen = |at: Vec3| (at.as_dvec3() - origin).as_vec3();
            let rigid = Rigid {
                inverse_mass: body.inverse_mass * share,
                inverse_inertia: body.inverse_inertia * share,
                from: seen(body.from),
                to: seen(body.to),
                velocity: body.velocity,
            };
            coupling.add(rigid);
        }
        coupled.gave.clear();
        for &(set, slot) in &coupled.pinned {
            for (anchor, _) in sets.set_of.iter().enumerate().filter(|(_, of)| **of == set) {
                coupling.hold(anchor as u32, slot);
            }
        }
        // Pins on a movable body weigh what it does.
        if coupled.pins_changed(&world.rigids) {
            *stale = true;
        }
    }
}

/// Adds up what the cloths gave each body, in the order of entities, and moves what remembers where the bodies are.
pub(crate) fn give(
    time: Res<ClothTime>,
    mut world: ResMut<WorldBodies>,
    mut order: Local<Vec<Entity>>,
    mut cloths: Query<(Entity, &ClothParticles, &mut ClothInputs), With<Cloth>>,
    mut takers: Query<(&mut ClothReaction, &mut CoupledBody)>,
    mut colliders: Query<&mut ColliderBody>,
) {
    let WorldBodies { bodies, rigids, .. } = &mut *world;
    if rigids.is_empty() {
        return;
    }
    order.clear();
    order.extend(cloths.iter().map(|(entity, ..)| entity));
    order.sort_unstable();
    for &entity in &*order {
        let Ok((_, particles, mut inputs)) = cloths.get_mut(entity) else { continue };
        let coupled = &mut inputs.coupled;
        for (slot, (&index, &share)) in (0..).zip(coupled.rigids.iter().zip(&coupled.shares)) {
            let given = particles.sim.memory.coupling().given(slot);
            let finite = given.linear.is_finite() && given.angular.is_finite() && given.shift.is_finite();
            let Some(body) = rigids.get_mut(index as usize).filter(|_| finite && given != Reaction::default()) else {
                continue;
            };
            let Reaction { linear, angular, shift, turn } = &mut body.given;
            *linear += given.linear;
            *angular += given.angular;
            *shift += given.shift / share;
            *turn = (Quat::IDENTITY.lerp(given.turn, 1.0 / share) * *turn).normalize();
            body.gave += 1;
            coupled.gave.push(body.entity);
        }
    }
    let duration = time.delta_secs();
    for rigid in rigids.iter() {
        let Ok((mut reaction, mut body)) = takers.get_mut(rigid.entity) else { continue };
        let Reaction { linear, angular, shift, turn } = rigid.given;
        reaction.set_if_neq(ClothReaction { linear, angular, displacement: shift, turn, duration });
        body.givers = rigid.gave;
        body.pose = body.pose.map(|pose| rigid.moved(pose));
    }
    for body in bodies.iter().filter(|body| body.rigid.is_some()) {
        let rigid = body.rigid.and_then(|index| rigids.get(index as usize)).filter(|rigid| rigid.is_moved());
        if let (Some(rigid), Ok(mut collider)) = (rigid, colliders.get_mut(body.entity)) {
            collider.pose = collider.pose.map(|pose| rigid.moved(pose));
        }
    }
    for (_, particles, mut inputs) in &mut cloths {
        let origin = particles.origin;
        let ClothInputs { coupled, anchors, sets, .. } = &mut *inputs;
        for &(set, slot) in &coupled.pinned {
            let rigid = coupled.rigids.get(slot as usize).and_then(|&index| rigids.get(index as usize));
            let Some(rigid) = rigid.filter(|rigid| rigid.is_moved()) else { continue };
            let center = (rigid.to.as_dvec3() - origin).as_vec3();
            for (to, _) in anchors.to.iter_mut().zip(&sets.set_of).filter(|(_, of)| **of == set) {
                *to = center + rigid.given.shift + rigid.given.turn * (*to - center);
            }
        }
    }
}

/// Nothing is given while cloth does not move: an impulse that stays would be taken over again.
pub(crate) fn rest(mut takers: Query<&mut ClothReaction>) {
    for mut reaction in &mut takers {
        reaction.set_if_neq(ClothReaction::default());
    }
}

/// Forgets the warnings about a body.
pub(crate) fn on_remove_coupling(removed: On<Remove, ClothCoupling>, mut commands: Commands) {
    forget(&mut commands, removed.entity);
    if let Ok(mut entity) = commands.get_entity(removed.entity) {
        entity.try_remove::<(CoupledBody, ClothReaction)>();
    }
}
