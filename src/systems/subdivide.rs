//! Prepare: cloths that are to be finer than their mesh get a mesh that is.

use bevy::ecs::entity_disabling::Disabled;
use bevy::ecs::query::Allow;
use bevy::platform::collections::HashMap;
use bevy::prelude::*;

use crate::bind::{MOST_VERTICES, Sources, Subdivided, subdivide};
use crate::components::{Cloth, ClothPiece, ClothSubdivision};
use crate::notices::{Notices, label};

/// What the mesh of a cloth was made from.
#[derive(Component, Clone)]
pub(crate) struct SubdividedFrom {
    source: Handle<Mesh>,
    longest_edge: f32,
    /// The source itself where no edge is too long.
    made: Handle<Mesh>,
}

/// Meshes that were made, by source and longest edge.
type Made = HashMap<(AssetId<Mesh>, u32), AssetId<Mesh>>;

/// Puts a mesh with shorter edges in place of that of each cloth that asks for it, again when either changes.
pub(crate) fn meshes(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    sources: Res<Sources>,
    mut notices: ResMut<Notices>,
    mut known: Local<Made>,
    pieces: Query<&ClothPiece>,
    mut cloths: Query<
        (Entity, Option<&Name>, &mut Mesh3d, &ClothSubdivision, Option<&SubdividedFrom>),
        (With<Cloth>, Allow<Disabled>),
    >,
) {
    known.retain(|(source, _), made| meshes.contains(*made) && !sources.modified.contains(source));
    for (cloth, name, mut shown, subdivision, from) in &mut cloths {
        let authored = sources.authored(&shown.0);
        let from = from.filter(|from| from.made.id() == authored.id());
        let source = from.map_or(authored, |from| from.source.clone());
        let longest_edge = subdivision.longest_edge;
        if from.is_some_and(|from| from.longest_edge == longest_edge) && !sources.modified.contains(&source.id()) {
            continue;
        }
        if !(longest_edge > 0.0 && longest_edge < f32::INFINITY) {
            if notices.first(cloth, "subdivision.longest_edge") {
                warn!(
                    "cloth {} has a `subdivision.longest_edge` of {longest_edge}: set a length of more than 0 [m]; its mesh is as it was",
                    label(cloth, name)
                );
            }
            continue;
        }
        if from.is_none() && pieces.iter().any(|piece| piece.cloth == cloth) {
            if notices.first(cloth, "subdivision of pieces") {
                warn!(
                    "cloth {} is drawn by pieces and not subdivided: split the edges of its mesh in the program it was made with, or give it one material",
                    label(cloth, name)
                );
            }
            continue;
        }
        let key = (source.id(), longest_edge.to_bits());
        let made = match known.get(&key).and_then(|id| meshes.get_strong_handle(*id)) {
            Some(made) => made,
            None => {
                // What cannot be read is told when it is bound.
                let Some(Ok(Subdivided { mesh, is_cut })) = meshes.get(&source).map(|mesh| subdivide(mesh, longest_edge))
                else {
                    continue;
                };
                if is_cut && notices.first(cloth, "subdivision is cut") {
                    warn!(
                        "cloth {} would have more than {MOST_VERTICES} vertices with a `subdivision.longest_edge` of {longest_edge} m: \
                         its edges are longer",
                        label(cloth, name)
                    );
                }
                let made = mesh.map_or_else(|| source.clone(), |mesh| meshes.add(mesh));
                known.insert(key, made.id());
                made
            }
        };
        if shown.0.id() != made.id() {
            shown.0 = made.clone();
        }
        commands.entity(cloth).try_insert(SubdividedFrom { source, longest_edge, made });
    }
}

/// Gives the mesh back that was made finer.
pub(crate) fn on_remove_subdivision(
    removed: On<Remove, (ClothSubdivision, Cloth)>,
    mut commands: Commands,
    sources: Res<Sources>,
    mut cloths: Query<(&mut Mesh3d, &SubdividedFrom), Allow<Disabled>>,
) {
    let Ok((mut shown, from)) = cloths.get_mut(removed.entity) else { return };
    if sources.authored(&shown.0).id() == from.made.id() && from.made.id() != from.source.id() {
        shown.0 = from.source.clone();
    }
    if let Ok(mut entity) = commands.get_entity(removed.entity) {
        entity.try_remove::<SubdividedFrom>();
    }
}
