//! Respond: tells who touches the cloths that ask for it.

use bevy::ecs::entity_disabling::Disabled;
use bevy::ecs::query::Allow;
use bevy::prelude::*;

use crate::components::checked::Checked;
use crate::components::{
    Cloth, ClothContactEnded, ClothContactEvents, ClothContactStarted, ClothContacts, ClothReport, ClothTouch,
};
use crate::islands::ClothIslands;
use crate::notices::Notices;
use crate::simulation::{ClothInputs, ClothParticles, ClothRest, IslandPlace};
use crate::time::ClothTime;

/// Compares what touches with what did.
pub(crate) fn touches(
    mut commands: Commands,
    time: Res<ClothTime>,
    islands: Res<ClothIslands>,
    mut notices: ResMut<Notices>,
    mut cloths: Query<
        (
            Entity,
            Option<&Name>,
            &ClothRest,
            &ClothInputs,
            &ClothParticles,
            &IslandPlace,
            &ClothReport,
            &ClothContactEvents,
            &mut ClothContacts,
        ),
        With<Cloth>,
    >,
    mut now: Local<Vec<ClothTouch>>,
    mut checked: Local<Checked>,
) {
    for (entity, name, rest, inputs, particles, place, report, events, mut contacts) in &mut cloths {
        // Nothing begins or ends while it sleeps, is carried along, or its frame is under way.
        if inputs.active && inputs.is_idle() {
            continue;
        }
        if !inputs.active {
            if !contacts.touches.is_empty() {
                end(&mut commands, entity, &mut contacts);
            }
            continue;
        }
        checked.clear();
        let patience = events.patience(&mut checked);
        notices.clamped(entity, name, "cloth", &checked);
        now.clear();
        if particles.sim.state.substep > 0.0 {
            // Of one substep, times their number, over its length: the impulse of the frame.
            let scale = report.substeps as f32 / particles.sim.state.substep;
            with_bodies(rest.0.mean_edge, inputs, particles, scale, &mut now);
            with_cloths(entity, &islands, place, scale, &mut now);
        }
        now.sort_unstable_by_key(|touch| touch.other);
        let touching = now.len();
        let island = place.island.and_then(|(island, _)| islands.list.get(island as usize));
        let dt = island.and_then(|island| island.background.done).unwrap_or(time.delta_secs());
        for old in &contacts.touches {
            // What is added below stands behind them.
            if now[..touching].binary_search_by_key(&old.other, |touch| touch.other).is_err() {
                let since = old.since + dt;
                if since > patience {
                    commands.trigger(ClothContactEnded { entity, other: old.other });
                } else {
                    now.push(ClothTouch { since, ..*old });
                }
            }
        }
        now.sort_unstable_by_key(|touch| touch.other);
        for touch in &*now {
            if contacts.touches.binary_search_by_key(&touch.other, |old| old.other).is_err() {
                commands.trigger(ClothContactStarted { entity, touch: *touch });
            }
        }
        contacts.touches.clone_from(&now);
    }
}

/// Ends all that touches a cloth.
fn end(commands: &mut Commands, entity: Entity, contacts: &mut ClothContacts) {
    for touch in contacts.touches.drain(..) {
        commands.trigger(ClothContactEnded { entity, other: touch.other });
    }
}

/// Ends all that touches a cloth that loses `C`: that is not simulated any more, or whose list goes.
pub(crate) fn end_without<C: Component>(
    removed: On<Remove, C>,
    mut commands: Commands,
    mut cloths: Query<&mut ClothContacts, Allow<Disabled>>,
) {
    if let Ok(mut contacts) = cloths.get_mut(removed.entity) {
        end(&mut commands, removed.entity, &mut contacts);
    }
}

/// Takes the list of a cloth away that no longer asks for it.
pub(crate) fn on_remove_events(removed: On<Remove, ClothContactEvents>, mut commands: Commands) {
    if let Ok(mut entity) = commands.get_entity(removed.entity) {
        entity.try_remove::<ClothContacts>();
    }
}

/// A touch seen so far, or a new one.
fn entry(now: &mut Vec<ClothTouch>, other: Entity) -> &mut ClothTouch {
    let at = now.iter().position(|touch| touch.other == other).unwrap_or_else(|| {
        let (point, normal) = (Vec3::ZERO, Vec3::ZERO);
        now.push(ClothTouch { other, contacts: 0, point, normal, impulse: 0.0, since: 0.0 });
        now.len() - 1
    });
    &mut now[at]
}

/// `edge`: how far a particle may be from the point of its face that touches `[m]`.
fn with_bodies(edge: f32, inputs: &ClothInputs, particles: &ClothParticles, scale: f32, now: &mut Vec<ClothTouch>) {
    for (body, particle, load) in particles.sim.memory.touches() {
        let (Some(&other), Some(x)) = (inputs.body_entities.get(body), particles.sim.state.positions.get(particle as usize))
        else {
            continue;
        };
        let touch = entry(now, other);
        touch.contacts += 1;
        let impulse = load * scale / x.w.max(f32::MIN_POSITIVE);
        if impulse > touch.impulse {
            touch.impulse = impulse;
            touch.point = x.truncate();
        }
    }
    for touch in now {
        let Some(body) = inputs.body_entities.iter().position(|&e| e == touch.other).and_then(|b| inputs.bodies.get(b)) else {
            continue;
        };
        let at = body.to.inverse_transform_point(touch.point);
        // Without a reach a height field is searched as a whole.
        let nearest = body.shape.project_local_point_with_max_dist(at, false, inputs.fabric.thickness + body.margin + edge);
        let nearest = nearest.unwrap_or_else(|| body.shape.project_local_point(at, false));
        let away = body.to.rotation * (at - nearest.point).normalize_or_zero();
        touch.normal = if nearest.is_inside { -away } else { away };
        touch.point = (particles.origin + touch.point.as_dvec3()).as_vec3();
    }
}

fn with_cloths(entity: Entity, islands: &ClothIslands, place: &IslandPlace, scale: f32, now: &mut Vec<ClothTouch>) {
    let Some((island, part)) =
        place.island.and_then(|(island, part)| Some((islands.list.get(island as usize)?, part as usize)))
    else {
        return;
    };
    if island.members.len() < 2 {
        return;
    }
    island.solver.touches(|parts, point, normal, push| {
        let (other, towards) = match parts {
            [a, b] if a == part => (b, 1.0),
            [a, b] if b == part => (a, -1.0),
            _ => return,
        };
        let Some(other) = island.members.get(other).map(|m| m.entity).filter(|e| *e != entity) else { return };
        let touch = entry(now, other);
        touch.contacts += 1;
        if push * scale > touch.impulse {
            touch.impulse = push * scale;
            touch.point = (island.origin + point.as_dvec3()).as_vec3();
            touch.normal = normal * towards;
        }
    });
}
