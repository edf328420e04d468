//! Sync: shown positions, normals, tangents and bounds. The mesh is written in place, and only when something moved.

use bevy::camera::primitives::Aabb;
use bevy::ecs::batching::BatchingStrategy;
use bevy::math::{Affine3A, DVec3, Mat3};
use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;
use bevy::time::Fixed;

use super::stopwatch;
use crate::bind::{VertexBuffers, bounds_between, is_near, seen_from};
use crate::components::{Cloth, ClothReport};
use crate::schedule::ClothClock;
use crate::simulation::{Binding, ClothInputs, ClothParticles, ClothRest, ClothShown};
use crate::solver::rest::RestShape;
use crate::solver::surface;

/// Shapes the vertices of every cloth, in parallel over cloths.
pub(crate) fn shape(
    clock: Res<ClothClock>,
    fixed: Option<Res<Time<Fixed>>>,
    mut cloths: Query<
        (&ClothRest, &ClothParticles, &ClothInputs, &GlobalTransform, &mut ClothShown, &mut ClothReport),
        With<Cloth>,
    >,
) {
    let _span = debug_span!("cloth/sync").entered();
    let overstep = match fixed {
        Some(fixed) if clock.interpolates => fixed.overstep_fraction(),
        _ => 1.0,
    };
    cloths.par_iter_mut().batching_strategy(BatchingStrategy::new().batches_per_thread(5)).for_each(
        |(rest, particles, inputs, global, mut shown, mut report)| {
            let clock = stopwatch();
            let affine = global.affine();
            let lies = is_near(&affine) && affine.matrix3.determinant() != 0.0;
            if !(inputs.active && lies && particles.sim.state.positions.len() == rest.0.positions.len()) {
                return;
            }
            let shown = &mut *shown;
            let moves = shown.forced || shown.affine != affine || shown.origin != particles.origin;
            if inputs.asleep && shown.still && !moves {
                if report.sync_ms != 0.0 {
                    report.sync_ms = 0.0;
                }
                return;
            }
            let moved = show_particles(particles, inputs, overstep, &mut shown.particles);
            shown.still = inputs.asleep && !moved;
            if moved || moves {
                (shown.affine, shown.origin) = (affine, particles.origin);
                let thickness = inputs.fabric.thickness;
                show_vertices(&rest.0, inputs, &affine, particles.origin, thickness, shown);
                shown.forced = false;
                shown.fresh = true;
                report.sync_ms = clock();
            }
        },
    );
}

/// Positions between the last two frames, on the skin as it is. Whether any moved.
fn show_particles(particles: &ClothParticles, inputs: &ClothInputs, overstep: f32, shown: &mut Vec<Vec3>) -> bool {
    let state = &particles.sim.state.positions;
    let interpolates = particles.before.len() == state.len();
    let held = particles.sim.display.held().filter(|held| held.len() == state.len());
    let skin = inputs.skin.as_ref().filter(|_| inputs.crossfade.is_active());
    let onto_skin = |joints: &[Affine3A], i: usize, x: Vec3| {
        let motion = skin.and_then(|skin| skin.motion([joints, inputs.crossfade.live()], i));
        motion.map_or(x, |motion| motion.transform_point3(x))
    };
    let mut moved = shown.len() != state.len();
    shown.resize(state.len(), Vec3::ZERO);
    for (i, (shown, now)) in shown.iter_mut().zip(state).enumerate() {
        let now = held.map_or(now.truncate(), |held| held[i]);
        let now = onto_skin(&inputs.joints, i, now);
        let now = if interpolates { onto_skin(&inputs.joints_before, i, particles.before[i]).lerp(now, overstep) } else { now };
        // Whatever happens to a state, nothing that is not a number is drawn.
        if now.is_finite() && *shown != now {
            *shown = now;
            moved = true;
        }
    }
    moved
}

