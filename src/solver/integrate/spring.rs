//! Springs along edges, with Provot's strain limit in the same pass.
//!
//! A spring of stiffness `k` is the constraint `C = |d| - L` of compliance `1/k` (XPBD, Macklin et al. 2016, eq. 18, one
//! iteration):
//!
//! ```text
//! Δx_a = +w_a s d      s = (1 - L/|d|) / (w_a + w_b + 1 / (k h²))        d = x_b - x_a
//! Δx_b = -w_b s d
//! ```
//!
//! `L/|d|` is taken as `(q + 3) / (3 q + 1)` with `q = |d|²/L²`: equal to second order at `|d| = L`, monotone, never below 1/3.
//! So it has the same fixed point, needs no square root, and cannot fling apart two particles at one place.
//!
//! Beyond `(1 + limit) L` the spring does not yield (Provot 1995): `s` is at least `(1 - (1 + limit) L/|d|) / (w_a + w_b)`.
//!
//! In the code `L/|d| = 1/3 + u`, `u = (8/9) / (q + 1/3)`, and `s` is taken times `w_a + w_b`, of which each end has its share.

use glam::{Mat4, Vec2, Vec4};

use super::XYZ;
use crate::solver::rest::{LANES, Springs};
use crate::solver::settings::Fabric;

/// Stiffness of a diagonal over the `k = K · ΣA / L²` of the shear stiffness `G` (dimensionless). Sheared by `γ`, the diagonal
/// of a square of side `a` lengthens by `γ a / √2`. It stores the `½ G γ² a²` of the square with `k = 2 G`, where `ΣA / L²` is
/// ½.
const DIAGONAL: f32 = 4.0;

/// What a spring yields and how its ends share that; depends on masses, stiffness and substep.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct SpringFactors {
    /// `σ = (w_a + w_b) / (w_a + w_b + 1 / (k h²))` (dimensionless), by batch and lane.
    give: Vec<Vec4>,
    /// `w_a / (w_a + w_b)` (dimensionless); 0 where nothing can move.
    share_a: Vec<Vec4>,
    /// `w_b / (w_a + w_b)` (dimensionless); 0 where nothing can move.
    share_b: Vec<Vec4>,
}

impl SpringFactors {
    /// Memory held `[B]`.
    #[must_use]
    pub(crate) fn bytes(&self) -> usize {
        3 * size_of_val(&self.give[..])
    }

    /// Recomputes all factors for a substep of `h` `[s]`.
    pub(crate) fn update(&mut self, springs: &Springs, fabric: &Fabric, positions: &[Vec4], h: f32) {
        // `K (1 + r cos 2(φ - φ₀))`: `2 ρ / (1 + ρ)` of `K` along the warp and `2 / (1 + ρ)` along the weft.
        let uneven = (fabric.stretch_ratio - 1.0) / (fabric.stretch_ratio + 1.0);
        let threads = Vec2::from_angle(2.0 * fabric.warp_angle);
        self.give.clear();
        self.share_a.clear();
        self.share_b.clear();
        for k in 0..springs.a.len() {
            let weights = |ends: [u32; LANES]| Vec4::from_array(ends.map(|i| positions[i as usize].w));
            let (wa, wb) = (weights(springs.a[k]), weights(springs.b[k]));
            let w = wa + wb;
            let shear = DIAGONAL * fabric.shear_stiffness;
            let along = springs.warp.get(k).map_or(Vec4::ZERO, |[cos, sin]| *cos * threads.x + *sin * threads.y);
            let stretch = fabric.stretch_stiffness * (Vec4::ONE + along * uneven);
            let membrane = stretch + springs.shear[k] * (Vec4::splat(shear) - stretch);
            let stiffness = (membrane * springs.width_ratio[k]).max(Vec4::splat(1.0e-12));
            let some = w.max(Vec4::splat(f32::MIN_POSITIVE));
            self.give.push(w / (w + (stiffness * h * h).recip()));
            self.share_a.push(wa / some);
            self.share_b.push(wb / some);
        }
    }
}

/// Four differences `b - a` with `w` cleared, and their lengths.
#[inline(always)]
fn gather(a: &[u32; LANES], b: &[u32; LANES], positions: &[Vec4]) -> ([Vec4; LANES], [Vec4; LANES], [Vec4; LANES]) {
    let pa = a.map(|i| positions[i as usize]);
    let pb = b.map(|i| positions[i as usize]);
    (pa, pb, std::array::from_fn(|l| pb[l] - pa[l]))
}

/// Lengths of four vectors, `w` ignored.
#[inline(always)]
fn lengths_squared(d: [Vec4; LANES]) -> Vec4 {
    let m = Mat4::from_cols(d[0], d[1], d[2], d[3]).transpose();
    m.x_axis * m.x_axis + m.y_axis * m.y_axis + m.z_axis * m.z_axis
}

