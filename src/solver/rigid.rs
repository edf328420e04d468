//! The rigid motion that takes points from where they were to where they are.
//!
//! ```text
//!   x0 ─► c + q (x0 - c0)                 c0, c: centre of the points, then and now
//!
//!   Σ (|r|² 1 - r rᵀ) s = Σ r × (p - c)   r = q (p0 - c0);  s: axis times sine of the turn that is left, to first order
//!   q ◄ t q,  t ~ (s, 1 + √(1 - s²))      until nothing is left; turns of less than 150°
//! ```
//!
//! Of the turn around a straight row of points nothing is known; it is the least.

use glam::{Mat3, Quat, Vec3};

/// Rounds for the turn: after three what is left of 30° about any axis is within rounding, after ten of 150°.
const MOST_ROUNDS: u32 = 16;

/// Square of the sine of what is left of the turn when it is found (dimensionless): rounding.
const FOUND: f32 = 1.0e-12;

/// Share of its trace that is added to the diagonal of the matrix above (dimensionless): a row of points leaves it singular.
const LEAST_TURN: f32 = 1.0e-4;

/// A rigid motion. See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Rigid {
    /// Centre of the points, then and now `[m]`.
    from: Vec3,
    to: Vec3,
    /// How they turn about it.
    pub turn: Quat,
}

impl Rigid {
    /// The one that moves everything `by` `[m]`.
    pub(crate) fn shift(by: Vec3) -> Self {
        Self { from: Vec3::ZERO, to: by, turn: Quat::IDENTITY }
    }

    /// The one that fits points best, given where each was and is `[m]`. Not finite without points.
    pub(crate) fn fit<I: Iterator<Item = (Vec3, Vec3)>>(all: impl Fn() -> I) -> Self {
        let sum = |(n, a, b): (f32, Vec3, Vec3), (from, to)| (n + 1.0, a + from, b + to);
        let (count, from, to) = all().fold((0.0, Vec3::ZERO, Vec3::ZERO), sum);
        let (from, to) = (from / count, to / count);
        let mut turn = Quat::IDENTITY;
        for _ in 0..MOST_ROUNDS {
            let (mut matrix, mut moment, mut trace) = (Mat3::ZERO, Vec3::ZERO, 0.0);
            for (then, now) in all() {
                let r = turn * (then - from);
                let square = r.length_squared();
                matrix += Mat3::from_diagonal(Vec3::splat(square)) - Mat3::from_cols(r * r.x, r * r.y, r * r.z);
                moment += r.cross(now - to);
                trace += 2.0 * square;
            }
            if !(trace > 0.0) {
                break;
            }
            let sine = (matrix + Mat3::from_diagonal(Vec3::splat(LEAST_TURN * trace))).inverse() * moment;
            let cosine = (1.0 - sine.length_squared()).max(0.0).sqrt();
            turn = (Quat::from_vec4(sine.extend(1.0 + cosine)).normalize() * turn).normalize();
            if !(sine.length_squared() > FOUND) {
                break;
            }
        }
        Self { from, to, turn }
    }

    /// Where it takes a point `[m]`.
    pub(crate) fn point(&self, x: Vec3) -> Vec3 {
        self.to + self.turn * (x - self.from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_that_moved_as_one_go_where_they_are() {
        let mut rng = fastrand::Rng::with_seed(3);
        let mut point = || Vec3::new(rng.f32(), rng.f32(), rng.f32()) - 0.5;
        // A ribbon, too.
        for (turn, size) in [0.0_f32, 0.01, 0.3, 1.0, 2.0, 2.6].into_iter().flat_map(|turn| [(turn, 1.0), (turn, 0.03)]) {
            let (axis, by) = (point().normalize(), 30.0 * point());
            let turn = Quat::from_axis_angle(axis, turn);
            let size = Vec3::new(1.0, size, 0.0);
            let points: Vec<(Vec3, Vec3)> = (0..20).map(|_| size * point()).map(|x| (x, turn * x + by)).collect();
            let rigid = Rigid::fit(|| points.iter().copied());
            let farthest = points.iter().map(|(from, to)| rigid.point(*from).distance(*to)).fold(0.0, f32::max);
            assert!(farthest < 3.0e-5, "{turn}: {farthest} m");
        }
    }
}
