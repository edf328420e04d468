//! Prepare: what carries each cloth, and how much of its motion the cloth feels.
//!
//! ```text
//! travel   targets of pins · where the carrier is now · teleports, for a whole character at once
//! inertia  M = T(p0 + (1 - λ) Δp) · Rot((1 - λ) θ) · T(-p0)    moves cloth, pins and bodies along, before anything is felt
//! aim      anchors and skin, from where they were to where they are now
//! ```

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use super::skeleton;
use crate::bind::{AnchorSet, Placement, Skin, Transforms};
use crate::components::{
    Cloth, ClothCharacter, ClothOnTargetLost, ClothPins, ClothReport, ClothSolver, ClothTargetLost, ClothTeleportMode,
    ClothTeleported,
};
use crate::islands::ClothIslands;
use crate::schedule::ClothClock;
use crate::simulation::{
    ClothInputs, ClothParticles, ClothRest, FIRST_FRAMES, IslandPlace, Motion, TELEPORT_SPEED, TELEPORT_SPIN,
};
use crate::time::ClothTime;

/// Distance from the origin of the frame at which it is moved along `[m]`. A substep of free fall adds 4e-5 m to a position.
/// That is 180 units in the last place at 2 m, and only 22 at 16 m.
const REBASE: f32 = 2.0;

/// Who is a character, and what hangs on whom.
#[derive(SystemParam)]
pub(crate) struct Characters<'w, 's> {
    parents: Query<'w, 's, &'static ChildOf>,
    characters: Query<'w, 's, (), With<ClothCharacter>>,
}

impl Characters<'_, '_> {
    /// The nearest of an entity and its ancestors that is a character.
    pub(crate) fn of(&self, entity: Entity) -> Option<Entity> {
        if self.characters.is_empty() {
            return None;
        }
        core::iter::once(entity).chain(self.parents.iter_ancestors(entity)).find(|&at| self.characters.contains(at))
    }

    /// The lowest entity above both a cloth and the joint that carries it. It becomes the character where none was given.
    fn common_ancestor(&self, entity: Entity, joint: Entity) -> Option<Entity> {
        self.parents.iter_ancestors(joint).find(|at| self.parents.iter_ancestors(entity).any(|above| above == *at))
    }
}

/// Finds where what carries each cloth is now. After a jump the cloth goes along, and so do the others of its character.
pub(crate) fn travel(
    mut commands: Commands,
    time: Res<ClothTime>,
    clock: Res<ClothClock>,
    transforms: Transforms,
    characters: Characters,
    mut cloths: Query<(Entity, &ClothSolver, &ClothPins, &mut ClothInputs, &mut ClothParticles, &mut ClothReport), With<Cloth>>,
    mut jumped: Local<Vec<Entity>>,
) {
    let dt = time.delta_secs();
    jumped.clear();
    for (entity, solver, pins, mut inputs, mut particles, mut report) in &mut cloths {
        let (inputs, particles) = (&mut *inputs, &mut *particles);
        (inputs.journey, inputs.jumped, inputs.carried_by) = (None, false, None);
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
        inputs.character = characters.of(entity);
        if let (None, Some(joint)) = (inputs.character, inputs.skin.as_ref().and_then(Skin::main_joint))
            && let Some(root) = characters.common_ancestor(entity, joint)
        {
            commands.entity(root).try_insert(ClothCharacter);
            inputs.character = Some(root);
        }
        let to = inputs.carrier();
        inputs.journey = particles.carrier.replace(to).map(|from| Motion { from, to, center: inputs.center });
        inputs.jumped =
            solver.teleport != ClothTeleportMode::None && inputs.journey.is_some_and(|journey| is_jump(&journey, inputs, dt));
        if inputs.jumped {
            jumped.extend(inputs.character);
        }
    }
    for (entity, solver, _, mut inputs, mut particles, _) in &mut cloths {
        let inputs = &mut *inputs;
        let along = inputs.character.is_some_and(|character| jumped.contains(&character));
        let Some(jump) = inputs.journey.filter(|_| inputs.jumped || along) else { continue };
        if solver.teleport == ClothTeleportMode::None {
            continue;
        }
        (inputs.jumped, inputs.journey) = (true, None);
        if solver.teleport == ClothTeleportMode::Keep {
            carry(&jump, inputs, &mut particles);
            inputs.carried_by = Some(jump);
        }
        commands.trigger(ClothTeleported { entity, distance: jump.distance(), angle: jump.angle() });
    }
}

