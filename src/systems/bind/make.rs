//! What a cloth is made of, read, built and resolved before anything is written.

use std::sync::Arc;

use bevy::asset::{LoadState, RenderAssetUsages};
use bevy::math::{Affine3A, DVec3};
use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;

use super::{Assembly, BindableItem, Obstacle, Wanted, bindposes};
use crate::bind::{
    AnchorSet, AnchorSets, Asked, Authored, FineMesh, Followed, Placement, Resolved, RestOf, Skin, Surface, Transforms,
    Vertices, corners, instance_of, read, resolve, unreadable,
};
use crate::components::{ClothBuildReport, ClothError, ClothErrorKind, ClothPinSet, ClothPins, ClothWaitingFor};
use crate::simulation::Change;
use crate::solver::rest::{RestError, RestShape};

/// Everything that binding makes, before anything is written.
pub(super) struct Made {
    /// Where the cloth's own entity or its skin is.
    pub placement: Placement,
    pub rest: Arc<RestShape>,
    pub report: ClothBuildReport,
    pub authored: Authored,
    pub resolved: Resolved,
    pub sets: Vec<AnchorSet>,
    /// The old set that each of them goes on from.
    pub known: Vec<Option<usize>>,
    pub skin: Option<Skin>,
    pub joints: Vec<Affine3A>,
    pub followed: Followed,
    /// What of the skin could not be used, and why.
    pub unfollowed: Vec<(&'static str, String)>,
    pub surface: Surface,
    pub fine: Option<FineMesh>,
    pub instance: Option<(Mesh, Option<(Vec3, Vec3)>)>,
    pub origin: DVec3,
    /// Whether the state goes on.
    pub continues: bool,
}

/// Reads, builds and resolves; fails or waits without having written anything.
pub(super) fn make(assembly: &mut Assembly, cloth: &BindableItem, wanted: &Wanted) -> Result<Made, Obstacle> {
    let Wanted { source, placement, shortest_edge, skinned, change } = wanted;
    let shape_at = |bake| RestOf { source: source.id(), bake, shortest_edge: *shortest_edge };
    if let Some(server) = &assembly.server
        && let Some(LoadState::Failed(error)) = server.get_load_state(source.id())
        && !assembly.meshes.contains(source)
    {
        let detail = format!("its mesh failed to load ({error}): check the path and the file");
        return Err(Obstacle::Fail(ClothError { kind: ClothErrorKind::LoadFailed, detail }));
    }
    let mesh = assembly.meshes.get(source).ok_or(Obstacle::Wait(ClothWaitingFor::Asset))?;
    let vertices = mesh.try_attribute_option(Mesh::ATTRIBUTE_POSITION).ok().flatten().map_or(0, VertexAttributeValues::len);
    // One that was simulated, or failed, is not to stand still.
    let is_new = cloth.inputs.is_none() && cloth.error.is_none();
    let is_large = is_new && *change == Change::Mesh && vertices >= assembly.loading.in_background_from as usize;
    if is_large && !assembly.cache.is_ready(&shape_at(placement.bake), || read(mesh).ok()) {
        return Err(Obstacle::Wait(ClothWaitingFor::Build));
    }
    let authored = read(mesh)?;
    let bad_mesh = |error: RestError| ClothError {
        kind: ClothErrorKind::BadMesh,
        detail: format!("{error}: check the mesh in the program it was made with"),
    };
    let (mut rest, built) = assembly.cache.get_or_build(&shape_at(placement.bake), &authored).map_err(bad_mesh)?;
    let frozen = cloth.particles.as_ref().is_none_or(|p| p.sim.recovery.is_frozen());
    let continues = cloth.error.is_none() && !frozen && cloth.rest.is_some_and(|old| same_topology(&old.0, &rest));
    let old = cloth.inputs.as_ref().filter(|_| continues);
    let origin = match &cloth.particles {
        Some(particles) if continues => particles.origin,
        _ => placement.translation.as_dvec3(),
    };
    let joined = join(&cloth.pins, old.map(|o| &o.sets), &assembly.transforms, placement)?;
    let (mut sets, mut known): (Vec<AnchorSet>, Vec<Option<usize>>) = joined.into_iter().unzip();
    let mut resolved = resolve(&cloth.pins, |s| sets.get(s).is_some_and(|set| set.released), mesh, &authored, &rest)?;
    let mut unfollowed = Vec::new();
    let asked = Asked::of(cloth.limits, cloth.drive);
    let before = old.map(|old| &old.followed);
    let followed = Followed::new(asked, mesh, &rest, &placement.bake, before, |name, reason| unfollowed.push((name, reason)));
    if resolved.pin(followed.pinned(), sets.len()) {
        known.push(old.and_then(|old| old.sets.sets.iter().position(|set| set.target.is_none())));
        sets.push(AnchorSet::own(placement));
    }
    let mut joints = last_joints(cloth, origin);
    let mut skin = match skinned {
        Some(skinned) => Skin::new(mesh, &authored, &rest, Skin::joints(skinned, bindposes(assembly, skinned)?)),
        None => None,
    };
    if let Some(skin) = &skin
        && !skin.matrices(&assembly.transforms, origin, &mut joints)
    {
        return Err(Obstacle::Wait(ClothWaitingFor::Skin));
    }
    let mut placement = *placement;
    if let Some(skin) = &mut skin {
        skin.find_carriers(&resolved.particles);
        let bake = placement.bake;
        placement = skin.placement(&assembly.transforms).unwrap_or(placement);
        if !placement.fits(&bake) {
            (rest, _) = assembly.cache.get_or_build(&shape_at(placement.bake), &authored).map_err(bad_mesh)?;
        }
    }
    let surface = Surface::new(mesh, &authored);
    let fine = rest.fine.is_some().then(|| FineMesh::new(Vertices::of(mesh, &Affine3A::from_mat3(placement.bake)), &rest));
    let instance = if *change == Change::Mesh {
        let usage = if assembly.is_drawn_by_others(cloth.entity) {
            RenderAssetUsages::MAIN_WORLD
        } else {
            RenderAssetUsages::default()
        };
        Some((instance_of(mesh, usage).map_err(|error| unreadable(&error))?, corners(mesh)))
    } else {
        None
    };
    let mut report = ClothBuildReport::new(&built);
    report.bad_pins.clone_from(&resolved.bad_pins);
    Ok(Made {
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
        unfollowed,
        surface,
        fine,
        instance,
        origin,
        continues,
    })
}

/// Joins every pin set to its target, as an old set of that target was joined, which is named too. Sets may have changed
/// places.
fn join(
    pins: &ClothPins,
    old: Option<&AnchorSets>,
    transforms: &Transforms,
    placement: &Placement,
) -> Result<Vec<(AnchorSet, Option<usize>)>, Obstacle> {
    let old = old.map_or(&[][..], |old| &old.sets);
    let join = |(s, set): (usize, &ClothPinSet)| {
        let fits = |at: &usize| old.get(*at).is_some_and(|known| known.target == set.target);
        if let Some(at) = Some(s).filter(fits).or_else(|| (0..old.len()).find(fits)) {
            return Ok((old[at].clone(), Some(at)));
        }
        let Some(target) = set.target else {
            return Ok((AnchorSet::own(placement), None));
        };
        let affine = transforms.get(target).ok().map(GlobalTransform::affine);
        let affine = affine.filter(|a| Placement::of(a).is_some()).ok_or(Obstacle::Wait(ClothWaitingFor::Target))?;
        Ok((AnchorSet::new(target, &affine, placement), None))
    };
    pins.sets.iter().enumerate().map(join).collect()
}

/// Whether vertices and faces of two shapes hang on the same particles; a mirrored face counts as the same.
fn same_topology(a: &Arc<RestShape>, b: &Arc<RestShape>) -> bool {
    if Arc::ptr_eq(a, b) {
        return true;
    }
    let corners = |shape: &RestShape| {
        let mut faces = shape.topology.faces.clone();
        faces.iter_mut().for_each(|face| face.sort_unstable());
        faces.sort_unstable();
        faces
    };
    a.particle_of_vertex == b.particle_of_vertex
        && a.positions.len() == b.positions.len()
        && (a.topology.faces == b.topology.faces || corners(a) == corners(b))
}

/// Where the joints of a bound cloth were last, as seen from `origin`.
fn last_joints(cloth: &BindableItem, origin: DVec3) -> Vec<Affine3A> {
    let (Some(inputs), Some(particles), None) = (&cloth.inputs, &cloth.particles, cloth.skinned) else { return Vec::new() };
    let shift = (particles.origin - origin).as_vec3();
    let mut joints = inputs.joints.clone();
    joints.iter_mut().for_each(|joint| joint.translation += Vec3A::from(shift));
    joints
}
