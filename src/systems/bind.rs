//! Prepare: a mesh becomes a cloth, again when mesh, scale or pins change, and says so when it cannot.

use std::sync::Arc;

use bevy::asset::{LoadState, RenderAssetUsages};
use bevy::camera::visibility::{DynamicSkinnedMeshBounds, NoAutoAabb};
use bevy::ecs::query::QueryData;
use bevy::ecs::system::SystemParam;
use bevy::math::{Affine3A, DVec3, Mat3, Vec4};
use bevy::mesh::VertexAttributeValues;
use bevy::mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes};
use bevy::prelude::*;

use super::release::take_apart;
use crate::bind::{
    AnchorSet, AnchorSets, Asked, Authored, Continuing, Crossfade, FineMesh, Followed, Placement, Resolved, RestCache, RestOf,
    Skin, Sources, Surface, Transforms, Vertices, bounds_between, corners, instance_of, read, resolve, skinning_matrices,
    uniform_scale, unreadable,
};
use crate::components::{
    Cloth, ClothBuildReport, ClothDecimation, ClothDisabled, ClothDrive, ClothError, ClothErrorKind, ClothFailed, ClothLimits,
    ClothLoading, ClothMaterial, ClothPiece, ClothPinSet, ClothPins, ClothRenderMesh, ClothReport, ClothReset, ClothSolver,
    ClothStatus, WaitingFor,
};
use crate::notices::{Notices, PATIENCE, label};
use crate::simulation::{
    Binding, Change, ClothInputs, ClothParticles, ClothRest, ClothScratch, ClothShown, TakenSkin, WaitingSince, Worn,
};
use crate::solver::island::Display;
use crate::solver::recover::Recovery;
use crate::solver::rest::{RestError, RestShape};
use crate::solver::state::ClothState;

/// A cloth, bound or not.
#[derive(QueryData)]
#[query_data(mutable)]
pub(crate) struct Bindable {
    entity: Entity,
    name: Option<&'static Name>,
    disabled: Has<ClothDisabled>,
    mesh: Option<&'static mut Mesh3d>,
    global: Option<&'static GlobalTransform>,
    pins: Ref<'static, ClothPins>,
    status: &'static mut ClothStatus,
    report: &'static mut ClothReport,
    build: &'static mut ClothBuildReport,
    error: Option<&'static ClothError>,
    material: Ref<'static, ClothMaterial>,
    limits: Option<&'static ClothLimits>,
    drive: Option<&'static ClothDrive>,
    reset: Has<ClothReset>,
    solver: Ref<'static, ClothSolver>,
    waiting: Option<&'static mut WaitingSince>,
    decimation: Option<&'static ClothDecimation>,
    skinned: Option<&'static SkinnedMesh>,
    skinned_bounds: Has<DynamicSkinnedMeshBounds>,
    own_bounds: Has<NoAutoAabb>,
    taken: Option<&'static TakenSkin>,
    binding: Option<&'static mut Binding>,
    rest: Option<&'static ClothRest>,
    particles: Option<&'static mut ClothParticles>,
    inputs: Option<&'static mut ClothInputs>,
    shown: Option<&'static mut ClothShown>,
}

/// Where meshes, skins and scales come from.
#[derive(SystemParam)]
pub(crate) struct Assembly<'w, 's> {
    meshes: ResMut<'w, Assets<Mesh>>,
    bindposes: Option<Res<'w, Assets<SkinnedMeshInverseBindposes>>>,
    server: Option<Res<'w, AssetServer>>,
    cache: ResMut<'w, RestCache>,
    loading: Res<'w, ClothLoading>,
    sources: ResMut<'w, Sources>,
    transforms: Transforms<'w, 's>,
    pieces: Query<'w, 's, &'static ClothPiece, Without<Cloth>>,
    render_meshes: Query<'w, 's, &'static ClothRenderMesh, Without<Cloth>>,
}

impl Assembly<'_, '_> {
    /// Whether other meshes are drawn in place of that of a cloth.
    fn is_drawn_by_others(&self, cloth: Entity) -> bool {
        self.pieces.iter().any(|piece| piece.cloth == cloth) || self.render_meshes.iter().any(|mesh| mesh.cloth == cloth)
    }
}

/// What keeps a cloth from being bound.
enum Obstacle {
    Wait(WaitingFor),
    Fail(ClothError),
}

