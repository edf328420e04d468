//! Signed distance to each primitive, with the outward normal.
//!
//! `d(q) < 0` inside, `|∇d| = 1`, `n = ∇d`. Distances are exact, so `d` is a safe step along any path (Hart 1996, sphere
//! tracing). Formulas as in Quilez, "distance functions"; axes as in parry: capsules by their segment, cylinders and cones
//! along Y around their middle.

use glam::{Vec2, Vec3A};

/// Signed distance `[m]` and unit normal at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Sample {
    /// Signed distance to the surface `[m]`; a lower bound when `normal` is zero.
    pub(super) distance: f32,
    /// Direction in which the distance grows fastest; zero when nothing is within reach of the query.
    pub(super) normal: Vec3A,
}

impl Sample {
    /// As of a shape that lies deeper by `inset` `[m]`.
    #[inline]
    pub(super) fn deeper(self, inset: f32) -> Self {
        Self { distance: self.distance + inset, ..self }
    }

    /// Nothing within `reach`.
    pub(super) const fn beyond(reach: f32) -> Self {
        Self { distance: reach, normal: Vec3A::ZERO }
    }
}

/// `v / |v|` and `|v|`; `fallback` where `v` has no direction.
#[inline]
fn direction(v: Vec3A, fallback: impl FnOnce() -> Vec3A) -> (Vec3A, f32) {
    let length = v.length();
    if length > 1.0e-12 { (v / length, length) } else { (fallback(), 0.0) }
}

/// `d = |q| - R`.
#[inline]
pub(super) fn ball(q: Vec3A, radius: f32) -> Sample {
    let (normal, length) = direction(q, || Vec3A::Y);
    Sample { distance: length - radius, normal }
}

/// `d = |q - c(q)| - R`, `c` the closest point of the segment `a..b`.
#[inline]
pub(super) fn capsule(q: Vec3A, a: Vec3A, ab: Vec3A, inverse_length2: f32, radius: f32) -> Sample {
    let t = ((q - a).dot(ab) * inverse_length2).clamp(0.0, 1.0);
    let (normal, length) = direction(q - a - ab * t, || ab.any_orthogonal_vector().normalize_or(Vec3A::Y));
    Sample { distance: length - radius, normal }
}

/// `e = |q| - h`; outside `d = |max(e, 0)|`, inside `d = max(e.x, e.y, e.z)`.
#[inline]
pub(super) fn cuboid(q: Vec3A, half: Vec3A) -> Sample {
    let e = q.abs() - half;
    let outside = e.max(Vec3A::ZERO);
    let length2 = outside.length_squared();
    let sign = Vec3A::ONE.copysign(q);
    if length2 > 1.0e-24 {
        let length = length2.sqrt();
        return Sample { distance: length, normal: outside * sign / length };
    }
    let deepest = e.max_element();
    let axis = if e.x >= deepest {
        Vec3A::X
    } else if e.y >= deepest {
        Vec3A::Y
    } else {
        Vec3A::Z
    };
    Sample { distance: deepest, normal: axis * sign }
}

/// `d = n · q`.
#[inline]
pub(super) fn half_space(q: Vec3A, normal: Vec3A) -> Sample {
    Sample { distance: q.dot(normal), normal }
}

/// Turns a distance in the half-plane `(ρ, y)`, `ρ = √(x² + z²)`, around the Y axis.
#[inline]
fn revolve(q: Vec3A, rho: f32, distance: f32, normal: Vec2) -> Sample {
    let inverse = if rho > 1.0e-12 { 1.0 / rho } else { 0.0 };
    let radial = if inverse > 0.0 { Vec3A::new(q.x * inverse, 0.0, q.z * inverse) } else { Vec3A::X };
    Sample { distance, normal: radial * normal.x + Vec3A::Y * normal.y }
}

/// A box of half extents `(R, H)` in `(ρ, y)`, revolved.
#[inline]
pub(super) fn cylinder(q: Vec3A, half_height: f32, radius: f32) -> Sample {
    let rho = (q.x * q.x + q.z * q.z).sqrt();
    let e = Vec2::new(rho - radius, q.y.abs() - half_height);
    let up = 1.0_f32.copysign(q.y);
    let outside = e.max(Vec2::ZERO);
    let length2 = outside.length_squared();
    if length2 > 1.0e-24 {
        let length = length2.sqrt();
        let n = outside / length;
        return revolve(q, rho, length, Vec2::new(n.x, n.y * up));
    }
    if e.x > e.y { revolve(q, rho, e.x, Vec2::X) } else { revolve(q, rho, e.y, Vec2::new(0.0, up)) }
}

