//! Sync: entities whose mesh shows a cloth in place of the cloth's own: pieces and render meshes.

use bevy::asset::RenderAssetUsages;
use bevy::camera::primitives::Aabb;
use bevy::camera::visibility::{DynamicSkinnedMeshBounds, NoAutoAabb};
use bevy::ecs::entity_disabling::Disabled;
use bevy::ecs::query::{Allow, QueryData};
use bevy::ecs::system::SystemParam;
use bevy::mesh::VertexAttributeValues;
use bevy::mesh::skinning::SkinnedMesh;
use bevy::prelude::*;

use super::release::{forget, give_back};
use crate::bind::{Sources, instance_of, unreadable};
use crate::components::Cloth;
use crate::notices::{Notices, label};
use crate::simulation::{Binding, PieceBinding, TakenSkin};

/// An entity that shows a cloth, whether or not it follows it yet.
#[derive(QueryData)]
#[query_data(mutable)]
pub(crate) struct Drawn {
    pub entity: Entity,
    pub name: Option<&'static Name>,
    pub mesh: &'static mut Mesh3d,
    pub binding: Option<&'static PieceBinding>,
    pub skinned: Option<&'static SkinnedMesh>,
    pub taken: Option<&'static TakenSkin>,
    skinned_bounds: Has<DynamicSkinnedMeshBounds>,
    own_bounds: Has<NoAutoAabb>,
    is_cloth: Has<Cloth>,
}

/// What it takes to exchange meshes.
#[derive(SystemParam)]
pub(crate) struct Exchange<'w, 's> {
    pub commands: Commands<'w, 's>,
    pub meshes: ResMut<'w, Assets<Mesh>>,
    pub sources: ResMut<'w, Sources>,
    pub notices: ResMut<'w, Notices>,
    others: Query<'w, 's, (Option<&'static Name>, Has<Cloth>)>,
}

/// Number of vertices of a mesh.
pub(super) fn vertices_of(mesh: &Mesh) -> usize {
    mesh.try_attribute(Mesh::ATTRIBUTE_POSITION).map_or(0, VertexAttributeValues::len)
}

impl DrawnItem<'_, '_> {
    /// Whether it can follow `cloth`, whose mesh is `binding`; it gets its own back otherwise. `kind` and `component` say what
    /// it is.
    pub(crate) fn follows(
        &mut self,
        [kind, component]: [&'static str; 2],
        (cloth, binding): (Entity, Option<&Binding>),
        Exchange { commands, notices, others, .. }: &mut Exchange,
    ) -> bool {
        if self.is_cloth {
            if self.binding.is_some() {
                commands.entity(self.entity).try_remove::<PieceBinding>();
            }
            if notices.first(self.entity, "shows a cloth and is one") {
                let name = label(self.entity, self.name);
                warn!("{kind} {name} is a cloth of its own and shows no other: remove `Cloth` or `{component}` from it");
            }
            return false;
        }
        if binding.is_some_and(|cloth| cloth.instance.is_some() && !cloth.on_skin) {
            return true;
        }
        // It showed one that was taken away: nothing was forgotten.
        let has_followed = self.binding.is_some();
        self.release(commands);
        let name = label(self.entity, self.name);
        match others.get(cloth) {
            Ok((of, false)) if notices.first(self.entity, "shows no cloth") && !has_followed => {
                let cloth = label(cloth, of);
                warn!("{kind} {name} shows no cloth: insert `Cloth` on {cloth}, or name a cloth in `{component}::cloth`");
            }
            Err(_) if cloth != Entity::PLACEHOLDER && notices.first(self.entity, "shows what is gone") => {
                warn!(
                    "{kind} {name} shows no cloth, since {cloth} does not exist or is disabled: name another in \
                     `{component}::cloth`, or remove `{component}`"
                );
            }
            _ => {}
        }
        false
    }

    /// What it is bound to, if that is its mesh as it is now.
    pub(crate) fn known(&self, source: &Handle<Mesh>, vertices: usize, Exchange { sources, meshes, .. }: &Exchange) -> bool {
        self.binding.is_some_and(|binding| {
            binding.instance.id() == self.mesh.0.id()
                && !sources.modified.contains(&source.id())
                && meshes.get(&binding.instance).is_some_and(|mesh| vertices_of(mesh) == vertices)
        })
    }

    /// Puts a mesh of its own in place of the authored one, and takes its skin off.
    pub(crate) fn take(
        &mut self,
        kind: &str,
        source: Handle<Mesh>,
        Exchange { commands, meshes, sources, notices, .. }: &mut Exchange,
    ) {
        let Some(mesh) = meshes.get(&source) else { return };
        let instance = match instance_of(mesh, RenderAssetUsages::default()) {
            Ok(instance) => meshes.add(instance),
            Err(error) => {
                if notices.first(self.entity, "shows a cloth and cannot be read") {
                    warn!("{kind} {} stays as it was authored: {}", label(self.entity, self.name), unreadable(&error));
                }
                return;
            }
        };
        // A clone shows the mesh of that piece still, whose bounds were ours.
        let is_clone = self.binding.is_none() && sources.is_instance(self.mesh.0.id());
        sources.insert(instance.id(), source.clone());
        self.mesh.0 = instance.clone();
        let own_bounds = self.binding.map_or(self.own_bounds && !is_clone, |binding| binding.own_bounds);
        let mut entity = commands.entity(self.entity);
        entity.try_insert((PieceBinding { source, instance, own_bounds, written: None }, NoAutoAabb, Aabb::default()));
        if let Some(SkinnedMesh { inverse_bindposes, joints }) = self.skinned.cloned() {
            entity.try_insert(TakenSkin { inverse_bindposes, joints, bounds: self.skinned_bounds });
        }
        entity.try_remove::<(SkinnedMesh, DynamicSkinnedMeshBounds)>();
    }

    /// Gives it its authored mesh, its skin and its bounds back.
    pub(crate) fn release(&mut self, commands: &mut Commands) {
        if let Some(binding) = self.binding {
            release(&mut commands.entity(self.entity), Some(&mut self.mesh), binding, self.taken);
        }
    }
}

/// Gives an entity its authored mesh, its skin and its bounds back.
fn release(entity: &mut EntityCommands, mesh: Option<&mut Mesh3d>, binding: &PieceBinding, taken: Option<&TakenSkin>) {
    if let Some(mesh) = mesh
        && mesh.0.id() == binding.instance.id()
    {
        mesh.0 = binding.source.clone();
    }
    entity.try_remove::<PieceBinding>();
    give_back(entity, binding.own_bounds, taken);
}

/// Entities that show a cloth, and what to give back to them.
pub(crate) type Released<'w, 's, 'a> =
    Query<'w, 's, (Option<&'a mut Mesh3d>, &'a PieceBinding, Option<&'a TakenSkin>, Has<Cloth>), Allow<Disabled>>;

/// Gives the authored mesh back when what made an entity show a cloth is removed.
pub(super) fn on_remove(removed: Entity, mut commands: Commands, mut drawn: Released) {
    forget(&mut commands, removed);
    let Ok((mesh, binding, taken, is_cloth)) = drawn.get_mut(removed) else { return };
    let Ok(mut entity) = commands.get_entity(removed) else { return };
    if is_cloth {
        entity.try_remove::<PieceBinding>();
    } else {
        release(&mut entity, mesh.map(Mut::into_inner), binding, taken);
    }
}
