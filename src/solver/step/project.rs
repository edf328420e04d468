//! The second half of a substep: bodies, limits of the skin, and how far tethers give way to them.

use glam::Vec4;

use super::frame::Frame;
use super::{Scratch, Stepped};
use crate::solver::body::{Grounds, Touch};
use crate::solver::settings::Fabric;
use crate::solver::state::ClothState;

/// Most by which tethers give way, as a share of their length at rest (dimensionless). How fast they do, and come back `[1/s]`:
/// cloth that is let go from a body would be thrown.
const MOST_GIVE: f32 = 0.05;
const GIVE_WAY: f32 = 10.0;
const GIVE_BACK: f32 = 0.5;

impl Stepped<'_> {
    /// Puts what lies on bodies where [`Self::project`] will put it, until that begins; for what is done in between. `rubs`:
    /// whether friction is to hold it there, too.
    pub fn project_provisionally(&self, rubs: bool, state: &mut ClothState, scratch: &mut Scratch) {
        let Some(span) = scratch.frame.as_ref().map(Frame::span) else { return };
        let Scratch { contacts, faces, coupling, provisional, .. } = scratch;
        let mut grounds = Grounds { bodies: self.input.bodies, span, touch: Touch::of(self.fabric), rubs, coupling };
        contacts.project_provisionally(&mut grounds, &mut state.positions, &state.previous, provisional);
        faces.project_provisionally(&mut grounds, &mut state.positions, &state.previous, provisional);
    }

    /// Ends the substep: keeps the cloth out of bodies, and within the limits of its skin.
    pub fn project(&self, state: &mut ClothState, scratch: &mut Scratch) {
        let Some(frame) = &mut scratch.frame else { return };
        let (s0, s1) = frame.span();
        let touch = Touch::of(self.fabric);
        let (x, old, coupling) = (&mut state.positions, &mut state.previous, &mut scratch.coupling);
        scratch.provisional.restore(x);
        frame.report.body_contacts =
            scratch.contacts.project(self.input.bodies, s0, s1, x, old, &scratch.inbound, &touch, coupling);
        frame.report.body_contacts += scratch.faces.project(self.input.bodies, s0, s1, x, old, &touch, coupling);
        if let Some(skinned) = self.input.skinned {
            skinned.limit(&scratch.tangled_limits, [s0, s1], x, old);
        }
        // Without a fast body once a frame is enough.
        if scratch.fast_body || s1 == 1.0 {
            let since = if scratch.fast_body { frame.h } else { frame.dt };
            scratch.give = give(self.fabric, scratch, x, since);
        }
    }
}

/// How far tethers give way now, as a share of their length at rest (dimensionless), a time of `dt` `[s]` after they gave
/// `scratch.give`. A body may hold cloth farther from its pins than they are long, by more than its thickness. Such cloth is
/// longer all the way to them, within its strain limit, not only where the body is.
fn give(fabric: &Fabric, scratch: &Scratch, positions: &[Vec4], dt: f32) -> f32 {
    let excess = scratch.tethers.excess(scratch.grounded(), fabric.tether_scale, fabric.thickness, positions);
    let most = fabric.strain_limit.clamp(0.0, MOST_GIVE);
    scratch.give + (excess.min(most) - scratch.give).clamp(-GIVE_BACK * dt, GIVE_WAY * dt)
}