/// Normal of a cone's side in `(ρ, y)`.
pub(super) fn cone_side(half_height: f32, radius: f32) -> Vec2 {
    Vec2::new(2.0 * half_height, radius).normalize_or(Vec2::X)
}

/// The triangle `(0, -H), (R, -H), (0, H)` in `(ρ, y)`, revolved: apex at `+H`, base disc at `-H`.
///
/// ```text
///   H  *            side: s = normal of the slope, pointing out and up
///      |\
///      | \
///  -H  *--*  R      base
/// ```
#[inline]
pub(super) fn cone(q: Vec3A, half_height: f32, radius: f32, side_normal: Vec2) -> Sample {
    let rho = (q.x * q.x + q.z * q.z).sqrt();
    let p = Vec2::new(rho, q.y);
    let rim = Vec2::new(radius, -half_height);
    let slope = Vec2::new(-radius, 2.0 * half_height);
    let along = ((p - rim).dot(slope) / slope.length_squared()).clamp(0.0, 1.0);
    let to_side = p - rim - slope * along;
    let to_base = p - Vec2::new(rho.min(radius), -half_height);
    let height_over_side = (p - rim).dot(side_normal);
    let depth_under_base = -half_height - q.y;
    if height_over_side < 0.0 && depth_under_base < 0.0 {
        return if height_over_side > depth_under_base {
            revolve(q, rho, height_over_side, side_normal)
        } else {
            revolve(q, rho, depth_under_base, Vec2::NEG_Y)
        };
    }
    let nearest = if to_base.length_squared() < to_side.length_squared() { to_base } else { to_side };
    let length = nearest.length();
    if length > 1.0e-12 {
        revolve(q, rho, length, nearest / length)
    } else if height_over_side >= depth_under_base {
        revolve(q, rho, 0.0, side_normal)
    } else {
        revolve(q, rho, 0.0, Vec2::NEG_Y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Central differences of a distance agree with its normal, and its slope is one.
    fn assert_is_distance(name: &str, f: impl Fn(Vec3A) -> Sample) {
        let mut random = fastrand::Rng::with_seed(1);
        let h = 1.0e-3;
        let (mut worst, mut bad) = (0.0_f32, 0);
        for _ in 0..4000 {
            let mut axis = || random.f32() * 3.0 - 1.5;
            let q = Vec3A::new(axis(), axis(), axis());
            let s = f(q);
            assert!((s.normal.length() - 1.0).abs() < 1.0e-4, "{name}: |n| = {} at {q}", s.normal.length());
            let slope = |e: Vec3A| (f(q + e * h).distance - f(q - e * h).distance) / (2.0 * h);
            let gradient = Vec3A::new(slope(Vec3A::X), slope(Vec3A::Y), slope(Vec3A::Z));
            let error = (gradient - s.normal).length();
            // Near the medial axis the gradient jumps: few points, and bounded.
            if error > 0.02 { bad += 1 } else { worst = worst.max(error) }
        }
        assert!(bad < 80, "{name}: {bad} of 4000 gradients differ from the normal, the others by at most {worst}");
    }

    #[test]
    fn every_primitive_distance_has_its_normal_as_gradient() {
        assert_is_distance("ball", |q| ball(q, 0.7));
        let (a, b) = (Vec3A::new(-0.4, -0.3, 0.1), Vec3A::new(0.5, 0.4, 0.0));
        assert_is_distance("capsule", |q| capsule(q, a, b - a, 1.0 / (b - a).length_squared(), 0.3));
        assert_is_distance("cuboid", |q| cuboid(q, Vec3A::new(0.5, 0.2, 0.8)));
        assert_is_distance("half-space", |q| half_space(q, Vec3A::new(0.6, 0.8, 0.0)));
        assert_is_distance("cylinder", |q| cylinder(q, 0.5, 0.6));
        assert_is_distance("cone", |q| cone(q, 0.6, 0.5, cone_side(0.6, 0.5)));
    }
}
