//! Lists a pair of primitives that may touch, with the side it is on and the distance it keeps.

use glam::{Vec3, Vec3A};

use super::ask::{Asked, PRIMITIVES};
use super::{MARGIN, Touch};
use crate::solver::body::Friction;
use crate::solver::detect::Proximity;
use crate::solver::detect::proximity::distance_at_rest;
use crate::solver::respond::contact::Contact;

/// Pairs of one cloth are kept no farther apart than this share of their distance at rest (dimensionless). In folds of less
/// than 60°, which are taken for [flat](crate::solver::detect::tree::FLAT), they may get to half of it. Yet 0.5 here took twice
/// as long to untangle a garment of many layers **`[measured]`**.
const REST_SHARE: f32 = 0.7;

/// Share of their thickness at which pairs are kept apart where how far they are is not up to them (dimensionless). That is
/// where both sides are pinned somewhere, as cloth beside pins that are closer would have to stretch. It is around a tangle,
/// too, if they are no farther apart. None lets cloth cross there; all of it is that stretch, and that buckling.
const LEAST_KEPT: f32 = 0.1;

/// How much both sides of a pair belong to a tangle (0 to 1, dimensionless) from which on it is left to untangling. Where they
/// do less, around it, a pair is kept about as far apart as it is. Sheets that cross at a small angle, pushed to their
/// thickness, would buckle and cross more.
const WITHIN_TANGLE: f32 = 0.9;

/// Distances are not known better than to this share of the coordinates (dimensionless).
const ROUNDING: f32 = 4.0 * f32::EPSILON;

impl<T: Fn(u32) -> f32> Asked<'_, T> {
    /// Lists a `pair` if it may touch; its first primitive has so many particles as `first`, and it is of `faces` whose boxes met.
    #[inline]
    pub(super) fn list(&mut self, pair: Proximity, first: usize, faces: [u32; 2]) {
        self.meter.spend(PRIMITIVES);
        if self.contacts.len() >= self.most {
            return;
        }
        let (ids, touch) = (pair.particles, self.touch);
        let (p, q) = (self.surface.part(ids[0]), self.surface.part(ids[3]));
        if !(self.takes_part[usize::from(p)] && self.takes_part[usize::from(q)]) {
            return;
        }
        let (mine, other) = (&touch[usize::from(p)], &touch[usize::from(q)]);
        let whole = 0.5 * (mine.thickness + other.thickness);
        let (mut thickness, margin) = (whole, MARGIN * whole);
        let normal = self.normal(&pair, p == q);
        let tangled = self.tangled(&ids[..first]).min(self.tangled(&ids[first..]));
        if !normal.is_finite() || tangled > WITHIN_TANGLE {
            self.contacts.coincide |= !normal.is_finite();
            return;
        }
        let far = |thickness: f32| self.is_far(&pair, first, normal, thickness + margin);
        if far(thickness) {
            return;
        }
        if p == q
            && let Some(most) = self.most_at_rest(&pair, p, thickness)
        {
            thickness = thickness.min(most);
            if thickness <= 0.0 || far(thickness) {
                return;
            }
        }
        if self.contacts.is_behind(pair.kind, ids) {
            return;
        }
        // Looked for as far as any other, so that nothing meets unseen.
        if self.is_pinned(&ids[..first]) && self.is_pinned(&ids[first..]) {
            thickness = thickness.min(LEAST_KEPT * whole);
        } else if tangled > 0.0 {
            thickness = thickness.min(pair.distance.max(LEAST_KEPT * whole));
        }
        let contacts = &mut *self.contacts;
        let rub = |touch: &Touch| (touch.static_friction, touch.dynamic_friction);
        let friction = Friction::between(rub(mine), rub(other));
        let (slots, [load, drive]) = (ids.map(|v| contacts.slot(v)), contacts.load(pair.kind, ids));
        contacts.pairs.push(Contact {
            kind: pair.kind,
            faces,
            slots,
            weights: pair.weights,
            normal,
            thickness,
            friction,
            restitution: mine.restitution.max(other.restitution),
            across: p != q,
            load,
            drive,
            sticks: false,
            behind: false,
            was_behind: false,
        });
    }

    /// Unit vector of a pair towards its first primitive; not a number where nobody can tell.
    #[inline]
    fn normal(&self, pair: &Proximity, of_one_cloth: bool) -> Vec3 {
        let ids = pair.particles;
        let at = |v: u32| self.positions[v as usize].truncate();
        let delta: Vec3 = (0..4).map(|i| at(ids[i]) * pair.weights[i]).sum();
        // Closer than coordinates can tell, two cloths have no side to be on. What a cloth does to itself is taken back if it
        // was wrong.
        let size = ids.map(|v| at(v).abs()).into_iter().fold(Vec3::ZERO, Vec3::max).max_element();
        let known = pair.distance > ROUNDING * size || of_one_cloth;
        delta.try_normalize().filter(|_| known).unwrap_or(Vec3::NAN)
    }

    /// How much the particles of a primitive belong to a tangle, at most (0 to 1, dimensionless).
    #[inline]
    fn tangled(&self, ids: &[u32]) -> f32 {
        ids.iter().map(|&v| (self.tangled)(v)).fold(0.0, f32::max)
    }

    /// Whether a pair is, and stays, farther apart along its normal than `reach` `[m]`.
    #[inline]
    fn is_far(&self, pair: &Proximity, first: usize, normal: Vec3, reach: f32) -> bool {
        let ids = &pair.particles;
        let axis = Vec3A::from(normal);
        let along = |v: u32| axis.dot(self.ahead[v as usize]);
        let low = ids[..first].iter().map(|&v| along(v)).fold(f32::INFINITY, f32::min);
        let high = ids[first..].iter().map(|&v| along(v)).fold(f32::NEG_INFINITY, f32::max);
        pair.distance >= reach && low - high >= reach
    }

    /// How far apart a pair of cloth `part` is kept, at most, for how far it is at rest `[m]`. Nothing where it is so far there
    /// that its `thickness` `[m]` does not matter.
    #[inline]
    fn most_at_rest(&self, pair: &Proximity, part: u16, thickness: f32) -> Option<f32> {
        let (surface, ids) = (self.surface, pair.particles);
        let near = thickness / REST_SHARE + 2.0 * self.longest[usize::from(part)];
        let is_near = surface.rest[ids[0] as usize].distance_squared(surface.rest[ids[3] as usize]) < near * near;
        is_near.then(|| REST_SHARE * distance_at_rest(surface, pair))
    }

    /// Whether pins hold a particle of a primitive.
    #[inline]
    fn is_pinned(&self, ids: &[u32]) -> bool {
        ids.iter().any(|&v| self.pinned[v as usize])
    }
}