/// From particles in the frame of simulation to vertices in the space of the mesh.
fn show_vertices(
    rest: &RestShape,
    inputs: &ClothInputs,
    affine: &Affine3A,
    origin: DVec3,
    thickness: f32,
    shown: &mut ClothShown,
) {
    let inverse = seen_from(affine, origin).inverse();
    let ClothShown { surface, fine, particles, normals, sums, vertices, bounds, .. } = shown;
    let turn = Mat3::from_quat(inputs.placement.rotation);
    let local = Mat3::from(inverse.matrix3);
    let transpose = Mat3::from(affine.matrix3).transpose();
    let padded = |(low, high): (Vec3, Vec3)| {
        let pad = Vec3::splat(thickness * surface_scale(&local)).max(0.01 * (high - low));
        (low - pad, high + pad)
    };
    if let (Some(fine), Some(shape)) = (fine, &rest.fine) {
        *bounds = padded(fine.shape(&rest.topology.faces, &shape.embedding, particles, &inverse, vertices));
        return;
    }

    for (out, &p) in vertices.positions.iter_mut().zip(&rest.particle_of_vertex) {
        *out = inverse.transform_point3(particles[p as usize]).to_array();
    }
    for &(v, offset) in &rest.isolated {
        let (Some(out), Some(&p)) = (vertices.positions.get_mut(v as usize), rest.particle_of_vertex.get(v as usize)) else {
            continue;
        };
        *out = inverse.transform_point3(particles[p as usize] + turn * offset).to_array();
    }
    let fold = |(low, high): (Vec3, Vec3), p: &[f32; 3]| (low.min(Vec3::from(*p)), high.max(Vec3::from(*p)));
    *bounds = padded(vertices.positions.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), fold));

    if !surface.normals && surface.handedness.is_empty() {
        return;
    }
    surface::normals(&rest.topology.faces, particles, sums, normals);
    if surface.normals {
        for (out, &p) in vertices.normals.iter_mut().zip(&rest.particle_of_vertex) {
            *out = (transpose * normals[p as usize]).normalize_or(Vec3::Y).to_array();
        }
    }
    if !surface.handedness.is_empty() {
        let of = |v: usize| rest.particle_of_vertex[v] as usize;
        let tangents = &mut vertices.tangents;
        surface::tangents(&surface.axes, |v| particles[of(v)], |v| normals[of(v)], tangents);
        for (t, &w) in tangents.iter_mut().zip(&surface.handedness) {
            let along = (local * t.truncate()).normalize_or(Vec3::X);
            *t = along.extend(w);
        }
    }
}

/// Largest length that a unit of the world has in the space of the mesh.
fn surface_scale(local: &Mat3) -> f32 {
    local.x_axis.length().max(local.y_axis.length()).max(local.z_axis.length())
}

/// Hands the vertices to the mesh of each cloth that moved, and the bounds to its entity.
pub(crate) fn write(
    mut meshes: ResMut<Assets<Mesh>>,
    mut cloths: Query<(&Binding, &mut ClothShown, &mut ClothReport, Option<&mut Aabb>), With<Cloth>>,
) {
    let _span = debug_span!("cloth/sync").entered();
    for (binding, mut shown, mut report, aabb) in &mut cloths {
        if !shown.fresh {
            continue;
        }
        let clock = stopwatch();
        let shown = &mut *shown;
        shown.fresh = false;
        let (low, high) = shown.bounds;
        if !(low.is_finite() && high.is_finite()) {
            continue;
        }
        if let Some(mut aabb) = aabb {
            *aabb = bounds_between(low, high);
        }
        let Some(instance) = &binding.instance else { continue };
        let Some(mut mesh) = meshes.get_mut(instance) else { continue };
        shown.writes = shown.writes.wrapping_add(1);
        hand_over(&mut mesh, &mut shown.vertices);
        report.sync_ms += clock();
    }
}

/// Hands positions, normals and tangents to a mesh, as far as it has as many.
pub(super) fn hand_over(mesh: &mut Mesh, vertices: &mut VertexBuffers) {
    swap(mesh, Mesh::ATTRIBUTE_POSITION, &mut vertices.positions);
    swap(mesh, Mesh::ATTRIBUTE_NORMAL, &mut vertices.normals);
    if let Ok(VertexAttributeValues::Float32x4(tangents)) = mesh.try_attribute_mut(Mesh::ATTRIBUTE_TANGENT)
        && tangents.len() == vertices.tangents.len()
    {
        for (out, t) in tangents.iter_mut().zip(&vertices.tangents) {
            *out = t.to_array();
        }
    }
}

/// Buffer and attribute change places, so that nothing is copied and nothing allocated.
fn swap(mesh: &mut Mesh, attribute: bevy::mesh::MeshVertexAttribute, buffer: &mut Vec<[f32; 3]>) {
    if let Ok(VertexAttributeValues::Float32x3(values)) = mesh.try_attribute_mut(attribute)
        && values.len() == buffer.len()
    {
        core::mem::swap(values, buffer);
    }
}
