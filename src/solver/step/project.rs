//! The second half of a substep: bodies, limits of the skin, and how far tethers give way to them.

use glam::Vec4;

use super::frame::Frame;
use super::{Memory, Stepped};
use crate::solver::body::{Bearing, BodyContext, Projection, Touch};
use crate::solver::couple::Coupling;
use crate::solver::settings::Fabric;
use crate::solver::state::StateMut;

/// Most by which tethers give way, as a share of their length at rest (dimensionless). How fast they do, and come back `[1/s]`:
/// cloth that is let go from a body would be thrown.
const MOST_GIVE: f32 = 0.05;
const GIVE_WAY: f32 = 10.0;
const GIVE_BACK: f32 = 0.5;

impl Stepped<'_> {
    /// Puts what lies on bodies where [`Self::project`] will put it, until that begins; for what is done in between.
    pub(crate) fn project_provisionally(&self, state: &mut StateMut<'_>, memory: &mut Memory) {
        let Some(span) = memory.frame.as_ref().map(Frame::span) else { return };
        let Memory { contacts, faces, coupling, provisional, .. } = memory;
        let mut context = self.context(span, coupling);
        contacts.project_provisionally(&mut context, state.positions, provisional);
        faces.project_provisionally(&mut context, state.positions, provisional);
    }

    /// Ends the substep: keeps the cloth out of bodies, holds what slips on them, and keeps it within the limits of its skin.
    pub(crate) fn project(&self, state: &mut StateMut<'_>, memory: &mut Memory) {
        let Some(frame) = memory.frame else { return };
        let span = frame.span();
        memory.provisional.restore(state.positions);
        let touches = self.push_out(span, Projection::First, state, memory);
        // Skinned cloth is laid on its bones instead, before each sweep of `tighten`.
        if frame.taut && memory.faces.candidates() > 0 && self.input.skinned.is_none() {
            self.tighten_over_corners(&frame, state.positions, memory);
            self.push_out(span, Projection::Relax, state, memory);
        }
        self.apply_friction(span, state, memory);
        memory.faces.stop_again(&mut self.context(span, &mut memory.coupling), state.positions, state.previous);
        if let Some(skinned) = self.input.skinned {
            let (x, old) = (&mut state.positions, &mut state.previous);
            skinned.limit(&memory.tangled_limits, [span.0, span.1], x, old);
        }
        // Without a fast body once a frame is enough.
        if memory.fast_body || span.1 == 1.0 {
            let since = if memory.fast_body { frame.h } else { frame.dt };
            memory.give = give(self.fabric, memory, state.positions, since);
        }
        if let Some(frame) = &mut memory.frame {
            frame.report.body_contacts = touches;
        }
    }

    /// Calls `lies` for particles that touched a body in the substep, with how that bears them.
    pub(crate) fn each_on_body(&self, state: &StateMut<'_>, memory: &mut Memory, mut lies: impl FnMut(u32, Option<Bearing>)) {
        let Some(span) = memory.frame.as_ref().map(Frame::span) else { return };
        let Memory { contacts, faces, coupling, .. } = memory;
        let mut context = self.context(span, coupling);
        contacts.each_touch(&mut context, state.positions, &mut lies);
        faces.each_touch(&mut context, state.positions, &mut lies);
    }

    /// Bodies at the end of the substep, as the cloth touches them. `span`: shares of the frame at which it begins and ends.
    pub(super) fn context<'b>(&'b self, span: (f32, f32), coupling: &'b mut Coupling) -> BodyContext<'b> {
        BodyContext { bodies: self.input.bodies, span, touch: Touch::of(self.fabric), coupling }
    }

    /// Pushes particles, then faces, out of bodies; the number of touches.
    fn push_out(&self, span: (f32, f32), projection: Projection, state: &mut StateMut<'_>, memory: &mut Memory) -> u32 {
        let (x, old) = (&mut state.positions, &mut state.previous);
        let Memory { contacts, faces, inbound, coupling, .. } = memory;
        let mut context = self.context(span, coupling);
        let touches = contacts.project(&mut context, x, old, inbound, projection);
        if projection == Projection::Relax {
            return touches;
        }
        touches + faces.project(&mut context, x, old)
    }

    /// Holds what slips on bodies.
    fn apply_friction(&self, span: (f32, f32), state: &mut StateMut<'_>, memory: &mut Memory) {
        let Memory { contacts, faces, coupling, .. } = memory;
        let mut context = self.context(span, coupling);
        contacts.apply_friction(&mut context, state.positions, state.previous);
        faces.apply_friction(&mut context, state.positions, state.previous);
    }
}

/// How far tethers give way now, as a share of their length at rest (dimensionless), a time of `dt` `[s]` after they gave
/// `memory.give`. A body may hold cloth farther from its pins than they are long, by more than its thickness. Such cloth is
/// longer all the way to them, within its strain limit, not only where the body is.
fn give(fabric: &Fabric, memory: &Memory, positions: &[Vec4], dt: f32) -> f32 {
    let excess = memory.factors.tethers.excess(memory.grounded(), fabric.tether_scale, fabric.thickness, positions);
    let most = fabric.strain_limit.clamp(0.0, MOST_GIVE);
    memory.give + (excess.min(most) - memory.give).clamp(-GIVE_BACK * dt, GIVE_WAY * dt)
}
