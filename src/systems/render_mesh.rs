//! Sync: fine meshes that are drawn in place of a coarse cloth.

use std::sync::Arc;

use bevy::camera::primitives::Aabb;
use bevy::math::{Affine3A, Mat3};
use bevy::prelude::*;
use bevy::tasks::futures::check_ready;
use bevy::tasks::{AsyncComputeTaskPool, Task};

use super::drawn::{Drawn, Exchange, Released, on_remove, vertices_of};
use super::sync::hand_over;
use crate::bind::{FineMesh, VertexBuffers, Vertices, bounds_between, is_near, seen_from};
use crate::components::{Cloth, ClothLoading, ClothRenderMesh};
use crate::notices::label;
use crate::simulation::{Binding, ClothInputs, ClothRest, ClothShown, PieceBinding};
use crate::solver::embed::Embedding;
use crate::solver::rest::RestShape;

/// What each vertex of a render mesh follows, and where that takes it.
#[derive(Component)]
#[component(clone_behavior = Ignore)]
pub(crate) struct Hanging {
    source: AssetId<Mesh>,
    rest: Arc<RestShape>,
    /// As authored, in the space of the cloth's mesh.
    authored: Vertices,
    /// The same with the scale that `rest` has baked in.
    fine: FineMesh,
    making: Option<Task<Option<Embedding>>>,
    embedding: Option<Embedding>,
    vertices: VertexBuffers,
    bounds: (Vec3, Vec3),
    /// What was shaped last: the cloth, its [`ClothShown::writes`], and where the entity was.
    shaped: Option<(Entity, u32, Affine3A)>,
    fresh: bool,
}

impl Hanging {
    /// Hangs a mesh on a cloth, in the background if it is large. `place` is from the space of the mesh to that of the cloth's.
    fn new(
        source: AssetId<Mesh>,
        mesh: &Mesh,
        place: &Affine3A,
        (rest, bake): (&Arc<RestShape>, Mat3),
        is_large: bool,
    ) -> Self {
        let authored = Vertices::of(mesh, place);
        let baked = authored.moved(&Affine3A::from_mat3(bake));
        let hang = |rest: &RestShape, Vertices { positions, normals, .. }: &Vertices| {
            Embedding::new(&rest.topology.faces, &rest.positions, rest.mean_edge, positions, normals)
        };
        let pool = AsyncComputeTaskPool::try_get().filter(|_| is_large);
        let (making, embedding) = match pool {
            Some(pool) => {
                let (rest, baked) = (Arc::clone(rest), baked.clone());
                (Some(pool.spawn(async move { hang(&rest, &baked) })), None)
            }
            None => (None, hang(rest, &baked)),
        };
        Self {
            source,
            rest: Arc::clone(rest),
            authored,
            fine: FineMesh::new(baked, rest),
            making,
            embedding,
            vertices: VertexBuffers::default(),
            bounds: (Vec3::ZERO, Vec3::ZERO),
            shaped: None,
            fresh: false,
        }
    }

    /// Whether it is that of a mesh on a shape at rest, whatever the scale of that.
    fn is_of(&self, source: AssetId<Mesh>, rest: &Arc<RestShape>) -> bool {
        let same = Arc::ptr_eq(&self.rest, rest) || self.rest.topology.faces == rest.topology.faces;
        self.source == source && same
    }

    /// How far the farthest vertex was from the cloth `[m]`, once it is made; `Some(None)` if nothing can follow.
    fn made(&mut self) -> Option<Option<f32>> {
        if let Some(made) = self.making.as_mut().and_then(check_ready) {
            (self.making, self.embedding) = (None, made);
        }
        self.making.is_none().then(|| self.embedding.as_ref().map(Embedding::farthest))
    }

    /// Moves the vertices to where the cloth takes them, seen from an entity at `inverse`, the inverse of its transform in the
    /// frame of `shown`.
    fn shape(&mut self, particles: &[Vec3], inverse: &Affine3A) {
        let Self { rest, fine, embedding: Some(embedding), vertices, bounds, .. } = self else { return };
        *bounds = fine.shape(&rest.topology.faces, embedding, particles, inverse, vertices);
    }
}