/// Solves every spring once.
pub(crate) fn solve(springs: &Springs, factors: &SpringFactors, strain_limit: f32, positions: &mut [Vec4]) {
    let ends = springs.a.iter().zip(&springs.b).zip(&springs.inverse_square);
    let shares = factors.give.iter().zip(&factors.share_a).zip(&factors.share_b);
    let bound = Bound::new(strain_limit);
    for (((a, b), &inverse_square), ((&give, &share_a), &share_b)) in ends.zip(shares) {
        let (pa, pb, d) = gather(a, b, positions);
        let u = inverse_length(lengths_squared(d) * inverse_square);
        let s = ((Vec4::splat(2.0 / 3.0) - u) * give).max(bound.least(u));
        scatter([a, b], [pa, pb], d, [s * share_a, s * share_b], positions);
    }
}

/// `L/|d| - 1/3` as in the module, from `|d|²/L²`.
#[inline(always)]
pub(super) fn inverse_length(q: Vec4) -> Vec4 {
    Vec4::splat(8.0 / 9.0) / (q + Vec4::splat(1.0 / 3.0))
}

/// The strain limit.
#[derive(Clone, Copy, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Bound {
    hard: Vec4,
    slack: Vec4,
}

impl Bound {
    pub(super) fn new(strain_limit: f32) -> Self {
        // Without a limit the bound is far below zero.
        let slack = 1.0 + strain_limit.min(1.0e9);
        Self { hard: Vec4::splat(1.0 - slack / 3.0), slack: Vec4::splat(slack) }
    }

    /// How much a spring is shortened at least, `(1 - (1 + limit) L/|d|)`, from [`inverse_length`].
    #[inline(always)]
    pub(super) fn least(self, u: Vec4) -> Vec4 {
        self.hard - self.slack * u
    }
}

/// Puts the ends of four springs where they go: a share `by` of the difference `d` closer, each.
#[inline(always)]
fn scatter([a, b]: [&[u32; LANES]; 2], [pa, pb]: [[Vec4; LANES]; 2], d: [Vec4; LANES], by: [Vec4; 2], positions: &mut [Vec4]) {
    let [by_a, by_b] = by.map(|by| by.to_array());
    for lane in 0..LANES {
        let d = d[lane] * XYZ;
        positions[a[lane] as usize] = pa[lane] + d * by_a[lane];
        positions[b[lane] as usize] = pb[lane] - d * by_b[lane];
    }
}

/// Springs at, or close to, the strain limit: the only ones that sweeps for the limit alone can change.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Tight {
    batches: Vec<u32>,
    listed: Vec<bool>,
}

/// From this share of the strain limit on a spring is close to it: what is shortened next to it draws at it.
const TIGHT: f32 = 0.25;

impl Tight {
    /// Finds them, once a frame: a list that changed with every substep would never let cloth rest. With `all`, any may get
    /// there within the frame; with `keep`, those that were close stay listed.
    pub(crate) fn find(&mut self, springs: &Springs, strain_limit: f32, (all, keep): (bool, bool), positions: &[Vec4]) {
        self.batches.clear();
        self.batches.reserve(springs.a.len());
        if all {
            self.batches.extend(0..springs.a.len() as u32);
            self.listed.clear();
            return;
        }
        if !keep {
            self.listed.clear();
        }
        self.listed.resize(springs.a.len(), false);
        let near = Vec4::splat((1.0 + TIGHT * strain_limit).powi(2));
        let springs = springs.a.iter().zip(&springs.b).zip(&springs.inverse_square);
        for (k, (((a, b), &inverse_square), listed)) in (0..).zip(springs.zip(&mut self.listed)) {
            if !*listed {
                let (_, _, d) = gather(a, b, positions);
                *listed = (lengths_squared(d) * inverse_square).cmpgt(near).any();
            }
            if *listed {
                self.batches.push(k);
            }
        }
    }

    /// Sweeps once over those beyond the strain limit, and shortens them. Springs that are too short do not push back, so
    /// nothing keeps others from giving way.
    pub(crate) fn solve(&self, springs: &Springs, factors: &SpringFactors, strain_limit: f32, positions: &mut [Vec4]) {
        let bound = Bound::new(strain_limit);
        for k in self.batches.iter().map(|&k| k as usize) {
            let (a, b) = (&springs.a[k], &springs.b[k]);
            let (pa, pb, d) = gather(a, b, positions);
            let s = bound.least(inverse_length(lengths_squared(d) * springs.inverse_square[k])).max(Vec4::ZERO);
            scatter([a, b], [pa, pb], d, [s * factors.share_a[k], s * factors.share_b[k]], positions);
        }
    }
}

