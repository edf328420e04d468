//! One pair of primitives that may touch: a particle and a face, or two edges. What keeps it apart in a substep is a
//! [`Constraint`].
//!
//! ```text
//!   x_v            δ = Σ wᵢ xᵢ      from the closest point of the second to that of the first
//!    \             n = ±δ/|δ|       on the side where the pair belongs
//!     |  δ
//!  ---o-------
//! ```
//!
//! `Σ wᵢ = 0`, hence two free cloths exchange momentum and make none. Cloth that lies on a body is made heavier for other
//! cloth, and the body takes the difference.

use core::cmp::Ordering;

use glam::{Mat4, Vec3, Vec4};

use super::cloths::{Cloths, offset_between};
use super::constraint::{Constraint, sum};
use super::depth::Depths;
use super::loads::Load;
use crate::solver::body::Plane;
use crate::solver::detect::ProximityKind;
use crate::solver::detect::proximity::{edge_edge, vertex_face};
use crate::solver::scales::{LEAST_MOBILITY, TOUCHING};

/// Mobility of cloth that lies on a body, or on cloth that does, as a share of that of the cloth it carries (dimensionless). At
/// 1 a pile of three on a ball creeps for 10 to 20 s, while two over the edges of a box rest sooner.
const SUPPORT: f32 = 0.02;
/// Beyond this many thicknesses along the last normal, closest points are not asked for.
const FAR: f32 = 1.2;
/// Distance in thicknesses below which two lie in one place, and the normal is the last one (dimensionless).
const COINCIDE: f32 = 1.0e-3;
/// Share of the thickness or depth: a pair that was closer than this halfway went through, not around (dimensionless). For a
/// pair already through, the share is 1.
const THROUGH: f32 = 0.25;
/// Largest depth that counts for this, in thicknesses (dimensionless): a particle that was flung away passed nothing.
const FLUNG: f32 = 4.0;

/// A pair. See the module. Most never touch, so what they bear is kept [elsewhere](super::loads::Borne).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Contact {
    pub kind: ProximityKind,
    /// The faces whose boxes met.
    pub faces: [u32; 2],
    /// Its particles, as [`Proximity::particles`](crate::solver::detect::Proximity::particles).
    pub particles: [u32; 4],
    /// Weights of the closest points when last asked.
    pub weights: [f32; 4],
    /// Unit vector towards the first primitive, on whichever side it is.
    pub normal: Vec3,
    /// Distance kept `[m]`.
    pub thickness: f32,
    /// The cloths of both primitives.
    pub parts: [u16; 2],
    /// Whether it is on the other side than it belongs, and whether it was at the start of the substep.
    pub inverted: bool,
    pub was_inverted: bool,
}

// There are ten times as many as particles, and each is looked at in every substep: one line of a cache.
const _: () = assert!(size_of::<Contact>() == 64);

/// All particles, as pairs see them.
pub(super) struct Particles<'a> {
    pub now: &'a [Vec4],
    pub old: &'a [Vec4],
    pub depths: &'a mut Depths,
    pub cloths: Cloths<'a>,
    /// Against gravity; zero without.
    pub up: Vec3,
}

impl Contact {
    /// Where its particles are of all `positions` `[m]`, in the frame of the second primitive. `offset` is from the frame of
    /// the first to it `[m]`.
    #[inline]
    pub(super) fn points(&self, positions: &[Vec4], offset: Vec3) -> [Vec4; 4] {
        let mut points = self.particles.map(|p| positions[p as usize]);
        let offset = offset.extend(0.0);
        points[0] += offset;
        if self.kind == ProximityKind::EdgeEdge {
            points[1] += offset;
        }
        points
    }

    /// How many of the particles make up the first primitive.
    #[inline]
    pub(super) fn first(&self) -> usize {
        if self.kind == ProximityKind::VertexFace { 1 } else { 2 }
    }

