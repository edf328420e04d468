//! Holds a cloth to its strain limit within a substep: springs before bodies are met, and whatever bodies and contacts have
//! stretched after.

use glam::{Vec3, Vec4};

use super::frame::Frame;
use super::shorten::limit_ways;
use super::strain::{TAUT, WILD};
use super::{Memory, Stepped};
use crate::solver::state::StateMut;

/// Sweeps for the strain limit in each substep of a taut cloth, and in each turn with contacts.
const TAUT_SWEEPS: u32 = 2;

/// The same for skinned cloth near bones that are finer than its mesh. With two, one start in twenty of a running human tangles
/// its clothes for half a second. A bone is in the cape in twice as many frames of a walk.
const SKINNED_SWEEPS: u32 = 4;

/// The same for a settling cloth, whose edges are shortened at the end of a frame only far beyond the limit.
pub(super) const SETTLING_SWEEPS: u32 = 8;

/// Turns of a sweep and a push out of bodies that are finer than the mesh (dimensionless). A sheet of 60² falls over a box. Its
/// worst edge is 1.30 of its length with 4, 1.22 with 8 and 1.16 with 16 **`[measured]`**.
const CORNER_TURNS: u32 = 8;

impl Stepped<'_> {
    /// Lists the springs that may get to the strain limit within the frame.
    pub(super) fn find_tight(&self, settling: bool, state: &StateMut<'_>, memory: &mut Memory) {
        // A settling cloth would feel a list that shrinks.
        let all = memory.is_wild(self.fabric);
        memory.tight.find(&self.rest.springs, self.fabric.strain_limit, (all, settling), state.positions);
    }

    /// Shortens springs beyond the strain limit. Skinned cloth is laid on its bones before each sweep. It takes no
    /// [turns](Self::tighten_over_corners): its skin would press it deeper between bones.
    pub(super) fn tighten(&self, frame: &Frame, positions: &mut [Vec4], memory: &mut Memory) {
        let Self { rest, fabric, input, .. } = *self;
        let Memory { tight, factors, contacts, faces, coupling, provisional, .. } = memory;
        let mut context = self.context(frame.span(), coupling);
        let on_bones = faces.candidates() > 0 && input.skinned.is_some();
        let sweeps = match (frame.settling, on_bones) {
            (true, _) => SETTLING_SWEEPS,
            (false, true) => SKINNED_SWEEPS,
            (false, false) => TAUT_SWEEPS,
        };
        for _ in 0..sweeps {
            if on_bones {
                contacts.project_provisionally(&mut context, positions, provisional);
                faces.project_provisionally(&mut context, positions, provisional);
            }
            tight.solve(&rest.springs, &factors.springs, fabric.strain_limit, positions);
        }
        provisional.restore(positions);
    }

    /// Takes turns of a sweep for the strain limit and a push out of bodies, before friction. Springs draw what hangs on a
    /// corner into it; one push out would stretch the edges next to it. Sweeps may draw a particle through something thin, out
    /// of which [`Projection::Relax`](crate::solver::body::Projection::Relax) then pushes it.
    pub(super) fn tighten_over_corners(&self, frame: &Frame, positions: &mut [Vec4], memory: &mut Memory) {
        let Self { rest, fabric, anchors, .. } = *self;
        let (h, span) = (frame.h, frame.span());
        for _ in 0..CORNER_TURNS {
            memory.coupling.place(anchors, span.1, positions);
            memory.coupling.note(positions);
            memory.tight.solve(&rest.springs, &memory.factors.springs, fabric.strain_limit, positions);
            // Before bodies push: pins bear only what springs did.
            self.pull(h, span.1, Vec3::ZERO, memory, positions);
            let Memory { contacts, faces, coupling, .. } = memory;
            let mut context = self.context(span, coupling);
            contacts.push_to_planes(&mut context, positions);
            faces.push_to_planes(&mut context, positions);
        }
    }

    /// Whether neither bodies nor a skin are near, which stretch cloth, too, and which it would be drawn through.
    pub(crate) fn stands_alone(&self, memory: &Memory) -> bool {
        self.input.skinned.is_none() && !memory.is_near_bodies()
    }

    /// Shortens edges that cloth holds beyond the strain limit, if one is [far beyond](WILD) it, or when `again` still
    /// [taut](TAUT); whether it is. No particle goes farther than a thickness in a substep. Only where cloth [stands
    /// alone](Self::stands_alone); `again` only what was shortened in the first turn.
    pub(crate) fn shorten_overlong(&self, again: bool, state: &mut StateMut<'_>, memory: &mut Memory) -> bool {
        let Self { rest, fabric, .. } = *self;
        let bound = 1.0 + fabric.strain_limit;
        let from = if again { TAUT } else { WILD };
        let x = &mut *state.positions;
        let alone = self.stands_alone(memory);
        let Memory { overlong, factors, displaced: before, .. } = memory;
        if !again {
            before.clear();
        } else if before.is_empty() {
            return false;
        }
        if !alone || !overlong.find(&rest.springs, [bound, 1.0 + from * fabric.strain_limit], x) {
            return false;
        }
        if !again {
            x.clone_into(before);
        }
        overlong.shorten(&rest.springs, &factors.springs, bound, TAUT_SWEEPS, x);
        limit_ways(x, before, fabric.thickness);
        true
    }
}
