//! Sync: meshes that show a part of a cloth each, so that a cloth can have several materials.

use bevy::asset::RenderAssetUsages;
use bevy::camera::primitives::Aabb;
use bevy::camera::visibility::{DynamicSkinnedMeshBounds, NoAutoAabb};
use bevy::ecs::entity_disabling::Disabled;
use bevy::ecs::query::{Allow, QueryData};
use bevy::mesh::skinning::SkinnedMesh;
use bevy::mesh::{MeshVertexAttribute, VertexAttributeValues};
use bevy::prelude::*;

use super::release::{forget, give_back};
use crate::bind::{Sources, instance_of, unreadable};
use crate::components::{Cloth, ClothPiece};
use crate::notices::{Notices, label};
use crate::simulation::{Binding, ClothShown, PieceBinding, TakenSkin};

/// A piece, whether or not it follows its cloth yet.
#[derive(QueryData)]
#[query_data(mutable)]
pub(crate) struct Piece {
    entity: Entity,
    name: Option<&'static Name>,
    piece: &'static ClothPiece,
    mesh: &'static mut Mesh3d,
    binding: Option<&'static PieceBinding>,
    skinned: Option<&'static SkinnedMesh>,
    taken: Option<&'static TakenSkin>,
    skinned_bounds: Has<DynamicSkinnedMeshBounds>,
    own_bounds: Has<NoAutoAabb>,
    is_cloth: Has<Cloth>,
}

/// Gives pieces of cloths that are simulated meshes of their own, and all others theirs back.
pub(crate) fn follow(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut sources: ResMut<Sources>,
    mut notices: ResMut<Notices>,
    mut pieces: Query<Piece>,
    cloths: Query<(&Binding, &ClothShown), With<Cloth>>,
    others: Query<(Option<&Name>, Has<Cloth>)>,
) {
    for mut piece in &mut pieces {
        if piece.is_cloth {
            if piece.binding.is_some() {
                commands.entity(piece.entity).try_remove::<PieceBinding>();
            }
            if notices.first(piece.entity, "piece that is a cloth") {
                let name = label(piece.entity, piece.name);
                warn!("piece {name} is a cloth of its own and shows no other: remove `Cloth` or `ClothPiece` from it");
            }
            continue;
        }
        let cloth = cloths.get(piece.piece.cloth).ok().filter(|(cloth, _)| cloth.instance.is_some() && !cloth.on_skin);
        let Some((_, shown)) = cloth else {
            if let Some(binding) = piece.binding {
                release(&mut commands.entity(piece.entity), Some(&mut piece.mesh), binding, piece.taken);
            }
            let name = match others.get(piece.piece.cloth) {
                Ok((name, false)) => name,
                Err(_) if piece.piece.cloth != Entity::PLACEHOLDER => None,
                _ => continue,
            };
            if notices.first(piece.entity, "piece of no cloth") {
                let [piece, cloth] = [label(piece.entity, piece.name), label(piece.piece.cloth, name)];
                warn!("piece {piece} shows no cloth: insert `Cloth` on {cloth}, or name a cloth in `ClothPiece::cloth`");
            }
            continue;
        };
        let vertices_of = |mesh: &Mesh| mesh.try_attribute(Mesh::ATTRIBUTE_POSITION).map_or(0, VertexAttributeValues::len);
        let source = sources.authored(&piece.mesh.0);
        let Some(mesh) = meshes.get(&source) else { continue };
        let vertices = vertices_of(mesh);
        let is_known = |binding: &&PieceBinding| {
            binding.instance.id() == piece.mesh.0.id()
                && !sources.modified.contains(&source.id())
                && meshes.get(&binding.instance).is_some_and(|mesh| vertices_of(mesh) == vertices)
        };
        let binding = piece.binding.filter(is_known);
        let (first, all) = (piece.piece.first as usize, shown.vertices.positions.len());
        if first.saturating_add(vertices) > all {
            if let Some(binding) = binding {
                release(&mut commands.entity(piece.entity), Some(&mut piece.mesh), binding, piece.taken);
            }
            if notices.first(piece.entity, "piece past the end") {
                let [name, cloth] = [label(piece.entity, piece.name), label(piece.piece.cloth, None)];
                warn!(
                    "piece {name} has {vertices} vertices from number {first} on, and the mesh of its cloth {cloth} has {all}: \
                     set `ClothPiece::first`, and merge the meshes of all pieces into that of the cloth"
                );
            }
            continue;
        }
        if binding.is_none() {
            let instance = match instance_of(mesh, RenderAssetUsages::default()) {
                Ok(instance) => meshes.add(instance),
                Err(error) => {
                    if notices.first(piece.entity, "piece that cannot be read") {
                        warn!("piece {} stays as it was authored: {}", label(piece.entity, piece.name), unreadable(&error));
                    }
                    continue;
                }
            };
            give_instance(&mut commands.entity(piece.entity), &mut piece, &mut sources, source, instance);
        }
    }
}