    /// What keeps pair number `pair` apart in the substep, if it touches; `load`: what it bore before.
    #[inline]
    pub(super) fn touch(&mut self, pair: u32, load: Load, particles: &mut Particles<'_>) -> Option<Constraint> {
        if self.was_inverted != self.inverted {
            self.was_inverted = self.inverted;
        }
        let offset = offset_between(self.parts, particles.cloths.offsets);
        let mut x = self.points(particles.now, offset);
        if self.is_apart(&x) {
            if self.inverted {
                self.inverted = false;
            }
            return None;
        }
        let was = self.points(particles.old, offset);
        let at = |points: &[Vec4; 4]| match self.kind {
            ProximityKind::VertexFace => vertex_face([0, 1, 2, 3], |i| points[i as usize].truncate()),
            ProximityKind::EdgeEdge => edge_edge([0, 1, 2, 3], |i| points[i as usize].truncate()),
        };
        let near = at(&x);
        if !(near.distance < f32::INFINITY) {
            return None;
        }
        let delta = sum(&near.weights, &x);
        let mut distance = near.distance;
        if delta.dot(self.normal) < 0.0 && {
            // Through, or around? Where it was as far from one side as it is now from the other, it must have been in the
            // other.
            let before = self.normal.dot(sum(&near.weights, &was)).max(0.0);
            let t = before / (before + distance);
            let midway = at(&std::array::from_fn(|i| was[i].lerp(x[i], t)));
            // Who was through at the end of the last substep still is, unless clearly not.
            let share = if self.inverted { 1.0 } else { THROUGH };
            midway.distance < share * self.thickness.max(distance.min(FLUNG * self.thickness))
        } {
            distance = -distance;
        }
        // In touch to the last digit the direction is the last one.
        if distance.abs() > COINCIDE * self.thickness
            && let Some(towards_first) = delta.try_normalize()
        {
            self.normal = towards_first * distance.signum();
        }
        self.weights = near.weights;
        self.inverted = distance < 0.0;
        let gap = distance - self.thickness;
        // NaN passes no comparison.
        if !(gap < 0.0 || (load.push > 0.0 && gap < TOUCHING * self.thickness)) {
            return None;
        }
        self.support(particles, &mut x);
        let mobility = self.mobility(&x);
        // The vector between the closest points is pushed out as a particle is out of a body, and shared out by mass.
        (mobility > 0.0).then(|| Constraint {
            pair,
            particles: self.particles,
            weights: self.weights,
            shares: core::array::from_fn(|i| self.weights[i] * x[i].w / mobility),
            mobility,
            offset,
            plane: Plane::new(self.normal.into(), self.thickness),
            friction: particles.cloths.friction(self.parts),
            restitution: (!(self.inverted || self.was_inverted)).then(|| particles.cloths.restitution(self.parts)),
            floor: 0.0,
            load: load.push,
            drive: load.drive,
            push: 0.0,
            tangent_push: load.tangent_push,
        })
    }

    /// Whether no closest points are needed. A plane across the last normal keeps the pair too far apart to touch, or the last
    /// closest points are [far](FAR) apart along it.
    #[inline]
    fn is_apart(&self, x: &[Vec4; 4]) -> bool {
        let [x, y, z, w] = *x;
        let along = Mat4::from_cols(x, y, z, w).transpose() * self.normal.extend(0.0);
        let gap = match self.kind {
            ProximityKind::VertexFace => along.x - along.y.max(along.z).max(along.w),
            ProximityKind::EdgeEdge => along.x.min(along.y) - along.z.max(along.w),
        };
        gap > (1.0 + TOUCHING) * self.thickness || along.dot(self.weights.into()) > FAR * self.thickness
    }

    /// How far a unit push moves the closest points apart `[1/kg]`, or a share of that of the lightest particle; 0 where
    /// nothing moves.
    #[inline]
    fn mobility(&self, x: &[Vec4; 4]) -> f32 {
        let own: f32 = (0..4).map(|i| self.weights[i] * self.weights[i] * x[i].w).sum();
        let lightest = x.iter().map(|x| x.w).fold(0.0, f32::max);
        // Momentum is kept whatever they are divided by; a push that is cut short goes on in the next substeps.
        if own > 0.0 { own.max(lightest * LEAST_MOBILITY) } else { 0.0 }
    }

