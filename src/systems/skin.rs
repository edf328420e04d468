//! Prepare: a skinned cloth that is only animated has its mesh and its skin back, until it is simulated again.

use bevy::camera::primitives::Aabb;
use bevy::camera::visibility::{DynamicSkinnedMeshBounds, NoAutoAabb};
use bevy::mesh::skinning::SkinnedMesh;
use bevy::prelude::*;

use crate::components::{Cloth, ClothReport};
use crate::simulation::{Binding, ClothInputs, ClothParticles, ClothShown, IslandPlace, TakenSkin};

/// Gives skins back to cloths that have faded into them, and takes those of cloths that are to be simulated.
pub(crate) fn change(
    mut commands: Commands,
    mut cloths: Query<
        (Entity, &Binding, (&mut ClothInputs, &mut ClothParticles, &mut IslandPlace, &mut ClothShown), &mut ClothReport),
        (With<Cloth>, With<TakenSkin>),
    >,
) {
    for (entity, binding, (mut inputs, mut particles, mut place, mut shown), mut report) in &mut cloths {
        let on_skin = inputs.is_animated();
        if on_skin == binding.on_skin || inputs.skin.is_none() || binding.instance.is_none() {
            continue;
        }
        commands.entity(entity).queue_silenced(move |mut cloth: EntityWorldMut| exchange(&mut cloth, on_skin));
        if on_skin {
            report.idle();
        } else {
            // It begins as a new one does, and knows of nothing before.
            (inputs.frames, inputs.on_skin, inputs.stale, shown.forced) = (0, false, true, true);
            (inputs.fade, inputs.skinned.scale) = (0.0, 0.0);
            particles.sim.forget();
            (particles.carrier, *place) = (None, IslandPlace::default());
        }
        inputs.active = !on_skin;
    }
}

/// Gives a cloth its authored mesh and its skin, or its own mesh and none.
pub(crate) fn exchange(cloth: &mut EntityWorldMut, on_skin: bool) {
    let Some(taken) = cloth.get::<TakenSkin>().cloned() else { return };
    let Some(mut binding) = cloth.get_mut::<Binding>() else { return };
    let Some(instance) = binding.instance.clone() else { return };
    binding.on_skin = on_skin;
    let (source, own_bounds) = (binding.source.clone(), binding.own_bounds);
    if let Some(mut mesh) = cloth.get_mut::<Mesh3d>() {
        mesh.0 = if on_skin { source } else { instance };
    }
    if on_skin {
        cloth.insert(taken.skin()).remove::<Aabb>();
        if !own_bounds {
            cloth.remove::<NoAutoAabb>();
        }
        if taken.bounds {
            cloth.insert(DynamicSkinnedMeshBounds);
        }
    } else {
        cloth.remove::<(SkinnedMesh, DynamicSkinnedMeshBounds)>();
        cloth.insert((NoAutoAabb, Aabb::default()));
    }
}
