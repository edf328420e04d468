//! Prepare: puts cloths into poses: those out of save games, and those in which they begin.

use bevy::math::DVec3;
use bevy::prelude::*;

use crate::components::{Cloth, ClothReset};
use crate::islands::ClothIslands;
use crate::notices::{Notices, label};
use crate::simulation::{ClothInputs, ClothParticles, ClothPose, ClothRest, FIRST_FRAMES, IslandPlace};
use crate::solver::impulse::{FASTEST, first_substep};

/// Farthest from the origin of its frame that a particle is put `[m]`: farther, a coordinate of 32 bits is not within 0.1 mm.
const FARTHEST: f64 = 1000.0;

type Posed<'w, 's, 'a> = Query<
    'w,
    's,
    (Entity, Option<&'a Name>, &'a ClothPose, &'a ClothRest, &'a mut ClothInputs, &'a mut ClothParticles, &'a mut IslandPlace),
    With<Cloth>,
>;

/// Puts every cloth that has a pose into it, once what carries the cloth is where it is in this frame.
pub(crate) fn take(mut commands: Commands, mut notices: ResMut<Notices>, mut islands: ResMut<ClothIslands>, mut cloths: Posed) {
    for (entity, name, pose, rest, mut inputs, mut particles, mut place) in &mut cloths {
        let comes = inputs.skin.is_some() && inputs.frames <= FIRST_FRAMES;
        if !inputs.active || comes || particles.sim.recovery.is_frozen() {
            continue;
        }
        if inputs.skin.is_some() && inputs.fade < inputs.wanted() {
            // It gets its limits first, which would bring it back to its skin.
            inputs.fade = inputs.wanted();
            continue;
        }
        commands.entity(entity).try_remove::<ClothPose>();
        if let Some(why) = misfit(pose, &particles) {
            if notices.first(entity, "ClothPose") {
                warn!("cloth {} stays as it is: `ClothPose` {why}", label(entity, name));
            }
            continue;
        }
        if inputs.crossfade.is_active() {
            // It was saved on the skeleton that is there.
            let inputs = &mut *inputs;
            inputs.crossfade.end(&mut inputs.joints);
            inputs.snap_to_targets(&rest.0, particles.origin);
        }
        put(pose, &mut particles);
        forget_contacts(&mut particles, &mut place, &mut islands);
    }
}

/// What touched a cloth touches it no more.
fn forget_contacts(particles: &mut ClothParticles, place: &mut IslandPlace, islands: &mut ClothIslands) {
    particles.sim.forget();
    if let Some((island, _)) = place.island.take() {
        islands.forget(island);
    }
}

/// Hands [`ClothReset`] down from what is no cloth to the cloths below it.
pub(crate) fn hand_down(
    mut commands: Commands,
    resets: Query<Entity, (With<ClothReset>, Without<Cloth>)>,
    children: Query<&Children>,
    cloths: Query<(), With<Cloth>>,
) {
    for entity in &resets {
        for cloth in children.iter_descendants(entity).filter(|below| cloths.contains(*below)) {
            commands.entity(cloth).try_insert(ClothReset);
        }
        commands.entity(entity).try_remove::<ClothReset>();
    }
}

type Reset<'w, 's, 'a> = Query<
    'w,
    's,
    (Entity, &'a ClothRest, &'a mut ClothInputs, &'a mut ClothParticles, &'a mut IslandPlace),
    (With<Cloth>, With<ClothReset>),
>;

/// Puts cloths to where they begin, once what carries them is where it is in this frame.
pub(crate) fn reset(mut commands: Commands, mut islands: ResMut<ClothIslands>, mut cloths: Reset) {
    for (entity, rest, mut inputs, mut particles, mut place) in &mut cloths {
        if !inputs.active {
            continue;
        }
        commands.entity(entity).try_remove::<ClothReset>();
        let origin = particles.origin;
        particles.place(inputs.pose(&rest.0, origin));
        inputs.stay();
        // It falls into place anew.
        inputs.warmed = inputs.warmed.map(|_| 0.0);
        forget_contacts(&mut particles, &mut place, &mut islands);
    }
}

/// Why a cloth cannot be put into a pose.
fn misfit(ClothPose { positions, velocities }: &ClothPose, particles: &ClothParticles) -> Option<String> {
    let count = particles.len();
    if positions.len() != count || velocities.len() != count {
        let (p, v) = (positions.len(), velocities.len());
        return Some(format!(
            "has {p} positions and {v} velocities for its {count} particles: take one of a cloth with the same mesh"
        ));
    }
    let fits = |(x, v): (&DVec3, &Vec3)| (*x - particles.origin).length() < FARTHEST && v.is_finite();
    let bad = positions.iter().zip(velocities).position(|of| !fits(of))?;
    Some(format!(
        "has particle {bad} at {} with {} m/s, which is not finite or farther than {FARTHEST} m away: put the cloth where it was saved first",
        positions[bad], velocities[bad]
    ))
}

fn put(ClothPose { positions, velocities }: &ClothPose, particles: &mut ClothParticles) {
    let origin = particles.origin;
    let state = particles.state_mut();
    if state.substep <= 0.0 {
        state.substep = first_substep();
    }
    let all = state.positions.iter_mut().zip(&mut state.previous);
    for ((x, old), (to, velocity)) in all.zip(positions.iter().zip(velocities)).filter(|((x, _), _)| x.w > 0.0) {
        let to = (*to - origin).as_vec3();
        *x = to.extend(x.w);
        *old = (to - velocity.clamp_length_max(FASTEST) * state.substep).extend(old.w);
    }
    state.folds.clear();
    particles.before.clear();
    particles.sim.display.reset();
}