/// Gives render meshes of cloths that are simulated meshes of their own, and all others theirs back.
pub(crate) fn follow(
    mut exchange: Exchange,
    loading: Res<ClothLoading>,
    mut drawn: Query<(&ClothRenderMesh, Drawn, Option<&mut Hanging>, &GlobalTransform)>,
    cloths: Query<(&Binding, &ClothRest, &ClothInputs, &GlobalTransform), With<Cloth>>,
) {
    for (&ClothRenderMesh { cloth }, mut drawn, hanging, global) in &mut drawn {
        let of = cloths.get(cloth).ok();
        let bound = (cloth, of.map(|(binding, ..)| binding));
        let words = ["render mesh", "ClothRenderMesh"];
        let (true, Some((binding, rest, inputs, carrier))) = (drawn.follows(words, bound, &mut exchange), of) else {
            continue;
        };
        let source = exchange.sources.authored(&drawn.mesh.0);
        let Some(mesh) = exchange.meshes.get(&source) else { continue };
        let vertices = vertices_of(mesh);
        let is_current =
            |hanging: &Mut<Hanging>| hanging.is_of(source.id(), &rest.0) && !exchange.sources.modified.contains(&source.id());
        let embedding = match hanging.filter(is_current) {
            Some(mut hanging) => hanging.made(),
            None => {
                let is_skinned = inputs.skin.is_some() || drawn.skinned.is_some() || drawn.taken.is_some();
                let place = if is_skinned { Affine3A::IDENTITY } else { carrier.affine().inverse() * global.affine() };
                let place = if is_near(&place) { place } else { Affine3A::IDENTITY };
                let is_large = vertices >= loading.in_background_from as usize;
                let mut hanging = Hanging::new(source.id(), mesh, &place, (&rest.0, binding.bake), is_large);
                let made = hanging.made();
                exchange.commands.entity(drawn.entity).try_insert(hanging);
                made
            }
        };
        let is_known = drawn.known(&source, vertices, &exchange);
        match embedding {
            None => drawn.release(&mut exchange.commands),
            Some(None) => {
                drawn.release(&mut exchange.commands);
                if exchange.notices.first(drawn.entity, "render mesh that cannot follow") {
                    let name = label(drawn.entity, drawn.name);
                    warn!(
                        "render mesh {name} stays as it was authored: it has positions that are not finite, or its cloth has no triangle with an area"
                    );
                }
            }
            Some(Some(_)) if is_known => {}
            Some(Some(farthest)) => {
                let (low, high) =
                    rest.0.positions.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)));
                if farthest > low.distance(high) && exchange.notices.first(drawn.entity, "render mesh far away") {
                    let [name, cloth] = [label(drawn.entity, drawn.name), label(cloth, None)];
                    warn!(
                        "render mesh {name} is up to {farthest} m away from its cloth {cloth}: author both in the same place"
                    );
                }
                drawn.take(words[0], source, &mut exchange);
            }
        }
    }
}

/// Shapes render meshes whose cloth moved, in parallel.
pub(crate) fn shape(
    mut drawn: Query<(&ClothRenderMesh, &mut Hanging, &GlobalTransform), With<PieceBinding>>,
    cloths: Query<(&Binding, &ClothShown, &ClothRest), With<Cloth>>,
) {
    let _span = debug_span!("cloth/sync").entered();
    drawn.par_iter_mut().for_each(|(&ClothRenderMesh { cloth }, mut hanging, global)| {
        let Ok((binding, shown, rest)) = cloths.get(cloth) else { return };
        let affine = global.affine();
        let now = Some((cloth, shown.writes, affine));
        let lies = is_near(&affine) && affine.matrix3.determinant() != 0.0;
        if hanging.shaped == now || !lies || shown.writes == 0 || shown.particles.len() != rest.0.positions.len() {
            return;
        }
        let hanging = &mut *hanging;
        if !Arc::ptr_eq(&hanging.rest, &rest.0) {
            if hanging.rest.topology.faces != rest.0.topology.faces {
                return;
            }
            hanging.rest = Arc::clone(&rest.0);
            hanging.fine = FineMesh::new(hanging.authored.moved(&Affine3A::from_mat3(binding.bake)), &rest.0);
        }
        hanging.shape(&shown.particles, &seen_from(&affine, shown.origin).inverse());
        (hanging.shaped, hanging.fresh) = (now, true);
    });
}

/// Hands the vertices to the meshes, and the bounds to their entities.
pub(crate) fn write(mut meshes: ResMut<Assets<Mesh>>, mut drawn: Query<(&PieceBinding, &mut Hanging, Option<&mut Aabb>)>) {
    let _span = debug_span!("cloth/sync").entered();
    for (binding, mut hanging, aabb) in &mut drawn {
        if !hanging.fresh {
            continue;
        }
        let hanging = &mut *hanging;
        hanging.fresh = false;
        let (low, high) = hanging.bounds;
        if !(low.is_finite() && high.is_finite()) {
            continue;
        }
        if let Some(mut mesh) = meshes.get_mut(&binding.instance) {
            hand_over(&mut mesh, &mut hanging.vertices);
            if let Some(mut aabb) = aabb {
                *aabb = bounds_between(low, high);
            }
        }
    }
}

/// Gives the authored mesh back when `ClothRenderMesh` is removed.
pub(crate) fn on_remove_render_mesh(removed: On<Remove, ClothRenderMesh>, mut commands: Commands, meshes: Released) {
    if let Ok(mut entity) = commands.get_entity(removed.entity) {
        entity.try_remove::<Hanging>();
    }
    on_remove(removed.entity, commands, meshes);
}
