//! Moves cloth without letting time pass.

use super::Memory;
use crate::solver::body::{Body, BodyContext, Projection, Touch};
use crate::solver::settings::Fabric;
use crate::solver::state::ClothState;

/// Lets something else than time move the cloth, as untangling does, and keeps it out of bodies on its way: no speed comes of
/// that. Whether bodies stopped anything.
pub(crate) fn displace(
    fabric: &Fabric,
    bodies: &[Body],
    state: &mut ClothState,
    memory: &mut Memory,
    displace: impl FnOnce(&mut ClothState),
) -> bool {
    if bodies.is_empty() {
        displace(state);
        return false;
    }
    let Memory { before, displaced, contacts, faces, coupling, .. } = memory;
    let (before, displaced) = (&mut **before, &mut **displaced);
    before.clone_from(&state.positions);
    displace(state);
    if state.positions == *before {
        return false;
    }
    let x = &mut state.positions;
    displaced.clone_from(x);
    let slip = Touch::frictionless(fabric);
    let mut context = BodyContext { bodies, span: (1.0, 1.0), touch: slip, coupling };
    contacts.project(&mut context, x, before, &[], Projection::First);
    faces.project(&mut context, x, before);
    let mut stopped = false;
    for ((x, old), displaced) in x.iter().zip(&mut state.previous).zip(displaced) {
        if x != displaced {
            *old += *x - *displaced;
            stopped = true;
        }
    }
    stopped
}
