//! Prepare: the skeleton that each skinned cloth is given, which is not the one that is there while it is faded over.

use bevy::prelude::*;

use super::carriers::Characters;
use crate::bind::{Crossfade, Skin, Transforms};
use crate::components::Cloth;
use crate::simulation::{ClothInputs, ClothParticles, ClothPose, FIRST_FRAMES, TELEPORT_SPIN};
use crate::time::ClothTime;

/// Reads where joints are, before anything asks what carries a cloth.
pub(crate) fn pose(
    time: Res<ClothTime>,
    clock: Option<Res<Time<Virtual>>>,
    transforms: Transforms,
    parents: Query<&ChildOf>,
    characters: Characters,
    mut cloths: Query<(Entity, &mut ClothInputs, &ClothParticles, Has<ClothPose>), With<Cloth>>,
    mut dressed: Local<Vec<(Entity, [f32; 2])>>,
) {
    let dt = time.delta_secs();
    // Animation moves once for several frames of a fixed schedule.
    let animated = clock.map_or(dt, |clock| clock.delta_secs().max(dt));
    dressed.clear();
    let worn = cloths.iter().map(|(_, inputs, ..)| inputs).filter(|inputs| inputs.skin.is_some() && inputs.active);
    let worn = worn.filter(|inputs| inputs.frames > FIRST_FRAMES);
    dressed.extend(worn.filter_map(|inputs| Some((inputs.character?, inputs.crossfade.times_left()))));
    for (entity, mut inputs, particles, is_posed) in &mut cloths {
        let inputs = &mut *inputs;
        if !inputs.is_followed() {
            continue;
        }
        let Some(skin) = inputs.skin.take() else { continue };
        let ClothInputs { crossfade, joints, joints_before, frames, pace, body_entities, .. } = inputs;
        crossfade.read(&skin, &transforms, particles.origin);
        if *frames > FIRST_FRAMES {
            let hangs = |body: &Entity, joint: u16| joint_of(&skin, *body, &parents) == Some(joint);
            let matters = |joint: u16| skin.moves_with(joint) || body_entities.iter().any(|body| hangs(body, joint));
            crossfade.begin_after_jump(&skin, joints, (TELEPORT_SPIN, animated), matters, &parents);
        } else if !is_posed {
            // Clothes that are put on later see the skeleton as those do that are there.
            let character = characters.of(entity);
            let others = dressed.iter().find(|(wearer, _)| Some(*wearer) == character);
            crossfade.begin_in_bind_pose(&skin, *frames == 0, others.map(|(_, times)| *times), &parents);
            crossfade.pose(&skin, joints);
        }
        joints_before.clone_from(joints);
        crossfade.advance(dt * *pace);
        crossfade.pose(&skin, joints);
        if crossfade.is_active() {
            inputs.placement = skin.placement_of(joints, particles.origin).unwrap_or(inputs.placement);
        }
        inputs.skin = Some(skin);
    }
}

/// The nearest joint of a skin that something hangs on, or is.
pub(crate) fn joint_of(skin: &Skin, entity: Entity, parents: &Query<&ChildOf>) -> Option<u16> {
    core::iter::once(entity).chain(parents.iter_ancestors(entity)).find_map(|at| skin.index(at))
}

/// Reads where joints are again, as seen from where the frame of simulation is by now.
pub(super) fn see(inputs: &mut ClothInputs, particles: &ClothParticles, transforms: &Transforms) {
    let ClothInputs { skin, crossfade, joints, .. } = inputs;
    let Some(skin) = skin else { return };
    Crossfade::read_again(crossfade, skin, transforms, particles.origin);
    crossfade.pose(skin, joints);
}
