//! Warnings about a cloth that was bound: what holds nothing, what cannot be used, and the cure.

use bevy::prelude::*;

use super::BindableItem;
use crate::bind::Resolved;
use crate::components::ClothDecimation;
use crate::notices::{Notices, label};
use crate::solver::rest::RestShape;

/// Warns of a cloth that hardly bends, since cloth bends only at edges between two triangles.
pub(super) fn tell_of_a_board(notices: &mut Notices, cloth: &BindableItem, rest: &RestShape) {
    if rest.bends.count < 2 && notices.first(cloth.entity, "a board") {
        let count = if rest.bends.count == 1 { "one" } else { "none" };
        let cure = if ClothDecimation::usable(cloth.decimation) > 0.0 {
            "`ClothDecimation` leaves too few: set a shorter `shortest_edge`"
        } else {
            "subdivide its mesh, or add `ClothSubdivision`"
        };
        warn!(
            "cloth {} moves like a board: cloth bends at edges between two triangles, and it has {count}; {cure}",
            label(cloth.entity, cloth.name)
        );
    }
}

/// Warns of pins that hold nothing.
pub(super) fn tell_of_pins(notices: &mut Notices, cloth: &BindableItem, resolved: &Resolved, vertices: usize) {
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
pub(super) fn tell_of_skin(notices: &mut Notices, cloth: &BindableItem, unfollowed: &[(&'static str, String)]) {
    for &(name, ref reason) in unfollowed {
        if notices.first(cloth.entity, name) {
            warn!("cloth {} does without `{name}`, whose map is to {reason}", label(cloth.entity, cloth.name));
        }
    }
}

/// Warns of a length that cannot be used: the cloth is as fine as its mesh.
pub(super) fn tell_of_decimation(notices: &mut Notices, cloth: &BindableItem) {
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