impl From<ClothError> for Obstacle {
    fn from(error: ClothError) -> Self {
        Self::Fail(error)
    }
}

/// Binds every cloth that is new or whose mesh, scale or pins changed.
pub(crate) fn bind(
    mut commands: Commands,
    mut assembly: Assembly,
    mut notices: ResMut<Notices>,
    time: Res<Time<Real>>,
    mut cloths: Query<Bindable, With<Cloth>>,
) {
    let _span = debug_span!("cloth/prepare").entered();
    let now = time.elapsed_secs_f64();
    assembly.cache.forget_unasked();
    for mut cloth in &mut cloths {
        match bind_one(&mut commands, &mut assembly, &mut notices, &mut cloth) {
            Ok(()) => {}
            Err(Obstacle::Wait(reason)) => wait(&mut commands, &mut notices, &mut cloth, reason, now),
            Err(Obstacle::Fail(error)) => fail(&mut commands, &mut notices, &mut cloth, &assembly.sources, error),
        }
    }
}

/// What a cloth should be bound to.
struct Wanted {
    source: Handle<Mesh>,
    placement: Placement,
    /// Length below which edges are collapsed, in the space of the mesh `[m]`; 0: none.
    shortest_edge: f32,
    /// Only when something changed.
    skinned: Option<SkinnedMesh>,
    change: Change,
}

