//! Prepare: a mesh becomes a cloth, again when mesh, scale or pins change, and says so when it cannot.
//!
//! ```text
//! want ─► make ─► tell ─► write ─► outcome: active, waits, failed
//! ```

mod make;
mod tell;
mod write;
mod outcome;

use bevy::camera::visibility::{DynamicSkinnedMeshBounds, NoAutoAabb};
use bevy::ecs::query::QueryData;
use bevy::ecs::system::SystemParam;
use bevy::math::{Affine3A, DVec3, Mat3};
use bevy::mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes};
use bevy::prelude::*;

use crate::bind::{Placement, RestCache, Sources, Transforms, skinning_matrices, uniform_scale};
use crate::components::{
    Cloth, ClothBuildReport, ClothDecimation, ClothDisabled, ClothDrive, ClothError, ClothErrorKind, ClothLimits, ClothLoading,
    ClothMaterial, ClothPiece, ClothPins, ClothRenderMesh, ClothReport, ClothReset, ClothSolver, ClothStatus, ClothWaitingFor,
};
use crate::notices::Notices;
use crate::simulation::{Binding, Change, ClothInputs, ClothParticles, ClothRest, ClothShown, TakenSkin, WaitingSince};
use make::make;
use outcome::{activate, fail, wait};
use tell::{tell_of_a_board, tell_of_decimation, tell_of_pins, tell_of_skin};
use write::write;

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
    Wait(ClothWaitingFor),
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
        write(commands, assembly, cloth, wanted, made);
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

/// Compares what is there with what was bound. A change is remembered before anything is waited for.
fn want(assembly: &Assembly, cloth: &mut BindableItem) -> Result<Wanted, Obstacle> {
    let news = news(assembly, cloth);
    if let Some(binding) = &mut cloth.binding
        && binding.pending < news
    {
        binding.pending = news;
    }
    let shown = &cloth.mesh.as_ref().ok_or(Obstacle::Wait(ClothWaitingFor::Mesh))?.0;
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
        None => cloth.global.and_then(|g| Placement::of(&g.affine())).ok_or(Obstacle::Wait(ClothWaitingFor::Transform))?,
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

/// Where the first joint of a skin takes it, before anything is known of its weights; its scale is that of the joint, and even.
fn skin_placement(assembly: &Assembly, skinned: &SkinnedMesh) -> Result<Placement, Obstacle> {
    let missing = Obstacle::Wait(ClothWaitingFor::Skin);
    let (Some(&joint), Some(inverse_bind)) = (skinned.joints.first(), bindposes(assembly, skinned)?.first()) else {
        return Err(missing);
    };
    let mut matrices = Vec::new();
    let first = (joint, Affine3A::from_mat4(*inverse_bind));
    if !skinning_matrices(&[first], &assembly.transforms, DVec3::ZERO, &mut matrices) {
        return Err(missing);
    }
    let mut placement = Placement::of(&matrices[0]).ok_or(Obstacle::Wait(ClothWaitingFor::Transform))?;
    placement.bake = Mat3::from_diagonal(Vec3::splat(uniform_scale(&placement.bake)));
    Ok(placement)
}

/// The inverse bind poses of a skin.
fn bindposes<'a>(assembly: &'a Assembly, skinned: &SkinnedMesh) -> Result<&'a SkinnedMeshInverseBindposes, Obstacle> {
    let bindposes = assembly.bindposes.as_ref().and_then(|b| b.get(&skinned.inverse_bindposes));
    bindposes.ok_or(Obstacle::Wait(ClothWaitingFor::Skin))
}
