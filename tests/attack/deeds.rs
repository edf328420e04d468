//! What is done to entities that are there.

use bevy::camera::primitives::{Aabb, MeshAabb};
use bevy::ecs::system::RunSystemOnce;
use bevy::mesh::VertexAttributeValues;
use bevy::mesh::skinning::SkinnedMesh;
use bevy::prelude::*;
use bevy_drape::ClothSkinQuery;
use bevy_drape::prelude::*;
use fastrand::Rng;

use super::damage;
use super::headless::frame_length;
use super::mirror::{self, Wildness};
use super::stage::Stage;
use super::wild::{number, once_in, one_of, signed, span, vector, wild_vector};

/// Another mesh, that of another entity, none, or other numbers in it.
pub fn swap(stage: &mut Stage, slot: usize, other: usize, rng: &mut Rng) -> String {
    let Some(entity) = stage.live(slot) else { return format!("{slot}: nothing to give a mesh") };
    let handle = stage.app.world().get::<Mesh3d>(entity).map(|mesh| mesh.0.clone());
    let theirs = stage.live(other).and_then(|other| stage.app.world().get::<Mesh3d>(other)).map(|mesh| mesh.0.clone());
    match (rng.u32(0..9), handle, theirs) {
        (0, ..) => {
            stage.world().entity_mut(entity).remove::<Mesh3d>();
            format!("{slot}: no mesh")
        }
        (1, _, Some(theirs)) => {
            stage.world().entity_mut(entity).insert(Mesh3d(theirs));
            format!("{slot}: the mesh of {other}")
        }
        (2, Some(handle), _) => {
            stage.world().resource_mut::<Assets<Mesh>>().remove(&handle);
            format!("{slot}: its mesh is no asset any more")
        }
        (3 | 4, Some(handle), _) => {
            stage.made.insert(handle.id());
            let wildly = once_in(rng, 3);
            let mut meshes = stage.app.world_mut().resource_mut::<Assets<Mesh>>();
            if let Some(mut mesh) = meshes.get_mut(&handle)
                && let Ok(VertexAttributeValues::Float32x3(points)) = mesh.try_attribute_mut(Mesh::ATTRIBUTE_POSITION)
                && !points.is_empty()
            {
                let which = rng.usize(0..points.len());
                points[which] = if wildly { wild_vector(rng) } else { vector(rng, 1.0) }.to_array();
            }
            format!("{slot}: another position in its mesh, wild {wildly}")
        }
        (5, Some(handle), _) => {
            stage.made.insert(handle.id());
            let (mesh, what) = damage::mesh(rng, true);
            stage.world().resource_mut::<Assets<Mesh>>().insert(handle.id(), mesh).ok();
            format!("{slot}: its asset is now {what}")
        }
        (6, ..) => {
            stage.world().entity_mut(entity).remove::<(ClothSubdivision, ClothDecimation)>();
            format!("{slot}: neither subdivision nor decimation")
        }
        (7, Some(handle), _) => {
            let mesh = stage.app.world().resource::<Assets<Mesh>>().get(&handle);
            let size = mesh.and_then(MeshAabb::compute_aabb).map_or(1.0, |bounds| bounds.half_extents.length());
            let longest = if once_in(rng, 4) { number(rng).max(0.1 * size) } else { one_of(rng, &[0.1, 0.3]) * size };
            if rng.bool() {
                stage.world().entity_mut(entity).insert(ClothDecimation::new(longest));
                return format!("{slot}: ClothDecimation {longest}");
            }
            stage.world().entity_mut(entity).insert(ClothSubdivision::new(longest));
            format!("{slot}: ClothSubdivision {longest}")
        }
        _ => {
            let (mesh, what) = {
                let wildly = rng.bool();
                damage::mesh(rng, wildly)
            };
            let mesh = stage.add(mesh);
            stage.world().entity_mut(entity).insert(Mesh3d(mesh));
            format!("{slot}: another mesh, {what}")
        }
    }
}

/// Puts a component in.
pub fn put(stage: &mut Stage, slot: usize, other: usize, rng: &mut Rng) -> String {
    let Some(entity) = stage.live(slot) else { return format!("{slot}: nothing to put into") };
    let kind = one_of(rng, &stage.kinds);
    let how = Wildness { once_in: rng.u32(1..6), wildly: rng.bool(), entity: stage.some(other) };
    mirror::put(stage.world(), entity, &kind, how, rng);
    format!("{slot}: {} comes in, wild {}", kind.name, how.wildly)
}