/// Everything that binding makes, before anything is written.
struct Made {
    /// Where the cloth's own entity or its skin is.
    placement: Placement,
    rest: Arc<RestShape>,
    report: ClothBuildReport,
    authored: Authored,
    resolved: Resolved,
    sets: Vec<AnchorSet>,
    /// The old set that each of them goes on from.
    known: Vec<Option<usize>>,
    skin: Option<Skin>,
    joints: Vec<Affine3A>,
    followed: Followed,
    /// What of the skin could not be used, and why.
    unfollowed: Vec<(&'static str, String)>,
    surface: Surface,
    fine: Option<FineMesh>,
    instance: Option<(Mesh, Option<(Vec3, Vec3)>)>,
    origin: DVec3,
    /// Whether the state goes on.
    continues: bool,
}

fn bind_one(
    commands: &mut Commands,
    assembly: &mut Assembly,
    notices: &mut Notices,
    cloth: &mut BindableItem,
) -> Result<(), Obstacle> {
    if cloth.disabled && cloth.inputs.is_none() {
        // It is drawn as it was authored.
        return Ok(());
    }
    tell_of_decimation(notices, cloth);
    let wanted = want(assembly, cloth)?;
    if wanted.change > Change::None {
        let made = make(assembly, cloth, &wanted)?;
        tell_of_a_board(notices, cloth, &made.rest);
        tell_of_pins(notices, cloth, &made.resolved, made.rest.particle_of_vertex.len());
        tell_of_skin(notices, cloth, &made.unfollowed);
        record(commands, assembly, cloth, wanted, made);
        activate(commands, cloth);
    } else if let Some(inputs) = &mut cloth.inputs
        && cloth.error.is_none()
    {
        inputs.placement = wanted.placement;
        inputs.active = !cloth.disabled && !cloth.binding.as_ref().is_some_and(|binding| binding.on_skin);
        activate(commands, cloth);
    }
    if cloth.disabled {
        // In every frame, so that it is not marked as changed.
        cloth.report.bypass_change_detection().idle();
    }
    Ok(())
}

/// Warns of a mesh that hardly bends, since cloth bends only at edges between two triangles.
fn tell_of_a_board(notices: &mut Notices, cloth: &BindableItem, rest: &RestShape) {
    if rest.bends.count < 2 && notices.first(cloth.entity, "a board") {
        warn!(
            "cloth {} moves as a board: cloth bends at edges between two triangles, and its mesh has {}; subdivide the mesh, or add \
             `ClothSubdivision`",
            label(cloth.entity, cloth.name),
            if rest.bends.count == 1 { "one" } else { "none" },
        );
    }
}

/// Warns of pins that hold nothing.
fn tell_of_pins(notices: &mut Notices, cloth: &BindableItem, resolved: &Resolved, vertices: usize) {
    if let Some(index) = resolved.bad_pins.first()
        && notices.first(cloth.entity, "pins past the end")
    {
        warn!(
            "cloth {} has `ClothPins` of vertex {index}, which its mesh does not have ({vertices} vertices, from 0 on): {} of its \
             pins hold nothing; pin by position, or count the vertices of this mesh",
            label(cloth.entity, cloth.name),
            resolved.bad_pins.len(),
        );
        return;
    }
    // Pins that let go of a cloth that was simulated were meant to.
    let is_meant = cloth.inputs.is_some() || cloth.pins.sets.is_empty() || !resolved.particles.is_empty();
    if !is_meant && notices.first(cloth.entity, "no pin holds") {
        warn!(
            "cloth {} has pins that hold no vertex: a predicate sees positions in the space of the mesh, and weights have to be above 0",
            label(cloth.entity, cloth.name)
        );
    }
}

/// Warns of maps that cannot be used: the cloth does without them.
fn tell_of_skin(notices: &mut Notices, cloth: &BindableItem, unfollowed: &[(&'static str, String)]) {
    for &(name, ref reason) in unfollowed {
        if notices.first(cloth.entity, name) {
            warn!("cloth {} does without `{name}`, whose map is to {reason}", label(cloth.entity, cloth.name));
        }
    }
}

/// Warns of a length that cannot be used: the cloth is as fine as its mesh.
fn tell_of_decimation(notices: &mut Notices, cloth: &BindableItem) {
    if let Some(ClothDecimation { shortest_edge }) = cloth.decimation
        && ClothDecimation::usable(cloth.decimation) == 0.0
        && notices.first(cloth.entity, "decimation.shortest_edge")
    {
        warn!(
            "cloth {} has a `decimation.shortest_edge` of {shortest_edge}: set a length of more than 0 [m]; it is as fine as its mesh",
            label(cloth.entity, cloth.name)
        );
    }
}

/// Compares what is there with what was bound. A change is remembered before anything is waited for.
fn want(assembly: &Assembly, cloth: &mut BindableItem) -> Result<Wanted, Obstacle> {
    let news = news(assembly, cloth);
    if let Some(binding) = &mut cloth.binding
        && binding.pending < news
    {
        binding.pending = news;
    }
    let shown = &cloth.mesh.as_ref().ok_or(Obstacle::Wait(WaitingFor::Mesh))?.0;
    let on_skin = cloth.binding.as_ref().is_some_and(|b| b.on_skin && b.source.id() == shown.id());
    let bound = cloth.binding.as_ref().filter(|b| on_skin || b.instance.as_ref().is_none_or(|i| i.id() == shown.id()));
    let source = match bound {
        Some(b) if b.instance.is_some() => b.source.clone(),
        _ => assembly.sources.authored(shown),
    };
    let skinned = cloth.skinned.cloned().or_else(|| cloth.taken.map(TakenSkin::skin));
    let placement = match &skinned {
        Some(skinned) => match &cloth.inputs {
            // A joint that is gone or broken is where it was last.
            Some(inputs) if on_skin || cloth.skinned.is_none() => {
                inputs.skin.as_ref().and_then(|skin| skin.placement(&assembly.transforms)).unwrap_or(inputs.placement)
            }
            _ => skin_placement(assembly, skinned)?,
        },
        None => cloth.global.and_then(|g| Placement::of(&g.affine())).ok_or(Obstacle::Wait(WaitingFor::Scale))?,
    };
    let shortest_edge = ClothDecimation::usable(cloth.decimation);
    let is_of = |b: &Binding| b.source.id() == source.id() && b.shortest_edge == shortest_edge;
    let change = match bound {
        Some(b) if is_of(b) && placement.fits(&b.bake) => b.pending,
        Some(b) if is_of(b) && cloth.error.is_none() => b.pending.max(Change::Scale),
        _ => Change::Mesh,
    };
    let skinned = skinned.filter(|_| change > Change::None);
    Ok(Wanted { source, placement, shortest_edge, skinned, change })
}

/// What changed in this frame, apart from scale and handle, which can be seen at any time.
fn news(assembly: &Assembly, cloth: &BindableItem) -> Change {
    let Some(binding) = &cloth.binding else { return Change::Mesh };
    let source = binding.source.id();
    let failed = cloth.error.is_some();
    let unstable = cloth.error.is_some_and(|e| e.kind == ClothErrorKind::Unstable);
    let tuned = unstable && (cloth.material.is_changed() || cloth.solver.is_changed() || cloth.reset);
    let followed = cloth.inputs.as_ref().is_some_and(|inputs| inputs.followed.asked.is_of(cloth.limits, cloth.drive));
    let repinned = cloth.pins.is_changed() || (cloth.inputs.is_some() && !followed);
    let arrived = assembly.sources.modified.contains(&source) || (failed && assembly.sources.added.contains(&source));
    if arrived || tuned || (failed && repinned) {
        Change::Mesh
    } else if repinned {
        Change::Pins
    } else {
        Change::None
    }
}

/// Reads, builds and resolves; fails or waits without having written anything.
fn make(assembly: &mut Assembly, cloth: &BindableItem, wanted: &Wanted) -> Result<Made, Obstacle> {
    let Wanted { source, placement, shortest_edge, skinned, change } = wanted;
    let shape_at = |bake| RestOf { source: source.id(), bake, shortest_edge: *shortest_edge };
    if let Some(server) = &assembly.server
        && let Some(LoadState::Failed(error)) = server.get_load_state(source.id())
        && !assembly.meshes.contains(source)
    {
        let detail = format!("its mesh failed to load ({error}): check the path and the file");
        return Err(Obstacle::Fail(ClothError { kind: ClothErrorKind::LoadFailed, detail }));
    }
    let mesh = assembly.meshes.get(source).ok_or(Obstacle::Wait(WaitingFor::Asset))?;
    let vertices = mesh.try_attribute_option(Mesh::ATTRIBUTE_POSITION).ok().flatten().map_or(0, VertexAttributeValues::len);
    // One that was simulated, or failed, is not to stand still.
    let is_new = cloth.inputs.is_none() && cloth.error.is_none();
    let is_large = is_new && *change == Change::Mesh && vertices >= assembly.loading.in_background_from as usize;
    if is_large && !assembly.cache.is_ready(&shape_at(placement.bake), || read(mesh).ok()) {
        return Err(Obstacle::Wait(WaitingFor::Build));
    }
    let authored = read(mesh)?;
    let bad_mesh = |error: RestError| ClothError {
        kind: ClothErrorKind::BadMesh,
        detail: format!("{error}: check the mesh in the program it was made with"),
    };
    let (mut rest, built) = assembly.cache.get_or_build(&shape_at(placement.bake), &authored).map_err(bad_mesh)?;
    let frozen = cloth.particles.as_ref().is_none_or(|p| p.recovery.is_frozen());
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
        return Err(Obstacle::Wait(WaitingFor::Skin));
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

/// Writes what was made to the entity.
fn record(commands: &mut Commands, assembly: &mut Assembly, cloth: &mut BindableItem, wanted: Wanted, made: Made) {
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
        let positions = &particles.state.positions;
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
            entity.try_insert((ClothRest(rest), ClothScratch::default()));
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
        entity.try_insert((ClothRest(rest), particles, inputs, shown, ClothScratch::default()));
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
    let mut recovery = Recovery::default();
    recovery.start(&state);
    ClothParticles {
        state,
        origin,
        before: Vec::new(),
        recovery,
        display: Display::default(),
        carrier: Some(inputs.carrier()),
        space: None,
        disturbed: false,
        written: false,
    }
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
    particles.display.reset();
}

/// Where the joints of a bound cloth were last, as seen from `origin`.
fn last_joints(cloth: &BindableItem, origin: DVec3) -> Vec<Affine3A> {
    let (Some(inputs), Some(particles), None) = (&cloth.inputs, &cloth.particles, cloth.skinned) else { return Vec::new() };
    let shift = (particles.origin - origin).as_vec3();
    let mut joints = inputs.joints.clone();
    joints.iter_mut().for_each(|joint| joint.translation += Vec3A::from(shift));
    joints
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
        let affine = affine.filter(|a| Placement::of(a).is_some()).ok_or(Obstacle::Wait(WaitingFor::Target))?;
        Ok((AnchorSet::new(target, &affine, placement), None))
    };
    pins.sets.iter().enumerate().map(join).collect()
}

/// The inverse bind poses of a skin.
fn bindposes<'a>(assembly: &'a Assembly, skinned: &SkinnedMesh) -> Result<&'a SkinnedMeshInverseBindposes, Obstacle> {
    let bindposes = assembly.bindposes.as_ref().and_then(|b| b.get(&skinned.inverse_bindposes));
    bindposes.ok_or(Obstacle::Wait(WaitingFor::Skin))
}

/// Where the first joint of a skin takes it, before anything is known of its weights; its scale is that of the joint, and even.
fn skin_placement(assembly: &Assembly, skinned: &SkinnedMesh) -> Result<Placement, Obstacle> {
    let missing = Obstacle::Wait(WaitingFor::Skin);
    let (Some(&joint), Some(inverse_bind)) = (skinned.joints.first(), bindposes(assembly, skinned)?.first()) else {
        return Err(missing);
    };
    let mut matrices = Vec::new();
    let first = (joint, Affine3A::from_mat4(*inverse_bind));
    if !skinning_matrices(&[first], &assembly.transforms, DVec3::ZERO, &mut matrices) {
        return Err(missing);
    }
    let mut placement = Placement::of(&matrices[0]).ok_or(Obstacle::Wait(WaitingFor::Scale))?;
    placement.bake = Mat3::from_diagonal(Vec3::splat(uniform_scale(&placement.bake)));
    Ok(placement)
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

/// Radius of the ball around the box of the shape at rest `[m]`.
fn radius(rest: &RestShape) -> f32 {
    let fold = |(low, high): (Vec3, Vec3), p: &Vec3| (low.min(*p), high.max(*p));
    let (low, high) = rest.positions.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), fold);
    0.5 * (high - low).length()
}

