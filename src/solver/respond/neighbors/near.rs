//! Pairs of primitives that are near each other, and what each came to.

use glam::Vec3;

use crate::solver::body::Touch;
use crate::solver::detect::{Proximity, ProximityKind, Surface};

/// Pairs of one cloth are kept no farther apart than this share of their distance at rest (dimensionless). In folds of less
/// than 60°, which are taken for [flat](crate::solver::scales::ALIGNED), they may get to half of it. Yet 0.5 here took twice
/// as long to untangle a garment of many layers **`[measured]`**.
pub(super) const REST_SHARE: f32 = 0.7;

/// A particle and a face, or two edges, whose boxes meet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near {
    pub(super) kind: ProximityKind,
    /// As [`Proximity::particles`].
    pub(super) particles: [u32; 4],
    /// The faces whose boxes met.
    pub(super) faces: [u32; 2],
    /// What is, and stays, farther apart does not matter `[m]`.
    pub(super) reach: f32,
    /// Whether it is of two cloths.
    pub(super) across: bool,
}

/// What a pair came to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    pub(super) pair: Proximity,
    /// The faces whose boxes met.
    pub(super) faces: [u32; 2],
    /// Unit vector towards the first primitive; not a number where none is known.
    pub(super) normal: Vec3,
    /// How far apart it will be along it `[m]`.
    pub(super) apart: f32,
    /// How far apart it is at rest `[m]`, where that matters.
    pub(super) at_rest: f32,
    /// Whether it may touch; nothing else is known of one that does not.
    pub(super) may_touch: bool,
}

impl Found {
    pub(super) const NOTHING: Self = Self {
        pair: Proximity { kind: ProximityKind::VertexFace, particles: [0; 4], weights: [0.0; 4], distance: 0.0 },
        faces: [0; 2],
        normal: Vec3::NAN,
        apart: 0.0,
        at_rest: f32::INFINITY,
        may_touch: false,
    };

    /// Whether the pair is, and stays, farther apart along its normal than `reach` `[m]`.
    #[inline]
    pub(super) fn is_far(&self, reach: f32) -> bool {
        self.pair.distance >= reach && self.apart >= reach
    }
}

/// Whether it matters how far apart a pair is at rest. One cloth is kept no farther apart than there, except for pairs that are
/// far away in it.
#[inline]
pub(super) fn rest_matters(surface: &Surface, touch: &[Touch], longest: &[f32], found: &Found) -> bool {
    let [a, .., d] = found.pair.particles;
    let part = surface.part(a);
    let thickness = touch[usize::from(part)].thickness;
    let near = thickness / REST_SHARE + 2.0 * longest[usize::from(part)];
    let is_near = surface.rest[a as usize].distance_squared(surface.rest[d as usize]) < near * near;
    part == surface.part(d) && is_near
}
