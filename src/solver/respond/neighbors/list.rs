//! Lists a pair of primitives that may touch, with the side it is on and the distance it keeps.

use super::MARGIN;
use super::narrow_phase::{NarrowPhase, Search};
use super::near::{Found, REST_SHARE};
use crate::solver::detect::ProximityKind;
use crate::solver::respond::contact::Contact;

/// Share of their thickness at which pairs are kept apart where how far they are is not up to them (dimensionless). That is
/// where both sides are pinned somewhere, as cloth beside pins that are closer would have to stretch. It is around a tangle,
/// too, if they are no farther apart. None lets cloth cross there; all of it is that stretch, and that buckling.
const LEAST_KEPT: f32 = 0.1;

/// How much both sides of a pair belong to a tangle (0 to 1, dimensionless) from which on it is left to untangling. Where they
/// do less, around it, a pair is kept about as far apart as it is. Sheets that cross at a small angle, pushed to their
/// thickness, would buckle and cross more.
const WITHIN_TANGLE: f32 = 0.9;

impl<T: Fn(u32) -> f32, F: FnMut(u32) -> bool> NarrowPhase<'_, T, F> {
    /// Lists a pair that was `found`, if it may touch.
    #[inline]
    pub(super) fn list(&mut self, found: &Found) {
        if self.outcome.room == 0 {
            return;
        }
        let &Found { pair, faces, normal, .. } = found;
        let &Search { surface, touch, takes_part, .. } = self.search;
        let ids = pair.particles;
        let first = if pair.kind == ProximityKind::VertexFace { 1 } else { 2 };
        let (p, q) = (surface.part(ids[0]), surface.part(ids[3]));
        if !(takes_part[usize::from(p)] && takes_part[usize::from(q)]) {
            return;
        }
        let whole = 0.5 * (touch[usize::from(p)].thickness + touch[usize::from(q)].thickness);
        let (mut thickness, margin) = (whole, MARGIN * whole);
        let tangled = self.tangled(&ids[..first]).min(self.tangled(&ids[first..]));
        if !normal.is_finite() || tangled > WITHIN_TANGLE {
            self.outcome.coincide |= !normal.is_finite();
            return;
        }
        let far = |thickness: f32| found.is_far(thickness + margin);
        if far(thickness) {
            return;
        }
        if found.at_rest < f32::INFINITY {
            thickness = thickness.min(REST_SHARE * found.at_rest);
            if thickness <= 0.0 || far(thickness) {
                return;
            }
        }
        if self.search.is_inverted(pair.kind, ids) {
            return;
        }
        // Looked for as far as any other, so that nothing meets unseen.
        if self.is_pinned(&ids[..first]) && self.is_pinned(&ids[first..]) {
            thickness = thickness.min(LEAST_KEPT * whole);
        } else if tangled > 0.0 {
            thickness = thickness.min(pair.distance.max(LEAST_KEPT * whole));
        }
        self.outcome.room -= 1;
        self.outcome.pairs.push(Contact {
            kind: pair.kind,
            faces,
            particles: ids,
            weights: pair.weights,
            normal,
            thickness,
            parts: [p, q],
            inverted: false,
            was_inverted: false,
        });
    }

    /// How much the particles of a primitive belong to a tangle, at most (0 to 1, dimensionless).
    #[inline]
    fn tangled(&self, ids: &[u32]) -> f32 {
        ids.iter().map(|&v| (self.search.tangled)(v)).fold(0.0, f32::max)
    }

    /// Whether pins hold a particle of a primitive.
    #[inline]
    fn is_pinned(&self, ids: &[u32]) -> bool {
        ids.iter().any(|&v| self.search.pinned[v as usize])
    }
}