/// Longest and mean length over rest length of all springs (dimensionless), lanes that repeat counted again. Positions that are
/// not finite give infinity.
#[must_use]
pub(crate) fn strain(springs: &Springs, positions: &[Vec4]) -> (f32, f32) {
    let mut worst = Vec4::ZERO;
    let mut sum = Vec4::ZERO;
    for ((a, b), &inverse_square) in springs.a.iter().zip(&springs.b).zip(&springs.inverse_square) {
        let (_, _, d) = gather(a, b, positions);
        let ratio = (lengths_squared(d) * inverse_square).sqrt();
        worst = Vec4::select(ratio.cmple(worst), worst, ratio);
        sum += ratio;
    }
    let mean = (sum.x + sum.y + sum.z + sum.w) / (LANES * springs.a.len().max(1)) as f32;
    if mean.is_finite() { (worst.max_element(), mean) } else { strain_of_far(springs, positions) }
}

/// As [`strain`], where squares are too large for `f32`: a skin may begin anywhere.
#[cold]
fn strain_of_far(springs: &Springs, positions: &[Vec4]) -> (f32, f32) {
    let (mut worst, mut sum, mut count) = (0.0f64, 0.0, 0.0);
    for (a, b, inverse_square) in springs.each() {
        let length = positions[a].truncate().as_dvec3().distance(positions[b].truncate().as_dvec3());
        let ratio = length * f64::from(inverse_square).sqrt();
        (worst, sum, count) = (worst.max(ratio), sum + ratio, count + 1.0);
    }
    if !f64::is_finite(sum) {
        return (f32::INFINITY, f32::INFINITY);
    }
    let bounded = |x: f64| x.min(f64::from(f32::MAX)) as f32;
    (bounded(worst), bounded(sum / count))
}

/// Springs that are still too long at the end of a frame, and are shortened without letting time pass.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Overlong {
    batches: Vec<u32>,
}

impl Overlong {
    /// Lists what is longer than `bound` times its length at rest (dimensionless); whether any is longer than `far` times.
    pub(crate) fn find(&mut self, springs: &Springs, [bound, far]: [f32; 2], positions: &[Vec4]) -> bool {
        self.batches.clear();
        let mut worst = Vec4::ZERO;
        for (batch, ((a, b), &inverse_square)) in (0_u32..).zip(springs.a.iter().zip(&springs.b).zip(&springs.inverse_square)) {
            let (_, _, d) = gather(a, b, positions);
            let square = lengths_squared(d) * inverse_square;
            if square.cmpgt(Vec4::splat(bound * bound)).any() {
                worst = worst.max(square);
                self.batches.push(batch);
            }
        }
        worst.max_element() > far * far
    }

    /// Shortens what was [listed](Self::find) and is longer than `bound` times its length at rest (dimensionless), `passes`
    /// times over.
    pub(crate) fn shorten(&self, springs: &Springs, factors: &SpringFactors, bound: f32, passes: u32, positions: &mut [Vec4]) {
        for k in (0..passes).flat_map(|_| &self.batches).map(|&batch| batch as usize) {
            let (a, b) = (&springs.a[k], &springs.b[k]);
            let (pa, pb, d) = gather(a, b, positions);
            let ratio = (lengths_squared(d) * springs.inverse_square[k]).sqrt().max(Vec4::splat(bound));
            let s = Vec4::ONE - Vec4::splat(bound) / ratio;
            scatter([a, b], [pa, pb], d, [s * factors.share_a[k], s * factors.share_b[k]], positions);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::rest::RestShape;
    use crate::solver::scene::grid;

    #[test]
    fn the_strain_of_what_is_far_is_finite_and_that_of_nonsense_is_not() {
        let (rest, _) = RestShape::build(&grid(4, 4, |u, v| glam::vec3(u, 0.0, v))).expect("a sheet");
        let times = |factor: f32| rest.positions.iter().map(|x| (*x * factor).extend(1.0)).collect::<Vec<Vec4>>();
        let (worst, mean) = strain(&rest.springs, &times(2.0));
        assert!((worst - 2.0).abs() < 1.0e-5 && (mean - 2.0).abs() < 1.0e-5, "{worst} {mean}");
        let (worst, mean) = strain(&rest.springs, &times(1.0e25));
        assert!((worst / 1.0e25 - 1.0).abs() < 1.0e-5 && (mean / 1.0e25 - 1.0).abs() < 1.0e-5, "{worst} {mean}");
        let mut positions = times(1.0);
        positions[5].x = f32::NAN;
        assert_eq!(strain(&rest.springs, &positions), (f32::INFINITY, f32::INFINITY));
    }
}