/// Takes a component out, one of ours or of the engine.
pub fn take(stage: &mut Stage, slot: usize, rng: &mut Rng) -> String {
    let Some(entity) = stage.live(slot) else { return format!("{slot}: nothing to take out") };
    let kinds = stage.kinds.clone();
    let which = rng.usize(0..kinds.len() + 7);
    if let Some(kind) = kinds.get(which) {
        mirror::take(stage.world(), entity, kind);
        return format!("{slot}: {} goes out", kind.name);
    }
    let mut entity = stage.app.world_mut().entity_mut(entity);
    match which - kinds.len() {
        0 => entity.remove::<Mesh3d>(),
        1 => entity.remove::<Transform>(),
        2 => entity.remove::<GlobalTransform>(),
        3 => entity.remove::<SkinnedMesh>(),
        4 => entity.remove::<Name>(),
        5 => entity.remove::<Aabb>(),
        _ => entity.remove::<(ClothParticles, ClothRest)>(),
    };
    format!("{slot}: component {} of mesh, transforms, skin, name, bounds, state goes out", which - kinds.len())
}

/// Changes a component that is there.
pub fn poke(stage: &mut Stage, slot: usize, other: usize, rng: &mut Rng) -> String {
    let Some(entity) = stage.live(slot) else { return format!("{slot}: nothing to change") };
    let how = Wildness { once_in: rng.u32(2..12), wildly: rng.bool(), entity: stage.some(other) };
    let kinds = stage.kinds.clone();
    let first = rng.usize(0..kinds.len());
    let poked = (0..kinds.len()).map(|i| &kinds[(first + i) % kinds.len()]);
    let name = poked.into_iter().find(|kind| mirror::poke(stage.world(), entity, kind, how, rng)).map(|kind| kind.name.clone());
    format!("{slot}: {} is changed, wild {}", name.unwrap_or_default(), how.wildly)
}

/// Another way to untangle.
pub fn method(stage: &mut Stage, slot: usize, rng: &mut Rng) -> String {
    let Some(entity) = stage.live(slot) else { return format!("{slot}: nothing to untangle") };
    let stall_iterations = rng.u32(0..4);
    let untangling =
        ClothUntangling { stall_iterations, at_load: rng.bool(), effort: one_of(rng, &[16, 64, 512]), ..default() };
    let untangling = untangling.with_method(one_of(rng, ClothUntanglingMethod::ALL));
    let skip = one_of(rng, &[ClothSkipPolicy::Bounded, ClothSkipPolicy::UntilClean { max: 5 }, ClothSkipPolicy::Off]);
    stage.world().entity_mut(entity).insert((untangling, ClothSkipFrame { policy: skip, ..default() }));
    format!("{slot}: {untangling:?}, {skip:?}")
}

/// Gravity, wind or a budget.
pub fn world(stage: &mut Stage, rng: &mut Rng) -> String {
    let wildly = once_in(rng, 3);
    let v = if wildly { wild_vector(rng) } else { vector(rng, 20.0) };
    match rng.u32(0..4) {
        0 => stage.world().insert_resource(ClothGravity(v)),
        1 => {
            let turbulence = if wildly { number(rng) } else { rng.f32() };
            stage.world().insert_resource(ClothGlobalWind { turbulence, ..ClothGlobalWind::new(v) });
        }
        2 => {
            stage.by_clock = true;
            stage.world().insert_resource(ClothBudget { ms: if wildly { number(rng) } else { span(rng, 0.01, 10.0) } });
            // Of a small budget and size, everything goes to the background.
            let in_background_from = one_of(rng, &[0, 50, 1000, u32::MAX]);
            stage.world().insert_resource(ClothLoading { in_background_from });
        }
        _ => {
            stage.world().insert_resource(ClothGravity::default());
            stage.world().insert_resource(ClothGlobalWind::default());
            stage.world().remove_resource::<ClothBudget>();
            stage.world().insert_resource(ClothLoading::AT_ONCE);
        }
    }
    format!("gravity, wind or budget: {v:?}")
}

/// Other frames.
pub fn clock(stage: &mut Stage, rng: &mut Rng) -> String {
    let seconds = one_of(rng, &[0.0, 1.0e-6, 1.0e-4, 1.0e-3, 1.0 / 144.0, 1.0 / 60.0, 1.0 / 20.0, 0.1, 0.4, 10.0]);
    let speed = one_of(rng, &[0.0, 0.01, 0.1, 1.0, 1.0, 3.0]);
    let (pauses, fixed) = (once_in(rng, 6), stage.fixed);
    frame_length(&mut stage.app, seconds);
    let mut time = stage.app.world_mut().resource_mut::<Time<Virtual>>();
    time.set_relative_speed(speed);
    if pauses {
        time.pause();
    } else {
        time.unpause();
    }
    // In the fixed schedule that would be hundreds of ticks in one frame, which is the wish of whoever asks for it.
    if !fixed && once_in(rng, 3) {
        time.set_max_delta(core::time::Duration::from_secs(100));
    }
    format!("frames of {seconds} s, {speed} times as fast, paused {pauses}")
}