/// Puts a mesh of its own in place of the authored one of a piece, and takes its skin off.
fn give_instance(
    entity: &mut EntityCommands,
    piece: &mut PieceItem,
    sources: &mut Sources,
    source: Handle<Mesh>,
    instance: Handle<Mesh>,
) {
    // A clone shows the mesh of that piece still, whose bounds were ours.
    let is_clone = piece.binding.is_none() && sources.is_instance(piece.mesh.0.id());
    sources.insert(instance.id(), source.clone());
    piece.mesh.0 = instance.clone();
    let own_bounds = piece.binding.map_or(piece.own_bounds && !is_clone, |binding| binding.own_bounds);
    entity.try_insert((PieceBinding { source, instance, own_bounds, written: None }, NoAutoAabb, Aabb::default()));
    if let Some(SkinnedMesh { inverse_bindposes, joints }) = piece.skinned.cloned() {
        entity.try_insert(TakenSkin { inverse_bindposes, joints, bounds: piece.skinned_bounds });
    }
    entity.try_remove::<(SkinnedMesh, DynamicSkinnedMeshBounds)>();
}

/// Gives a piece its authored mesh, its skin and its bounds back.
fn release(entity: &mut EntityCommands, mesh: Option<&mut Mesh3d>, binding: &PieceBinding, taken: Option<&TakenSkin>) {
    if let Some(mesh) = mesh
        && mesh.0.id() == binding.instance.id()
    {
        mesh.0 = binding.source.clone();
    }
    entity.try_remove::<PieceBinding>();
    give_back(entity, binding.own_bounds, taken);
}

/// Gives the authored mesh back when `ClothPiece` is removed.
pub(crate) fn on_remove_piece(
    removed: On<Remove, ClothPiece>,
    mut commands: Commands,
    mut pieces: Query<(Option<&mut Mesh3d>, &PieceBinding, Option<&TakenSkin>, Has<Cloth>), Allow<Disabled>>,
) {
    forget(&mut commands, removed.entity);
    let Ok((mesh, binding, taken, is_cloth)) = pieces.get_mut(removed.entity) else { return };
    let Ok(mut entity) = commands.get_entity(removed.entity) else { return };
    if is_cloth {
        entity.try_remove::<PieceBinding>();
    } else {
        release(&mut entity, mesh.map(Mut::into_inner), binding, taken);
    }
}

/// What of a cloth its pieces show.
const SHOWN: [MeshVertexAttribute; 3] = [Mesh::ATTRIBUTE_POSITION, Mesh::ATTRIBUTE_NORMAL, Mesh::ATTRIBUTE_TANGENT];

/// Hands the vertices of cloths to the meshes of their pieces, where they were written since.
pub(crate) fn write(
    mut meshes: ResMut<Assets<Mesh>>,
    mut pieces: Query<(&ClothPiece, &mut PieceBinding, Option<&mut Aabb>)>,
    cloths: Query<(&Binding, &ClothShown), With<Cloth>>,
) {
    for (piece, mut binding, aabb) in &mut pieces {
        let Ok((Binding { instance: Some(whole), .. }, shown)) = cloths.get(piece.cloth) else { continue };
        let now = Some((piece.cloth, piece.first, shown.writes));
        if binding.written == now {
            continue;
        }
        // Taken out meanwhile, since two meshes are not borrowed at once.
        let Some(mesh) = meshes.get_mut_untracked(&binding.instance) else { continue };
        let mut values = SHOWN.map(|attribute| take_values(mesh, attribute));
        if let Some(whole) = meshes.get(whole) {
            for (attribute, values) in SHOWN.into_iter().zip(&mut values) {
                copy(whole, attribute, piece.first as usize, values);
            }
            binding.written = now;
        }
        if let Some(mut mesh) = meshes.get_mut(&binding.instance) {
            for (attribute, values) in SHOWN.into_iter().zip(values) {
                if let Ok(empty) = mesh.try_attribute_mut(attribute) {
                    *empty = values;
                }
            }
        }
        let (low, high) = shown.bounds;
        if let Some(mut aabb) = aabb.filter(|_| low.is_finite() && high.is_finite()) {
            *aabb = Aabb::from_min_max(low, high);
        }
    }
}

/// Takes the values of an attribute out of a mesh; nothing where it has none.
fn take_values(mesh: &mut Mesh, attribute: MeshVertexAttribute) -> VertexAttributeValues {
    let nothing = VertexAttributeValues::Float32x3(Vec::new());
    match mesh.try_attribute_mut(attribute) {
        Ok(values) => core::mem::replace(values, nothing),
        Err(_) => nothing,
    }
}

/// Copies what the vertices from `first` on have of an attribute, where there are as many.
fn copy(whole: &Mesh, attribute: MeshVertexAttribute, first: usize, to: &mut VertexAttributeValues) {
    use VertexAttributeValues::{Float32x3, Float32x4};
    match (whole.try_attribute(attribute), to) {
        (Ok(Float32x3(from)), Float32x3(to)) => copy_run(from, first, to),
        (Ok(Float32x4(from)), Float32x4(to)) => copy_run(from, first, to),
        _ => {}
    }
}

fn copy_run<T: Copy>(from: &[T], first: usize, to: &mut [T]) {
    if let Some(from) = from.get(first..).and_then(|from| from.get(..to.len())) {
        to.copy_from_slice(from);
    }
}