/// Whether what carries a cloth jumped in the last `dt` `[s]`: far and fast. By default far is more than 1 m and three radii,
/// or more than 60 degrees. Fast is faster than anything that moves legally, since a frame may be long.
fn is_jump(journey: &Motion, inputs: &ClothInputs, dt: f32) -> bool {
    let (least, turn) = inputs.teleport;
    // Written so that what is not a number is a jump.
    let far = !(journey.distance() <= least.max(3.0 * inputs.radius).max(TELEPORT_SPEED * dt));
    far || !(journey.angle() <= turn.max(TELEPORT_SPIN * dt))
}

/// Carries cloths along with the share of the motion of their carrier that they are not to feel. Cloths of a character go along
/// as one. Cloths that can meet a cloth of another character, or one that nothing carries, feel all of it. Only simulated
/// motion may bring them together.
pub(crate) fn inertia(
    time: Res<ClothTime>,
    transforms: Transforms,
    islands: Res<ClothIslands>,
    mut cloths: Query<(Entity, &IslandPlace, &mut ClothInputs, &mut ClothParticles), With<Cloth>>,
    mut shared: Local<Vec<(Entity, Mean)>>,
    mut apart: Local<Vec<bool>>,
) {
    let dt = time.delta_secs();
    let share = |inputs: &ClothInputs| (inputs.stepping.max_frame / (dt * inputs.time_scale)).min(1.0);
    // Frames in the background are cut to what is simulated.
    let is_carried = |inputs: &ClothInputs| inputs.inertia.is_some() || (share(inputs) < 1.0 && !inputs.background);
    if !cloths.iter().any(|(_, _, inputs, _)| is_carried(inputs)) {
        return;
    }
    shared.clear();
    for (_, _, inputs, _) in &cloths {
        let (Some(character), Some(journey)) = (inputs.character, inputs.journey) else { continue };
        let at = shared.iter().position(|(known, _)| *known == character).unwrap_or_else(|| {
            shared.push((character, Mean::default()));
            shared.len() - 1
        });
        shared[at].1.add(&journey);
    }
    apart.clear();
    apart.resize(islands.list.len(), false);
    for (index, island) in islands.list.iter().enumerate() {
        let key =
            |entity: Entity| cloths.get(entity).map_or(Some(entity), |(_, _, inputs, _)| inputs.character.or(Some(entity)));
        let first = island.members.first().map(|member| key(member.entity));
        apart[index] = island.members.iter().any(|member| Some(key(member.entity)) != first);
    }
    for (_, place, mut inputs, mut particles) in &mut cloths {
        let inputs = &mut *inputs;
        let Some(journey) = inputs.journey.filter(|_| is_carried(inputs)) else { continue };
        let meets_others = place.island.is_some_and(|(island, _)| apart.get(island as usize).is_some_and(|apart| *apart));
        if meets_others || inputs.coupled.is_pinned() {
            continue;
        }
        let mean = inputs.character.and_then(|character| shared.iter().find(|(known, _)| *known == character));
        let journey = mean.map_or(journey, |(_, mean)| mean.journey());
        let (inertia, share) = (inputs.inertia.unwrap_or_default(), share(inputs));
        // The motion of the space is not felt, and what it carried is where the carrier began.
        let space =
            inertia.space.and_then(|space| Placement::of(&transforms.get(space).ok()?.affine())).map(|at| at.isometry());
        let before = core::mem::replace(&mut particles.space, inertia.space.zip(space));
        let carried = match (before, inertia.space.zip(space)) {
            (Some((was, from)), Some((is, to))) if was == is => Some(Motion { from, to, center: Vec3::ZERO }),
            _ => None,
        };
        let start = carried.map_or(journey.from, |carried| carried.moved(journey.from));
        let rest = Motion { from: start, ..journey };
        let limit = |most: f32, way: f32| if way > most * dt { most * dt / way } else { 1.0 };
        let feels = |share_of: f32, most: f32, way: f32| share_of.min(limit(most, way)) * share;
        let linear = feels(inertia.linear, inertia.max_speed, rest.distance());
        let angular = feels(inertia.angular, inertia.max_turn, rest.angle());
        if carried.is_none() && linear >= 1.0 && angular >= 1.0 {
            continue;
        }
        let motion = Motion { from: journey.from, to: rest.partly(1.0 - linear, 1.0 - angular), center: journey.center };
        // The frame of simulation goes along, so that nothing is rounded; in it everything turns.
        let [from, to] = motion.middles();
        let way = to - from;
        particles.origin += way.as_dvec3();
        if motion.angle() > 0.0 {
            let from = Isometry3d::new(Vec3::from(motion.from.translation) + way, motion.from.rotation);
            carry(&Motion { from, ..motion }, inputs, &mut particles);
        }
        particles.disturbed |= way != Vec3::ZERO;
        inputs.carried_by = Some(motion);
    }
}

/// The mean of how the carriers of a character moved.
#[derive(Clone, Copy, Default)]
pub(crate) struct Mean {
    count: f32,
    middles: [Vec3; 2],
    turns: [Vec4; 2],
}

