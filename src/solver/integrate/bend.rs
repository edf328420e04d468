//! Bending across interior edges: `C = |v| - |v|_rest`, `v = Σ c_i x_i`, of compliance `(A1 + A2) / B`.
//!
//! ```text
//! Δx_i = -w_i c_i s v      s = (1 - |v|_rest / |v|) / (Σ w_i c_i² + 1 / (k h²))      k = B / (A1 + A2)
//! ```
//!
//! Linear in positions on a flat rest shape, so it takes neither a square root nor an angle (Bergou et al. 2006; XPBD as in `spring`).

use glam::{BVec4A, Mat4, Vec4};

use crate::solver::rest::{Bends, LANES};

/// Least compliance over `Σ w c²` (dimensionless). Elements overlap, so solving each fully overshoots what all of them want together, and bending
/// that is solved in every other substep then gains energy. At 4, sheets of 256² stay within 7 % of their length; at 0 they stretch to 180 %.
const SOFTEST: f32 = 4.0;

/// What each of the four particles of a bending element moves by along `v`; depends on masses, stiffness and substep.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BendFactors {
    /// `w_i c_i / (Σ w c² + max(1 / (k h²), SOFTEST Σ w c²))` (dimensionless), one vector per lane.
    share: Vec<[Vec4; LANES]>,
    rub: Vec<Rub>,
    flat: bool,
}

/// What [`rub`] multiplies shares with, by lane; 0 where nothing can move.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Rub {
    /// What shares were divided by [1/kg].
    divisor: Vec4,
    /// The same times [`RUB_SHARE`] over `Σ w c²` (dimensionless): no more is taken.
    most: Vec4,
}

impl BendFactors {
    /// Memory held [B].
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(&self.share[..]) + size_of_val(&self.rub[..])
    }

    /// Recomputes all factors for bending stiffness `stiffness` [N·m] and `hh` = the substep times the time since the last pass [s²].
    pub fn update(&mut self, bends: &Bends, stiffness: f32, positions: &[Vec4], hh: f32) {
        self.share.clear();
        self.rub.clear();
        self.flat = bends.rest.iter().all(|r| *r == Vec4::ZERO);
        for k in 0..bends.rest.len() {
            let spring = (bends.inverse_area[k] * stiffness).max(Vec4::splat(1.0e-20)) * hh;
            let mut rub = Rub::default();
            self.share.push(std::array::from_fn(|lane| {
                let c = bends.coefficients[k][lane];
                let wc = c * Vec4::from_array(bends.particles[k][lane].map(|p| positions[p as usize].w));
                let w = wc.dot(c);
                let divisor = (w + (1.0 / spring[lane]).max(SOFTEST * w)).max(f32::MIN_POSITIVE);
                if w > 0.0 {
                    (rub.divisor[lane], rub.most[lane]) = (divisor, RUB_SHARE * divisor / w);
                }
                wc / divisor
            }));
            self.rub.push(rub);
        }
    }
}

/// Curvature within which a fabric keeps any bend, by the friction of its yarns [1/m]: the moment of hysteresis over the bending stiffness.
/// Kawabata (1980) measures 10 to 50 on wool and cotton. 0: folds swing for a long time; much more: folds creep to their place.
const HYSTERESIS: f32 = 4.0;

/// Share of a rate that one element may take, since elements overlap.
const RUB_SHARE: f32 = 0.25;

/// Friction between yarns that slide on each other where the cloth bends: a moment `M = B · HYSTERESIS` [N] per width against every change
/// of `v`, whatever its speed, so that a cloth comes to rest. Once per frame of `dt` [s], for the `motion` [m] over a substep of `h` [s],
/// `w` its inverse mass [1/kg]; Coulomb's law as an impulse:
///
/// ```text
/// Δv̇ = -min(|v̇| / 4, M Σ w c² dt) v̇ / |v̇|       u_i += w_i c_i Δv̇ / Σ w c²
/// ```
pub fn rub(bends: &Bends, factors: &BendFactors, stiffness: f32, dt: f32, h: f32, motion: &mut [Vec4]) {
    let moment = stiffness * HYSTERESIS * dt * h;
    if !(moment > 0.0) {
        return;
    }
    let batches = bends.particles.iter().zip(&bends.coefficients).zip(&factors.share).zip(&factors.rub);
    for (((particles, coefficients), shares), rub) in batches {
        let u: [[Vec4; 4]; LANES] = std::array::from_fn(|lane| particles[lane].map(|p| motion[p as usize]));
        let rate: [Vec4; LANES] = std::array::from_fn(|lane| curvature(&u[lane], coefficients[lane]));
        let m = Mat4::from_cols(rate[0], rate[1], rate[2], rate[3]).transpose();
        let length = (m.x_axis * m.x_axis + m.y_axis * m.y_axis + m.z_axis * m.z_axis).sqrt();
        let by = (rub.divisor * moment / length.max(Vec4::splat(f32::MIN_POSITIVE))).min(rub.most).to_array();
        for lane in 0..LANES {
            spread(&particles[lane], &u[lane], rate[lane] * by[lane], shares[lane], motion);
        }
    }
}

/// Solves every bending element once.
pub fn solve(bends: &Bends, factors: &BendFactors, positions: &mut [Vec4]) {
    let batches = bends.particles.iter().zip(&bends.coefficients).zip(&factors.share);
    if factors.flat {
        for ((particles, coefficients), shares) in batches {
            for lane in 0..LANES {
                let x = particles[lane].map(|p| positions[p as usize]);
                let v = curvature(&x, coefficients[lane]);
                spread(&particles[lane], &x, v, shares[lane], positions);
            }
        }
        return;
    }
    for (((particles, coefficients), shares), &rest) in batches.zip(&bends.rest) {
        let x: [[Vec4; 4]; LANES] = std::array::from_fn(|lane| particles[lane].map(|p| positions[p as usize]));
        let v: [Vec4; LANES] = std::array::from_fn(|lane| curvature(&x[lane], coefficients[lane]));
        let m = Mat4::from_cols(v[0], v[1], v[2], v[3]).transpose();
        let length = (m.x_axis * m.x_axis + m.y_axis * m.y_axis + m.z_axis * m.z_axis).sqrt();
        // Without a direction a curved hinge cannot tell which way to open.
        let keep = Vec4::select(length.cmpgt(rest * 1.0e-3), Vec4::ONE - rest / length, Vec4::ZERO).to_array();
        for lane in 0..LANES {
            spread(&particles[lane], &x[lane], v[lane] * keep[lane], shares[lane], positions);
        }
    }
}

/// `v = Σ c_i x_i`.
#[inline(always)]
fn curvature(x: &[Vec4; 4], c: Vec4) -> Vec4 {
    let v = x[0] * c.x + x[1] * c.y + x[2] * c.z + x[3] * c.w;
    Vec4::select(BVec4A::from_array([true, true, true, false]), v, Vec4::ZERO)
}

/// Moves four particles by their shares of `v`.
#[inline(always)]
fn spread(particles: &[u32; 4], x: &[Vec4; 4], v: Vec4, share: Vec4, positions: &mut [Vec4]) {
    let share = share.to_array();
    for k in 0..4 {
        positions[particles[k] as usize] = x[k] - v * share[k];
    }
}
