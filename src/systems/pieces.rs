//! Sync: meshes that show a part of a cloth each, so that a cloth can have several materials.

use bevy::camera::primitives::Aabb;
use bevy::mesh::{MeshVertexAttribute, VertexAttributeValues};
use bevy::prelude::*;

use super::drawn::{Drawn, Exchange, Released, on_remove, vertices_of};
use crate::bind::bounds_between;
use crate::components::{Cloth, ClothPiece, ClothRenderMesh};
use crate::notices::label;
use crate::simulation::{Binding, ClothShown, PieceBinding};

/// Gives pieces of cloths that are simulated meshes of their own, and all others theirs back.
pub(crate) fn follow(
    mut exchange: Exchange,
    mut pieces: Query<(&ClothPiece, Drawn), Without<ClothRenderMesh>>,
    cloths: Query<(&Binding, &ClothShown), With<Cloth>>,
) {
    for (piece, mut drawn) in &mut pieces {
        let cloth = cloths.get(piece.cloth).ok();
        let bound = (piece.cloth, cloth.map(|(binding, _)| binding));
        let (true, Some((_, shown))) = (drawn.follows(["piece", "ClothPiece"], bound, &mut exchange), cloth) else {
            continue;
        };
        let source = exchange.sources.authored(&drawn.mesh.0);
        let Some(vertices) = exchange.meshes.get(&source).map(vertices_of) else { continue };
        let is_known = drawn.known(&source, vertices, &exchange);
        let (first, all) = (piece.first as usize, shown.vertices.positions.len());
        if first.saturating_add(vertices) > all {
            if is_known {
                drawn.release(&mut exchange.commands);
            }
            if exchange.notices.first(drawn.entity, "piece past the end") {
                let [name, cloth] = [label(drawn.entity, drawn.name), label(piece.cloth, None)];
                warn!(
                    "piece {name} has {vertices} vertices from number {first} on, and the mesh of its cloth {cloth} has {all}: \
                     set `ClothPiece::first`, and merge the meshes of all pieces into that of the cloth"
                );
            }
            continue;
        }
        if !is_known {
            drawn.take("piece", source, &mut exchange);
        }
    }
}

/// Gives the authored mesh back when `ClothPiece` is removed.
pub(crate) fn on_remove_piece(removed: On<Remove, ClothPiece>, commands: Commands, pieces: Released) {
    on_remove(removed.entity, commands, pieces);
}

/// What of a cloth its pieces show.
const SHOWN: [MeshVertexAttribute; 3] = [Mesh::ATTRIBUTE_POSITION, Mesh::ATTRIBUTE_NORMAL, Mesh::ATTRIBUTE_TANGENT];

/// Hands the vertices of cloths to the meshes of their pieces, where they were written since.
pub(crate) fn write(
    mut meshes: ResMut<Assets<Mesh>>,
    mut pieces: Query<(&ClothPiece, &mut PieceBinding, Option<&mut Aabb>), Without<ClothRenderMesh>>,
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
            *aabb = bounds_between(low, high);
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
