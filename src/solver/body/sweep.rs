//! First touch along a path, by conservative advancement.
//!
//! `d` is 1-Lipschitz. From a point at the distance `d`, a step of `d` cannot cross the surface. A step of `d - r` cannot come
//! nearer than `r` (Hart 1996; Mirtich 1996). The trace works on solids and on two-sided surfaces alike, and has no cracks
//! between triangles. It needs no memory of the side: the path starts on the right one.

use glam::Vec3A;

use super::distance::Sample;
use super::respond::Plane;
use crate::solver::scales::TOUCHING;

/// Steps of one trace; a path that takes more ends where it is.
pub(super) const STEPS: u32 = 24;
/// How far under the plane a path must lead to count as touching, in units of the distance kept (dimensionless).
pub(super) const GRAZE: f32 = 1.0e-3;
/// Planes that one path may slide along in a substep: a corner has three.
pub(super) const SLIDES: u32 = 3;

/// Where a path ends after sliding along what it met, and the last plane it met.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Swept {
    pub(super) end: Vec3A,
    pub(super) plane: Plane,
}

/// The plane at the distance `keep` from the surface under `q`.
#[inline]
pub(super) fn plane_at(q: Vec3A, sample: Sample, keep: f32) -> Plane {
    Plane::new(sample.normal, sample.normal.dot(q) - (sample.distance - keep))
}

/// Way that is none `[m]`, and the least step on one `[m]`: a hundredth of the thinnest cloth.
pub(super) const SHORTEST_WAY: f32 = 1.0e-9;
pub(super) const LEAST_STEP: f32 = 1.0e-6;

/// Walks `from -> to` and returns the first point nearer than `keep` from which the path leads deeper.
fn first_touch(sample: &impl Fn(Vec3A, f32) -> Sample, from: (Vec3A, Sample), to: Vec3A, keep: f32) -> Option<(Vec3A, Sample)> {
    let path = to - from.0;
    let length = path.length();
    let moves = length > SHORTEST_WAY;
    if !moves {
        return None;
    }
    let along = path / length;
    let (mut q, mut s) = from;
    let mut travelled = 0.0;
    for _ in 0..STEPS {
        let gap = s.distance - keep;
        // Near, and the rest of the path goes deeper: grazing along the surface is not a touch.
        if gap <= TOUCHING * keep && gap + s.normal.dot(to - q) < -GRAZE * keep {
            return Some((q, s));
        }
        travelled += gap.max(0.5 * s.distance).max(LEAST_STEP);
        if travelled >= length {
            return None;
        }
        q = from.0 + along * travelled;
        s = sample(q, keep + (length - travelled));
    }
    Some((q, s))
}

/// Moves a particle that starts outside (`from.1.distance > 0`) towards `to`, sliding along what it meets.
/// `None`: nothing is in the way.
pub(super) fn sweep(sample: &impl Fn(Vec3A, f32) -> Sample, from: (Vec3A, Sample), to: Vec3A, keep: f32) -> Option<Swept> {
    let (mut start, mut end) = (from, to);
    let mut plane = None;
    for _ in 0..SLIDES {
        let Some((q, s)) = first_touch(sample, start, end, keep) else {
            return plane.map(|plane| Swept { end, plane });
        };
        let touched = plane_at(q, s, keep);
        end += touched.normal() * (-touched.gap(end)).max(0.0);
        plane = Some(touched);
        start = (q, s);
    }
    // Wedged: stay at the last point known to be outside.
    plane.map(|plane| Swept { end: if first_touch(sample, start, end, keep).is_some() { start.0 } else { end }, plane })
}
