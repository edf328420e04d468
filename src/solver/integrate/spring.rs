//! Springs along edges, with Provot's strain limit in the same pass.
//!
//! A spring of stiffness `k` is the constraint `C = |d| - L` of compliance `1/k` (XPBD, Macklin et al. 2016, eq. 18, one iteration):
//!
//! ```text
//! Δx_a = +w_a s d      s = (1 - L/|d|) / (w_a + w_b + 1 / (k h²))        d = x_b - x_a
//! Δx_b = -w_b s d
//! ```
//!
//! `L/|d|` is taken as `(q + 3) / (3 q + 1)` with `q = |d|²/L²`: equal to second order at `|d| = L`, monotone, never below 1/3, so it has the
//! same fixed point, needs no square root, and cannot fling apart two particles at one place.
//!
//! Beyond `(1 + limit) L` the spring does not yield (Provot 1995): `s` is at least `(1 - (1 + limit) L/|d|) / (w_a + w_b)`.

use glam::{Mat4, Vec4};

use crate::solver::rest::{LANES, Springs};
use crate::solver::settings::Fabric;

/// What a spring of one cloth divides by; depends on masses, stiffness and substep.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SpringFactors {
    /// `1 / (w_a + w_b + 1 / (k h²))` [kg], by batch and lane; 0 where nothing can move.
    soft: Vec<Vec4>,
    /// `1 / (w_a + w_b)` [kg]; 0 without a strain limit.
    hard: Vec<Vec4>,
}

impl SpringFactors {
    /// Memory held [B].
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(&self.soft[..]) + size_of_val(&self.hard[..])
    }

    /// Recomputes all factors for a substep of `h` [s].
    pub fn update(&mut self, springs: &Springs, fabric: &Fabric, positions: &[Vec4], h: f32) {
        self.soft.clear();
        self.hard.clear();
        for k in 0..springs.a.len() {
            let w = Vec4::from_array(std::array::from_fn(|lane| {
                positions[springs.a[k][lane] as usize].w + positions[springs.b[k][lane] as usize].w
            }));
            let membrane =
                Vec4::splat(fabric.stretch_stiffness) + springs.shear[k] * (fabric.shear_stiffness - fabric.stretch_stiffness);
            let stiffness = (membrane * springs.width_ratio[k]).max(Vec4::splat(1.0e-12));
            let free = w.cmpgt(Vec4::ZERO);
            self.soft.push(Vec4::select(free, (w + (stiffness * h * h).recip()).recip(), Vec4::ZERO));
            let limited = fabric.strain_limit.is_finite();
            self.hard.push(if limited { Vec4::select(free, w.recip(), Vec4::ZERO) } else { Vec4::ZERO });
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

const XYZ: Vec4 = Vec4::new(1.0, 1.0, 1.0, 0.0);

/// Solves every spring once.
pub fn solve(springs: &Springs, factors: &SpringFactors, strain_limit: f32, positions: &mut [Vec4]) {
    // Without a limit the factors are 0, and infinity times 0 would not be a number.
    let slack = Vec4::splat(if strain_limit.is_finite() { 1.0 + strain_limit } else { 1.0 });
    let batches = springs.a.iter().zip(&springs.b).zip(&springs.inverse_square).zip(factors.soft.iter().zip(&factors.hard));
    for (((a, b), &inverse_square), (&soft, &hard)) in batches {
        solve_batch(a, b, inverse_square, soft, hard, slack, positions);
    }
}

#[inline(always)]
fn solve_batch(
    a: &[u32; LANES],
    b: &[u32; LANES],
    inverse_square: Vec4,
    soft: Vec4,
    hard: Vec4,
    slack: Vec4,
    positions: &mut [Vec4],
) {
    let (pa, pb, d) = gather(a, b, positions);
    let q = lengths_squared(d) * inverse_square;
    let ratio = (q + Vec4::splat(3.0)) / (q * 3.0 + Vec4::ONE);
    let s = ((Vec4::ONE - ratio) * soft).max((Vec4::ONE - ratio * slack) * hard).to_array();
    for lane in 0..LANES {
        let move_by = d[lane] * XYZ * s[lane];
        positions[a[lane] as usize] = pa[lane] + move_by * pa[lane].w;
        positions[b[lane] as usize] = pb[lane] - move_by * pb[lane].w;
    }
}

/// Longest and mean length over rest length of all springs (dimensionless), lanes that repeat counted again. NaN positions give infinity.
#[must_use]
pub fn strain(springs: &Springs, positions: &[Vec4]) -> (f32, f32) {
    let mut worst = Vec4::ZERO;
    let mut sum = Vec4::ZERO;
    for ((a, b), &inverse_square) in springs.a.iter().zip(&springs.b).zip(&springs.inverse_square) {
        let (_, _, d) = gather(a, b, positions);
        let ratio = (lengths_squared(d) * inverse_square).sqrt();
        worst = Vec4::select(ratio.cmple(worst), worst, ratio);
        sum += ratio;
    }
    let mean = (sum.x + sum.y + sum.z + sum.w) / (LANES * springs.a.len().max(1)) as f32;
    if mean.is_finite() { (worst.max_element(), mean) } else { (f32::INFINITY, f32::INFINITY) }
}
