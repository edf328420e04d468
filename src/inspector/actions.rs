//! What the buttons do to time and to a cloth: between frames, so that no stage sees half of it.

use core::time::Duration;

use bevy::math::Vec3;
use bevy::prelude::*;

use super::state::{Action, ClothInspector};
use super::tangle;
use crate::components::{Cloth, ClothError};
use crate::islands::ClothIslands;
use crate::simulation::{Binding, Change, ClothInputs, ClothParticles, ClothRest, ClothShown};

/// Length of the frame that is stepped while time stands still `[s]`.
pub const STEP: f64 = 1.0 / 60.0;

/// Does what was asked for since the last frame.
pub(super) fn act(world: &mut World) {
    let Some(mut inspector) = world.get_resource_mut::<ClothInspector>() else { return };
    if inspector.actions.is_empty() {
        return;
    }
    for action in core::mem::take(&mut inspector.actions) {
        let done = match action {
            Action::Step => step(world),
            Action::Reset(cloth) => reset(world, cloth),
            Action::Fold(cloth) => fold(world, cloth),
            Action::Push(cloth) => push(world, cloth),
            #[cfg(feature = "record")]
            Action::Record(cloth) => record(world, cloth),
        };
        if let (Err(reason), Some(mut inspector)) = (done, world.get_resource_mut::<ClothInspector>()) {
            inspector.say(Err(reason.into()));
        }
    }
}

/// Lets a frame pass although the clock stands still.
fn step(world: &mut World) -> Result<(), &'static str> {
    let frame = Duration::from_secs_f64(STEP);
    let mut clock = world.get_resource_mut::<Time<Virtual>>().ok_or("there is no clock: add `TimePlugin`")?;
    clock.advance_by(frame);
    let now = clock.as_generic();
    world.insert_resource(now);
    Ok(())
}

/// Puts a cloth at its pose at rest; one that was stopped is made anew.
fn reset(world: &mut World, cloth: Entity) -> Result<(), &'static str> {
    if world.get::<ClothError>(cloth).is_some() {
        world.get_mut::<Binding>(cloth).ok_or(NOT_BOUND)?.pending = Change::Mesh;
        return Ok(());
    }
    let mut cloths = world.query::<(&ClothRest, &mut ClothInputs, &mut ClothParticles)>();
    let (rest, mut inputs, mut particles) = cloths.get_mut(world, cloth).map_err(|_| NOT_BOUND)?;
    let pose: Vec<Vec3> = inputs.pose(&rest.0, particles.origin).collect();
    particles.place(pose.into_iter());
    inputs.stay();
    // Contacts and forces that are held over frames have seen it elsewhere.
    particles.sim.forget();
    forget(world, cloth);
    Ok(())
}

const NOT_BOUND: &str = "it is not simulated yet";

/// Folds a cloth through itself.
fn fold(world: &mut World, cloth: Entity) -> Result<(), &'static str> {
    displace(world, cloth, tangle::fold)?.then_some(()).ok_or("there is nothing to fold")
}

/// Pushes a cloth through the nearest other.
fn push(world: &mut World, cloth: Entity) -> Result<(), &'static str> {
    let mut all = world.query_filtered::<(Entity, &ClothParticles), With<Cloth>>();
    let (_, own) = all.get(world, cloth).map_err(|_| NOT_BOUND)?;
    let origin = own.origin;
    let seen = |particles: &ClothParticles| -> Vec<Vec3> {
        particles.world_positions().map(|x| (x - origin).as_vec3()).filter(|x| x.is_finite()).collect()
    };
    let mine = seen(own);
    let least = |others: &[Vec3]| {
        let gap = |x: &Vec3| others.iter().step_by(7).map(|y| x.distance_squared(*y)).fold(f32::INFINITY, f32::min);
        mine.iter().step_by(7).map(gap).fold(f32::INFINITY, f32::min)
    };
    let others = all.iter(world).filter(|(entity, _)| *entity != cloth).map(|(entity, particles)| (entity, seen(particles)));
    let gaps = others.map(|(entity, positions)| (least(&positions), entity, positions));
    let nearest = gaps.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).ok_or("there is no other cloth")?;
    displace(world, cloth, |positions| tangle::push(positions, &nearest.2))?.then_some(()).ok_or("there is nothing to push")
}

/// Asks for the next frame of a cloth to be written to a file.
#[cfg(feature = "record")]
fn record(world: &mut World, cloth: Entity) -> Result<(), &'static str> {
    let mut recorder = world.get_resource_mut::<crate::ClothRecorder>().ok_or("nothing records: add `ClothRecorderPlugin`")?;
    if !recorder.next.contains(&cloth) {
        recorder.next.push(cloth);
    }
    let folder = recorder.folder.display().to_string();
    if let Some(mut inspector) = world.get_resource_mut::<ClothInspector>() {
        inspector.say(Ok(format!("its next frame goes to {folder}")));
    }
    Ok(())
}

/// Moves particles to other places, without speed.
fn displace(world: &mut World, cloth: Entity, motion: impl FnOnce(&mut [Vec4]) -> bool) -> Result<bool, &'static str> {
    let mut particles = world.get_mut::<ClothParticles>(cloth).ok_or(NOT_BOUND)?;
    let state = &mut particles.sim.state;
    let done = motion(&mut state.positions);
    if done {
        for (old, x) in state.previous.iter_mut().zip(&state.positions) {
            *old = x.truncate().extend(old.w);
        }
        particles.before.clear();
        particles.disturbed = true;
        forget(world, cloth);
    }
    Ok(done)
}

/// Forgets on which side of each other the members of a cloth's island were: they would be brought back there. They wake, and
/// the cloth is shown where it is now.
fn forget(world: &mut World, cloth: Entity) {
    if let Some(mut shown) = world.get_mut::<ClothShown>(cloth) {
        shown.forced = true;
    }
    let Some(mut islands) = world.get_resource_mut::<ClothIslands>() else { return };
    let Some(island) = islands.list.iter_mut().find(|island| island.members.iter().any(|m| m.entity == cloth)) else { return };
    let island = core::mem::take(island);
    for member in island.members {
        if let Some(mut particles) = world.get_mut::<ClothParticles>(member.entity) {
            particles.disturbed = true;
        }
    }
}