impl Mean {
    fn add(&mut self, journey: &Motion) {
        self.count += 1.0;
        let middles = journey.middles();
        for (i, at) in [&journey.from, &journey.to].into_iter().enumerate() {
            let turn = Vec4::from(at.rotation);
            self.turns[i] += if turn.dot(self.turns[i]) < 0.0 { -turn } else { turn };
            self.middles[i] += middles[i];
        }
    }

    fn journey(&self) -> Motion {
        let at = |i: usize| {
            let turn = Quat::from_vec4(self.turns[i].normalize_or(Vec4::W));
            Isometry3d::new(self.middles[i] / self.count, turn)
        };
        Motion { from: at(0), to: at(1), center: Vec3::ZERO }
    }
}

/// Aims anchors and skin at where they are now, in a frame of simulation that goes along.
pub(crate) fn aim(
    time: Res<ClothTime>,
    transforms: Transforms,
    mut cloths: Query<(&ClothRest, &ClothSolver, &mut ClothInputs, &mut ClothParticles), With<Cloth>>,
) {
    let dt = time.delta_secs();
    for (rest, solver, mut inputs, mut particles) in &mut cloths {
        let (inputs, particles) = (&mut *inputs, &mut *particles);
        if !inputs.is_followed() {
            continue;
        }
        rebase(inputs, particles);
        skeleton::see(inputs, particles, &transforms);
        inputs.aim(particles.origin);
        inputs.follow(&rest.0, particles.origin);
        let frame = inputs.frames;
        inputs.frames = (frame + 1).min(FIRST_FRAMES + 1);
        if inputs.skin.is_some() && frame < FIRST_FRAMES {
            particles.place(inputs.pose(&rest.0, particles.origin));
            inputs.stay();
            continue;
        }
        if !inputs.jumped
            && let Some(skin) = inputs.skin.as_ref().filter(|_| inputs.skinned.is_active())
            && inputs.skinned.fastest(dt) > TELEPORT_SPEED
        {
            // Another clip, without a fade between: cloth goes along, each particle with the skin beneath it.
            let motions = [inputs.joints_before.as_slice(), inputs.joints.as_slice()];
            particles.carry_each(|i| skin.motion(motions, i));
            inputs.stay();
        }
        if inputs.jumped && solver.teleport == ClothTeleportMode::Reset {
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

/// Carries a cloth that stands still along with what it hangs on; whether it went anywhere. One that is pinned nowhere stays.
fn ride(inputs: &mut ClothInputs, particles: &mut ClothParticles, interpolates: bool) -> bool {
    let to = inputs.carrier();
    let from = particles.carrier.replace(to).filter(|from| *from != to && !inputs.anchors.particles.is_empty());
    let mut before = core::mem::take(&mut particles.before);
    before.clear();
    if let Some(from) = from {
        if interpolates {
            before.extend(particles.sim.state.positions.iter().map(|x| x.truncate()));
        }
        let motion = Motion { from, to, center: Vec3::ZERO };
        carry(&motion, inputs, particles);
        // Nobody reads where they are in this frame.
        inputs.carry_joints(motion.affine(particles.origin), true);
    }
    particles.before = before;
    if from.is_some() {
        rebase(inputs, particles);
    }
    from.is_some()
}

/// Moves a cloth, its anchors and its targets rigidly along.
fn carry(jump: &Motion, inputs: &mut ClothInputs, particles: &mut ClothParticles) {
    let motion = jump.motion(particles.origin);
    particles.carry(&motion);
    inputs.carry(&motion);
    inputs.carry_joints(jump.affine(particles.origin), false);
    let turn = jump.turn();
    inputs.skinned.normals_to.iter_mut().for_each(|normal| *normal = turn * *normal);
}

/// Whole metres by which a cloth is too far from the origin of its frame of simulation; none while it is not.
pub(super) fn off_origin(inputs: &ClothInputs, particles: &ClothParticles) -> Option<Vec3> {
    let first = particles.sim.state.positions.first()?.truncate();
    (first.length() > REBASE.max(2.0 * inputs.radius) && first.is_finite()).then(|| first.round())
}

/// Moves the frame of simulation along with the cloth, by whole metres, so that numbers stay small and exact.
fn rebase(inputs: &mut ClothInputs, particles: &mut ClothParticles) {
    let Some(shift) = off_origin(inputs, particles) else { return };
    particles.origin += shift.as_dvec3();
    particles.carry(|x| x - shift);
    inputs.carry(|x| x - shift);
    // A joint that is gone keeps its matrix.
    let joints = inputs.joints.iter_mut().chain(&mut inputs.joints_before);
    joints.for_each(|joint| joint.translation -= Vec3A::from(shift));
    inputs.crossfade.shift(shift);
}