fn activate(commands: &mut Commands, cloth: &mut BindableItem) {
    if *cloth.status != ClothStatus::Active {
        *cloth.status = ClothStatus::Active;
        commands.entity(cloth.entity).try_remove::<(ClothError, WaitingSince)>();
    }
}

/// Class C: silent at first, then one warning.
fn wait(commands: &mut Commands, notices: &mut Notices, cloth: &mut BindableItem, reason: WaitingFor, now: f64) {
    if let Some(inputs) = &mut cloth.inputs {
        inputs.active = false;
    }
    cloth.status.set_if_neq(ClothStatus::Waiting(reason));
    if cloth.error.is_some() {
        // It no longer fails but waits; when that is over it is tried from the start.
        if let Some(binding) = &mut cloth.binding {
            binding.pending = Change::Mesh;
        }
        commands.entity(cloth.entity).try_remove::<ClothError>();
    }
    let since = WaitingSince { reason, at: now, told: false };
    match &mut cloth.waiting {
        None => {
            commands.entity(cloth.entity).try_insert(since);
        }
        Some(old) if old.reason != reason => **old = since,
        Some(since) if !since.told && now - since.at > PATIENCE => {
            since.told = true;
            if notices.first(cloth.entity, reason.cure()) {
                warn!("cloth {} still waits: {}", label(cloth.entity, cloth.name), reason.cure());
            }
        }
        Some(_) => {}
    }
}