    /// Passes on to the side above how close to a body it lies. The side that carries it would only push it back, and is made
    /// heavier (mass scaling as in Macklin et al. 2014, section 5.2). Not within a cloth, which presses its folds together
    /// itself, much more than gravity does. Where nothing takes the reaction, the folds would lift themselves off a floor, and
    /// fall back, for ever.
    #[inline]
    fn support(&self, particles: &mut Particles<'_>, x: &mut [Vec4; 4]) {
        let ids = self.particles;
        let split = self.first();
        let (first, second) = (particles.depths.least(&ids[..split]), particles.depths.least(&ids[split..]));
        // Upwards along the normal, from the heavy side to the one it carries.
        let (heavy, above, depth, up) = match first.layers().cmp(&second.layers()) {
            Ordering::Less => (0..split, split..4, first, -self.normal.dot(particles.up)),
            Ordering::Equal => return,
            Ordering::Greater => (split..4, 0..split, second, self.normal.dot(particles.up)),
        };
        if !(up > 0.0) {
            return;
        }
        // It has fewer layers than another, so it is not free.
        particles.depths.lay(&ids[above], depth);
        if self.parts[0] != self.parts[1] {
            let share = 1.0 + (SUPPORT - 1.0) * up;
            heavy.for_each(|i| x[i].w *= share);
        }
    }
}

#[cfg(test)]
impl Contact {
    /// A pair of the first four particles that has not touched yet, without friction, `thickness` `[m]` apart.
    pub(crate) fn bare(kind: ProximityKind, thickness: f32) -> Self {
        Self {
            kind,
            faces: [0; 2],
            particles: [0, 1, 2, 3],
            weights: [0.0; 4],
            normal: Vec3::X,
            thickness,
            parts: [0, 1],
            inverted: false,
            was_inverted: false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::detect::proximity::closest_edges;

    #[test]
    fn thin_edges_that_meet_to_the_last_digit_keep_the_direction_that_they_had() {
        let mut rng = fastrand::Rng::with_seed(5);
        let mut without_direction = 0;
        for _ in 0..20_000 {
            let mut point = || Vec3::new(rng.f32(), rng.f32(), rng.f32()) - 0.5;
            let (center, u, v) = (point(), point(), point());
            let x = [center + u, center - u, center + v, center - v].map(|x| x.extend(1.0));
            // Thinner than the numbers around it can tell.
            let mut pair = Contact::bare(ProximityKind::EdgeEdge, 1.0e-8);
            let mut depths = Depths::default();
            depths.fit(x.len());
            let cloths = Cloths { offsets: &[], touch: &[] };
            pair.touch(0, Load::default(), &mut Particles { now: &x, old: &x, depths: &mut depths, cloths, up: Vec3::Y });
            assert!((pair.normal.length() - 1.0).abs() < 1.0e-3, "{x:?}: {}", pair.normal);
            let near = edge_edge([0, 1, 2, 3], |i| x[i as usize].truncate());
            without_direction += u32::from(near.distance > 0.0 && sum(&near.weights, &x) == Vec3::ZERO);
        }
        assert!(without_direction > 0, "no pair has a distance and no direction");
    }

    #[test]
    fn what_a_plane_keeps_apart_does_not_touch_and_most_that_does_not_is_seen_to_be_apart() {
        let mut rng = fastrand::Rng::with_seed(3);
        let (mut apart, mut missed) = (0, 0);
        for n in 0..20_000 {
            let kind = if n % 2 == 0 { ProximityKind::VertexFace } else { ProximityKind::EdgeEdge };
            let mut point = |size: f32| ((Vec3::new(rng.f32(), rng.f32(), rng.f32()) - 0.5) * size).extend(1.0);
            let x: [Vec4; 4] = std::array::from_fn(|_| point(1.0));
            let moved = x.map(|x| x + point(0.05));
            let closest = |x: &[Vec4; 4]| match kind {
                ProximityKind::VertexFace => vertex_face([0, 1, 2, 3], |i| x[i as usize].truncate()),
                ProximityKind::EdgeEdge => closest_edges([0, 1, 2, 3], |i| x[i as usize].truncate()),
            };
            let near = closest(&x);
            let normal = sum(&near.weights, &x).normalize_or_zero();
            let pair = Contact { normal, ..Contact::bare(kind, 0.1) };
            let distance = closest(&moved).distance;
            if pair.is_apart(&moved) {
                assert!(distance > pair.thickness, "{n} {kind:?}: {distance}");
                apart += 1;
            } else {
                missed += u32::from(distance > 2.0 * pair.thickness);
            }
        }
        assert!(apart > 10_000 && missed < apart / 100, "{apart} apart, {missed} far apart and not seen to be");
    }
}