/// A number in the state of the solver.
pub fn state(stage: &mut Stage, slot: usize, rng: &mut Rng) -> String {
    let cloth = stage.live(slot).and_then(|e| stage.app.world_mut().get_mut::<ClothParticles>(e));
    let Some(mut particles) = cloth.filter(|p| !p.is_empty()) else { return format!("{slot}: no state") };
    let which = rng.usize(0..particles.len());
    let state = particles.state_mut();
    match rng.u32(0..4) {
        0 => state.positions[which].x = number(rng),
        1 => state.previous[which].y = number(rng),
        2 => state.positions[which].z += signed(rng, 1.0),
        _ => state.positions.iter_mut().for_each(|p| *p += vector(rng, 0.1).extend(0.0)),
    }
    format!("{slot}: another state at particle {which}")
}

/// An impulse, or an explosion.
pub fn kick(stage: &mut Stage, slot: usize, rng: &mut Rng) -> String {
    let Some(mut particles) = stage.live(slot).and_then(|e| stage.app.world_mut().get_mut::<ClothParticles>(e)) else {
        return format!("{slot}: nothing to kick");
    };
    let wildly = once_in(rng, 4);
    let (at, by) = if wildly { (wild_vector(rng), wild_vector(rng)) } else { (vector(rng, 1.0), vector(rng, 5.0)) };
    let radius = if wildly { number(rng) } else { span(rng, 0.01, 10.0) };
    let count = if rng.bool() { particles.apply_impulse(at, by, radius) } else { particles.apply_explosion(at, by.x, radius) };
    format!("{slot}: {count} particles are kicked")
}

/// Questions, whose answers are finite.
///
/// # Panics
/// If one is not.
pub fn ask(stage: &mut Stage, slot: usize, rng: &mut Rng) -> String {
    let wildly = rng.bool();
    let at = if wildly { wild_vector(rng) } else { vector(rng, 2.0) };
    let farthest = if wildly { number(rng) } else { span(rng, 0.1, 100.0) };
    let direction = Dir3::new(vector(rng, 1.0)).unwrap_or(Dir3::Y);
    let entity = stage.some(slot);
    let asked = stage.world().run_system_once(move |cloths: ClothQuery, skins: ClothSkinQuery| {
        let ray = Ray3d::new(at, direction);
        let places = skins.places(entity).map(|places| places.filter(|p| !p.is_finite()).count());
        let depths = skins.depths(entity, [at.as_dvec3()]);
        (cloths.cast_ray(ray, farthest), cloths.nearest_point(at, farthest), places, depths)
    });
    let Ok((ray, near, places, depths)) = asked else { return "no answer".into() };
    // A ray from farther than that hits by chance.
    let is_there = at.abs().max_element() < 1.0e15;
    for hit in ray.iter().filter(|_| is_there).chain(&near) {
        let finite = hit.point.is_finite() && hit.distance.is_finite() && hit.normal.is_finite() && hit.barycentric.is_finite();
        assert!(finite, "an answer that is not finite: {hit:?} of {at} within {farthest}");
    }
    assert!(places.unwrap_or(0) == 0, "{places:?} places on the skin are not finite");
    let depth = depths.iter().flatten().find(|depth| !depth.is_finite());
    assert!(depth.is_none() || !at.is_finite(), "a depth that is not finite: {depths:?} of {at}");
    format!("a ray hits {}, a point is near {}", ray.is_some(), near.is_some())
}

/// Takes a snapshot, or goes back to one.
pub fn snapshot(stage: &mut Stage, slot: usize, rng: &mut Rng) -> String {
    let count = stage.snapshots.len();
    if count == 0 || (count < 4 && rng.bool()) {
        let one = stage.live(slot).filter(|_| once_in(rng, 3));
        let world = stage.app.world_mut();
        let snapshot = match one {
            Some(one) => ClothSnapshot::capture_of(world, &[one]),
            None => ClothSnapshot::capture(world),
        };
        stage.snapshots.push(snapshot);
        return "a snapshot is taken".into();
    }
    let snapshot = stage.snapshots.swap_remove(rng.usize(0..count));
    format!("back to a snapshot: {:?}", snapshot.restore(stage.world()))
}