/// Class A: the authored mesh is drawn, and the reason is on the entity.
fn fail(commands: &mut Commands, notices: &mut Notices, cloth: &mut BindableItem, sources: &Sources, error: ClothError) {
    let source = cloth.mesh.as_ref().map(|shown| match &cloth.binding {
        Some(b) if b.instance.as_ref().is_some_and(|i| i.id() == shown.0.id()) => b.source.clone(),
        _ => sources.authored(&shown.0),
    });
    let (Some(source), Some(mesh)) = (source, &mut cloth.mesh) else { return };
    if mesh.0.id() != source.id() {
        mesh.0 = source.clone();
    }
    let mut entity = commands.entity(cloth.entity);
    let bake = match &cloth.binding {
        Some(b) => {
            take_apart(&mut entity, b, cloth.taken);
            cloth.global.and_then(|g| Placement::of(&g.affine())).map_or(b.bake, |p| p.bake)
        }
        None => cloth.global.and_then(|g| Placement::of(&g.affine())).map_or(Mat3::IDENTITY, |p| p.bake),
    };
    let own_bounds = cloth.own_bounds && cloth.binding.is_none();
    let shortest_edge = ClothDecimation::usable(cloth.decimation);
    entity.try_insert(Binding {
        source,
        instance: None,
        bake,
        shortest_edge,
        own_bounds,
        pending: Change::None,
        on_skin: false,
    });
    entity.try_remove::<WaitingSince>();
    *cloth.status = ClothStatus::Failed;
    if notices.first(cloth.entity, error.kind.name()) {
        warn!("cloth {} cannot be simulated: {error}", label(cloth.entity, cloth.name));
    }
    if cloth.error != Some(&error) {
        entity.try_insert(error.clone());
        commands.trigger(ClothFailed { entity: cloth.entity, error });
    }
}
