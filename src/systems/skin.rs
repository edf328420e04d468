//! Prepare: a skinned cloth that is only animated has its mesh and its skin back, until it is simulated again.

use bevy::camera::primitives::Aabb;
use bevy::camera::visibility::{DynamicSkinnedMeshBounds, NoAutoAabb};
use bevy::mesh::skinning::SkinnedMesh;
use bevy::prelude::*;

use crate::components::{Cloth, ClothReport};
use crate::simulation::{Binding, ClothInputs, ClothParticles, ClothScratch, ClothShown, TakenSkin};

/// Gives skins back to cloths that have faded into them, and takes those of cloths that are to be simulated.
pub(crate) fn change(
    mut commands: Commands,
    mut cloths: Query<
        (
            Entity,
            &TakenSkin,
            &mut Mesh3d,
            &mut Binding,
            (&mut ClothInputs, &mut ClothParticles, &mut ClothScratch, &mut ClothShown),
            &mut ClothReport,
        ),
        With<Cloth>,
    >,
) {
    for (entity, taken, mut mesh, mut binding, (mut inputs, mut particles, mut scratch, mut shown), mut report) in &mut cloths {
        let is_on_skin = inputs.is_animated();
        if is_on_skin == binding.on_skin || inputs.skin.is_none() {
            continue;
        }
        let Some(instance) = &binding.instance else { continue };
        let mut entity = commands.entity(entity);
        if is_on_skin {
            mesh.0 = binding.source.clone();
            entity.try_insert(taken.skin()).try_remove::<Aabb>();
            if !binding.own_bounds {
                entity.try_remove::<NoAutoAabb>();
            }
            if taken.bounds {
                entity.try_insert(DynamicSkinnedMeshBounds);
            }
            report.idle();
        } else {
            mesh.0 = instance.clone();
            entity.try_remove::<(SkinnedMesh, DynamicSkinnedMeshBounds)>();
            entity.try_insert((NoAutoAabb, Aabb::default()));
            // It begins as a new one does, and knows of nothing before.
            (inputs.frames, inputs.on_skin, inputs.stale, shown.forced) = (0, false, true, true);
            (inputs.fade, inputs.skinned.scale) = (0.0, 0.0);
            (particles.carrier, *scratch) = (None, ClothScratch::default());
        }
        binding.on_skin = is_on_skin;
        inputs.active = !is_on_skin;
    }
}
