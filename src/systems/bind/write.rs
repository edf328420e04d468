//! What was made is written to the entity.

use bevy::camera::visibility::{DynamicSkinnedMeshBounds, NoAutoAabb};
use bevy::math::{DVec3, Mat3, Vec4};
use bevy::mesh::skinning::SkinnedMesh;
use bevy::prelude::*;

use super::make::Made;
use super::{Assembly, BindableItem, Wanted};
use crate::bind::{Continuing, Crossfade, Skin, bounds_between};
use crate::components::ClothReport;
use crate::notices::label;
use crate::simulation::{Binding, Change, ClothInputs, ClothParticles, ClothRest, ClothShown, IslandPlace, TakenSkin, Worn};
use crate::solver::rest::RestShape;
use crate::solver::state::ClothState;

/// Writes what was made to the entity.
pub(super) fn write(commands: &mut Commands, assembly: &mut Assembly, cloth: &mut BindableItem, wanted: Wanted, made: Made) {
    let Made {
        placement,
        rest,
        report,
        authored,
        resolved,
        sets,
        known,
        skin,
        joints,
        followed,
        unfollowed: _,
        surface,
        fine,
        instance,
        origin,
        continues,
    } = made;
    let center = skin.as_ref().map_or(Vec3::ZERO, |skin| placement.bake * skin.center());
    if *cloth.build != report {
        debug!("{} is bound: {report:?}", label(cloth.entity, cloth.name));
        *cloth.build = report;
    }
    let vertices = authored.positions.len();
    let radius = radius(&rest);
    let pinned = u32::try_from(resolved.particles.len()).unwrap_or(u32::MAX);
    let mut entity = commands.entity(cloth.entity);
    if let (true, Some(particles), Some(inputs), Some(shown), Some(binding)) =
        (continues, &mut cloth.particles, &mut cloth.inputs, &mut cloth.shown, &mut cloth.binding)
    {
        let rescale = if placement.fits(&binding.bake) { Mat3::IDENTITY } else { placement.bake * binding.bake.inverse() };
        rescale_about(particles, inputs, rescale);
        let positions = &particles.sim.state.positions;
        let before = Continuing { sets: &inputs.sets, anchors: &inputs.anchors, known: &known, positions, origin, rescale };
        (inputs.anchors, inputs.sets) = resolved.into_anchors(sets, &rest, Some(&before));
        // Its points may be others.
        let has_joints_of = |skin: &Skin| inputs.skin.as_ref().is_some_and(|old| old.entities().eq(skin.entities()));
        if !skin.as_ref().is_some_and(has_joints_of) {
            (inputs.crossfade, inputs.joints) = (Crossfade::of(&joints), joints);
        }
        (inputs.skin, inputs.placement, inputs.worn) = (skin, placement, Worn::default());
        inputs.pins.clone_from(&cloth.pins);
        (inputs.followed, inputs.skinned.radius, inputs.center) = (followed, radius, center);
        (inputs.radius, inputs.stale, inputs.active) = (radius, true, !cloth.disabled && !binding.on_skin);
        (shown.surface, shown.fine) = (surface, fine);
        shown.fit(vertices);
        shown.forced = true;
        (binding.bake, binding.pending) = (placement.bake, Change::None);
        if wanted.change > Change::Pins {
            particles.sim.forget();
            entity.try_insert((ClothRest(rest), IslandPlace::default()));
        }
    } else {
        let (anchors, sets) = resolved.into_anchors(sets, &rest, None);
        let mut inputs = ClothInputs::new(placement, radius, anchors, sets, skin, joints);
        inputs.pins.clone_from(&cloth.pins);
        inputs.active = !cloth.disabled;
        (inputs.followed, inputs.center) = (followed, center);
        inputs.followed.advance(0.0, &mut inputs.skinned);
        inputs.snap_to_targets(&rest, origin);
        let particles = start(&rest, &inputs, origin);
        let mut shown = ClothShown { surface, fine, forced: true, ..ClothShown::default() };
        shown.fit(vertices);
        entity.try_insert((ClothRest(rest), particles, inputs, shown, IslandPlace::default()));
        *cloth.report = ClothReport::default();
        if let Some(binding) = &mut cloth.binding {
            (binding.bake, binding.pending) = (placement.bake, Change::None);
        }
    }
    cloth.report.pinned = pinned;
    if let Some((instance, bounds)) = instance {
        give_instance(&mut entity, assembly, cloth, wanted, placement.bake, instance, bounds);
    }
}

/// Puts the entity's own mesh in place of the authored one, and takes its skin off.
fn give_instance(
    entity: &mut EntityCommands,
    assembly: &mut Assembly,
    cloth: &mut BindableItem,
    wanted: Wanted,
    bake: Mat3,
    instance: Mesh,
    bounds: Option<(Vec3, Vec3)>,
) {
    // A clone of a cloth shows the mesh of that one still, whose bounds were ours.
    let is_clone = cloth.binding.is_none() && cloth.mesh.as_ref().is_some_and(|mesh| assembly.sources.is_instance(mesh.0.id()));
    let handle = assembly.meshes.add(instance);
    assembly.sources.insert(handle.id(), wanted.source.clone());
    if let Some(mesh) = &mut cloth.mesh {
        mesh.0 = handle.clone();
    }
    let own_bounds = match &cloth.binding {
        Some(b) if b.instance.is_some() => b.own_bounds,
        _ => cloth.own_bounds && !is_clone,
    };
    if let Some(SkinnedMesh { inverse_bindposes, joints }) = wanted.skinned {
        let bounds = cloth.skinned_bounds || cloth.taken.is_some_and(|taken| taken.bounds);
        entity.try_insert(TakenSkin { inverse_bindposes, joints, bounds });
    }
    entity.try_insert(Binding {
        source: wanted.source,
        instance: Some(handle),
        bake,
        shortest_edge: wanted.shortest_edge,
        own_bounds,
        pending: Change::None,
        on_skin: false,
    });
    entity.try_remove::<(SkinnedMesh, DynamicSkinnedMeshBounds)>();
    entity.try_insert(NoAutoAabb);
    if let Some((low, high)) = bounds {
        entity.try_insert(bounds_between(low, high));
    }
}

/// The state at the pose at rest.
fn start(rest: &RestShape, inputs: &ClothInputs, origin: DVec3) -> ClothParticles {
    let positions: Vec<Vec4> = inputs.pose(rest, origin).map(|p| p.extend(1.0)).collect();
    let state = ClothState { previous: positions.clone(), positions, ..ClothState::default() };
    ClothParticles { carrier: Some(inputs.carrier()), ..ClothParticles::new(state, origin) }
}

/// Scales state and anchors about the place of the cloth.
fn rescale_about(particles: &mut ClothParticles, inputs: &mut ClothInputs, rescale: Mat3) {
    if rescale == Mat3::IDENTITY {
        return;
    }
    let placement = &inputs.placement;
    let turn = Mat3::from_quat(placement.rotation);
    let (matrix, at) = (turn * rescale * turn.transpose(), placement.translation_from(particles.origin));
    let motion = |x: Vec3| matrix * (x - at) + at;
    particles.carry(motion);
    inputs.carry(motion);
    particles.sim.display.reset();
}

/// Radius of the ball around the box of the shape at rest `[m]`.
fn radius(rest: &RestShape) -> f32 {
    let fold = |(low, high): (Vec3, Vec3), p: &Vec3| (low.min(*p), high.max(*p));
    let (low, high) = rest.positions.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), fold);
    0.5 * (high - low).length()
}
