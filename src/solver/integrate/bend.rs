//! Bending: a step of the quadratic energy with as many stages as the mesh and the stiffness need.
//!
//! `E = ½ Σ B_e A_e |v / A_e - κ₀ n|²`, `v = Σ c_i x_i`, has a constant matrix `K`. Let `Z = h² W K`, with `W` the inverse
//! masses. An explicit step `x - Z x` is unstable once an eigenvalue of `Z` passes 4/3. At 5 mm and 360 Hz cotton has 150. Take
//! a polynomial `R(Z)` with `R(0) = 1` and `R'(0) = -1` that is small up to that eigenvalue. It is as stable as an implicit
//! step, which is `1 / (1 + Z)`, and needs no factorization. Chebyshev polynomials reach farthest (van der Houwen and Sommeijer
//! 1980; Verwer 1996), shifted by `a`:
//!
//! ```text
//! R(z) = a + (1 - a) T_s(w₀ - w₁ z) / T_s(w₀)          stable up to z = (1 + w₀) / w₁, some 0.9 s²
//! D_j = μ D_(j-1) + (1 - μ) D_(j-2) - μ̃ (r + Z D_(j-1))  r = h² W (K x - f),  x + (1 - a) D_s is where the cloth goes
//!       μ = 2 w₀ T_(j-1)(w₀) / T_j(w₀),  μ̃ = 2 w₁ T_(j-1)(w₀) / T_j(w₀),  D_0 = 0,  D_1 = -w₁ / w₀ r
//! ```
//!
//! The shift: positions carry velocities, so a mode with `q = R(z)` goes as `λ² - 2 q λ + q = 0`. Both roots lie within the
//! unit circle for `q` from -1/3 to 1 only. For `q` from 0 on, no mode swings from substep to substep.
//!
//! What bends also rubs, yarn on yarn. That dry friction is a second spring of stiffness `GRIP · B` (Prandtl's element; Miguel
//! et al. 2013). It acts between the curvature and one that follows it at most `κ_y` behind. Its moment is Kawabata's
//! `HB = GRIP · B κ_y`:
//!
//! ```text
//! M = B (κ - κ_rest) + GRIP · B (κ - κ_set)        |κ - κ_set| <= κ_y
//! ```
//!
//! Flat cloth that was pressed to `κ_p` and is let go stays at `(κ_p - κ_y) / 2`. From `κ_p = 3 κ_y` on it stays at
//! `κ_y = HB / B`, the most.
//!
//! The force that keeps the curvature is found once a frame, and keeps its direction until the next. So it brakes cloth that
//! turns by a large angle in a frame, the more the stiffer and the more bent it is.

use glam::Vec4;

use super::IS_XYZ;
use super::rows::Rows;
use crate::solver::rest::{Bends, LANES, Weave};
use crate::solver::settings::Fabric;

/// Stiffness of the friction between yarns over that of the fabric (dimensionless). A fabric that begins to bend is about twice
/// as stiff as one that goes on bending (Kawabata 1980). Then the curvature that friction holds, `HB / B`, is also how far the
/// curvature goes before it slips.
const GRIP: f32 = 1.0;

/// The `a` of the polynomial, about which it swings, and `T_s(w₀)`: it swings by `(1 - MIDDLE) / SWING`, from 0 to 0.85.
const MIDDLE: f32 = 0.425;
const SWING: f32 = 1.353;

/// Most stages in a substep: what needs more is made softer, and [`BendFactors::held`] tells.
const MOST_STAGES: u32 = 32;

/// Share of the reach of the most stages that is used (dimensionless). The eigenvalue is an estimate, and beyond the reach the
/// stages grow without bound.
const WITHIN: f32 = 0.9;

/// Curvature that friction holds in any cloth `[1/m]`, far less than measured in any. At 0 cloth trembles for long; at much
/// more, folds creep to their place.
const TREMBLE: f32 = 4.0;

/// Share of a rate that one element may take (dimensionless), since elements overlap.
const RUB_SHARE: f32 = 0.25;

/// Share of the curvature that friction holds below which an element counts as flat (dimensionless).
const FLAT: f32 = 0.1;

/// How stiff a cloth is against bending, and the buffers of its steps.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct BendFactors {
    /// `(1 + GRIP) B` `[N·m]`.
    stiffness: f32,
    /// Largest eigenvalue of `W K` `[1/s²]`, an estimate.
    fastest: f32,
    /// Largest eigenvalue of `h² W K` that the most stages hold.
    most: f32,
    /// Where the warp is stiffer than the weft or the other way round: its own `K` `[1/m²]` and shares of stiffness that
    /// elements keep.
    weave: Option<Weave>,
    matrix: Vec<[f32; LANES]>,
    keeps: Vec<Vec4>,
    /// The polynomial for an eigenvalue of `h² W K`.
    chosen: Option<(f32, Polynomial)>,
    /// `f` `[N]`, what keeps the curvature at rest and folds; empty where nothing does.
    folds: Vec<Vec4>,
    /// `r` `[m]`.
    residual: Vec<Vec4>,
    /// `D_(j-1)` and `D_(j-2)` `[m]`.
    moves: [Vec<Vec4>; 2],
}

/// `R`: its stages and constants.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
struct Polynomial {
    stages: u32,
    w0: f32,
    w1: f32,
    /// Largest eigenvalue within which it is stable.
    reach: f32,
}

impl Polynomial {
    fn new(stages: u32) -> Self {
        // T_s(w0) = cosh(s θ), T_s'(w0) = s sinh(s θ) / sinh θ, w0 = cosh θ; R'(0) = -1.
        let s = stages as f32;
        let theta = SWING.acosh() / s;
        let w0 = theta.cosh();
        let w1 = SWING * theta.sinh() / ((1.0 - MIDDLE) * s * (s * theta).sinh());
        Self { stages, w0, w1, reach: (1.0 + w0) / w1 }
    }

    /// The one with the fewest stages that is stable up to `eigenvalue`, or with the most there are.
    fn reaching(eigenvalue: f32) -> Self {
        (1..MOST_STAGES).map(Self::new).find(|p| p.reach >= eigenvalue).unwrap_or_else(|| Self::new(MOST_STAGES))
    }
}

impl BendFactors {
    /// Memory held `[B]`.
    #[must_use]
    pub(crate) fn bytes(&self) -> usize {
        let [a, b] = &self.moves;
        let weave = self.weave.as_ref().map_or(0, |weave| size_of_val(&weave.along[..]) + size_of_val(&weave.matrix[..]));
        [&self.folds, &self.residual, a, b, &self.keeps].map(|v| size_of_val(&v[..])).iter().sum::<usize>()
            + size_of_val(&self.matrix[..])
            + weave
    }

    /// Must follow a change of the fabric or of inverse masses, in `w` of `positions` `[1/kg]`; `areas` `[m²]` around
    /// particles.
    pub(crate) fn update(&mut self, bends: &Bends, fabric: &Fabric, areas: &[f32], positions: &[Vec4]) {
        self.stiffness = (1.0 + grip(fabric)) * fabric.bend_stiffness;
        // A pin on a light body may be lighter than the cloth around it.
        let lightest = positions.iter().zip(areas).map(|(x, area)| x.w * fabric.density * area).fold(1.0, f32::max);
        let fastest = self.weave(bends, fabric, areas);
        self.fastest = self.stiffness / fabric.density * fastest * lightest;
        self.most = WITHIN * Polynomial::new(MOST_STAGES).reach;
    }

    /// Makes the directions of the fabric as stiff as asked; the largest eigenvalue of `A⁻¹ K` `[1/m⁴]`.
    fn weave(&mut self, bends: &Bends, fabric: &Fabric, areas: &[f32]) -> f32 {
        self.matrix.clear();
        self.keeps.clear();
        if fabric.bend_ratio == 1.0 {
            self.weave = None;
        } else if self
            .weave
            .as_ref()
            .is_none_or(|weave| weave.angle != fabric.warp_angle || weave.along.len() != bends.hinges.len())
        {
            self.weave = Weave::new(bends, areas, fabric.warp_angle);
        }
        let Some(weave) = &self.weave else { return bends.fastest };
        let (alpha, share) = weave.split(fabric.bend_ratio);
        let both =
            |(k, along): (&[f32; LANES], &[f32; LANES])| std::array::from_fn(|lane| share * (k[lane] + alpha * along[lane]));
        self.matrix.extend(bends.matrix.iter().zip(&weave.matrix).map(both));
        self.keeps
            .extend(bends.keeps.iter().zip(&weave.along).map(|(keeps, along)| keeps * (Vec4::ONE + along * alpha) * share));
        share * weave.fastest(alpha)
    }

    /// Share of the stiffness that substeps of `h` `[s]` hold (dimensionless): 1, unless the mesh is very fine for them.
    #[must_use]
    pub(crate) fn held(&self, h: f32) -> f32 {
        // Nothing to hold is infinitely much of it.
        (self.most / (h * h * self.fastest)).min(1.0)
    }

    /// Finds what keeps the curvature at rest, and folds, where the cloth is now; once a frame. `set`: the curvature `[1/m]`
    /// from which friction holds each hinge, which follows.
    pub(crate) fn fold(&mut self, bends: &Bends, fabric: &Fabric, positions: &[Vec4], set: &mut Vec<Vec4>) {
        self.folds.clear();
        let grip = grip(fabric);
        if self.stiffness == 0.0 || (grip == 0.0 && bends.is_flat) {
            set.clear();
            return;
        }
        // Without friction it follows the cloth, and is not kept.
        if grip == 0.0 || set.len() != bends.rest.len() {
            set.clone_from(&bends.rest);
        }
        self.folds.resize(positions.len(), Vec4::ZERO);
        let slip = Vec4::splat(fabric.bend_hysteresis / GRIP);
        let share = grip / (1.0 + grip);
        let elements = bends.hinges.iter().zip(&bends.coefficients).zip(&bends.area).zip(&bends.rest).zip(&bends.lean);
        let keeps = if self.keeps.is_empty() { &bends.keeps } else { &self.keeps };
        for (((((hinges, c), &area), &rest), lean), (set, &keeps)) in elements.zip(set.iter_mut().zip(keeps)) {
            let x: [[Vec4; 4]; LANES] = std::array::from_fn(|lane| hinges[lane].map(|p| positions[p as usize]));
            let rows = |of: &dyn Fn(usize) -> Vec4| Rows::from(std::array::from_fn(of));
            let v = rows(&|l| x[l][0] * c[l].x + x[l][1] * c[l].y + x[l][2] * c[l].z + x[l][3] * c[l].w);
            let e = rows(&|l| x[l][1] - x[l][0]);
            let o = rows(&|l| (x[l][3] - x[l][2]) + (x[l][3] + x[l][2] - x[l][0] * 2.0) * lean[l]);
            let normal = e.cross(o);
            let length = normal.length();
            let along = v.dot(normal) / length;
            let curvature = along / area;
            *set = set.max(curvature - slip).min(curvature + slip);
            // Along `v`, as the energy has it, so that what is at rest stays; that of a flat element has no direction.
            let side = Vec4::select(along.cmplt(Vec4::ZERO), Vec4::NEG_ONE, Vec4::ONE);
            let flat = (FLAT * (slip + rest.abs()) * area - v.length()).max(Vec4::ZERO) / length;
            let way = v * side + normal * flat;
            let push = way * (keeps * self.stiffness * (rest + (*set - rest) * share) / way.length());
            for ((hinge, c), push) in hinges.iter().zip(c).zip(push.columns()) {
                for (&p, c) in hinge.iter().zip(c.to_array()) {
                    self.folds[p as usize] += push * c;
                }
            }
        }
    }

    /// Bends the cloth in a substep of `h` `[s]`.
    pub(crate) fn solve(&mut self, bends: &Bends, h: f32, positions: &mut [Vec4]) {
        let fastest = h * h * self.fastest;
        if !(fastest > 0.0) {
            return;
        }
        let polynomial = match self.chosen {
            Some((of, polynomial)) if of == fastest => polynomial,
            _ => Polynomial::reaching(fastest),
        };
        self.chosen = Some((fastest, polynomial));
        let Polynomial { stages, w0, w1, .. } = polynomial;
        let hh = h * h * self.held(h);
        let hhb = hh * self.stiffness;
        let Self { folds, residual, moves: [moves, before], matrix, .. } = self;
        let matrix = if matrix.is_empty() { &bends.matrix } else { &*matrix };
        residual.resize(positions.len(), Vec4::ZERO);
        let rows = || bends.row_start.windows(2).map(|row| row[0] as usize..row[1] as usize);
        for ((row, x), r) in rows().zip(&*positions).zip(&mut *residual) {
            let force = product(&bends.columns[row.clone()], &matrix[row], positions, *x);
            *r = Vec4::select(IS_XYZ, force * (hhb * x.w), Vec4::ZERO);
        }
        for ((x, r), fold) in positions.iter().zip(&mut *residual).zip(&*folds) {
            *r -= *fold * (hh * x.w);
        }
        let first = -w1 / w0;
        if stages == 1 {
            for (x, r) in positions.iter_mut().zip(&*residual) {
                *x += *r * (first * (1.0 - MIDDLE));
            }
            return;
        }
        before.clear();
        before.resize(positions.len(), Vec4::ZERO);
        moves.clear();
        moves.extend(residual.iter().map(|r| *r * first));
        let (mut last, mut current) = (1.0, w0);
        for _ in 1..stages {
            (last, current) = (current, 2.0 * w0 * current - last);
            let (mu, step) = (2.0 * w0 * last / current, 2.0 * w1 * last / current);
            for ((((row, older), d), x), r) in rows().zip(&mut *before).zip(&*moves).zip(&*positions).zip(&*residual) {
                let force = product(&bends.columns[row.clone()], &matrix[row], moves, *d);
                *older = *d * mu + *older * (1.0 - mu) - (*r + force * (hhb * x.w)) * step;
            }
            std::mem::swap(before, moves);
        }
        for (x, d) in positions.iter_mut().zip(&*moves) {
            *x += *d * (1.0 - MIDDLE);
        }
    }
}

/// Takes out what trembles: a moment `M = B · TREMBLE` `[N]` per width against every change of `v`, whatever its speed. It acts
/// once per frame of `dt` `[s]`, on the `motion` `[m]` over a substep of `h` `[s]`, `w` its inverse mass `[1/kg]`. Coulomb's
/// law as an impulse:
///
/// ```text
/// Δv̇ = -min(|v̇| / 4, M Σ w c² dt) v̇ / |v̇|       u_i += w_i c_i Δv̇ / Σ w c²
/// ```
pub(crate) fn rub(bends: &Bends, fabric: &Fabric, dt: f32, h: f32, motion: &mut [Vec4]) {
    let moment = TREMBLE * fabric.bend_stiffness * dt * h;
    if !(moment > 0.0) {
        return;
    }
    let (hinges, coefficients) = (bends.hinges.as_flattened(), bends.coefficients.as_flattened());
    // Far apart in the mesh from one to the next, which so do not wait for each other.
    let stride = bends.count.div_ceil(LANES);
    for k in (0..stride).flat_map(|k| (k..bends.count).step_by(stride)) {
        let (hinge, c) = (&hinges[k], coefficients[k]);
        let u = hinge.map(|p| motion[p as usize]);
        let rate = (u[0] * c.x + u[1] * c.y + u[2] * c.z + u[3] * c.w).with_w(0.0);
        let wc = c * Vec4::from_array(u.map(|u| u.w));
        let (speed, w) = (rate.length(), wc.dot(c));
        // Nothing where all is held.
        if speed > 0.0 && w > 0.0 {
            let by = rate * ((moment / speed).min(RUB_SHARE / w));
            for (p, wc) in hinge.iter().zip(wc.to_array()) {
                motion[*p as usize] -= by * wc;
            }
        }
    }
}

/// Stiffness of the friction between yarns, if there is any, over that of the fabric (dimensionless).
fn grip(fabric: &Fabric) -> f32 {
    if fabric.bend_hysteresis > 0.0 { GRIP } else { 0.0 }
}

/// A row of the matrix times a vector whose entry of the row itself is `own`. It has four sums, as each term of a single one
/// would wait for the one before it.
#[inline(always)]
fn product(columns: &[[u32; LANES]], row: &[[f32; LANES]], x: &[Vec4], own: Vec4) -> Vec4 {
    let mut sum = [Vec4::ZERO; LANES];
    for (columns, row) in columns.iter().zip(row) {
        for lane in 0..LANES {
            sum[lane] += (x[columns[lane] as usize] - own) * row[lane];
        }
    }
    (sum[0] + sum[1]) + (sum[2] + sum[3])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::rest::{RestShape, SourceMesh};
    use glam::vec3;

    #[test]
    fn the_polynomial_begins_as_an_explicit_step_and_stays_where_velocities_are_stable() {
        for stages in [1, 2, 3, 8, 32] {
            let p = Polynomial::new(stages);
            let at = |z: f64| {
                // Rounding takes it below -1.
                let chebyshev = |x: f64| {
                    let x = x.max(-1.0);
                    if x.abs() <= 1.0 { (f64::from(stages) * x.acos()).cos() } else { (f64::from(stages) * x.acosh()).cosh() }
                };
                let (a, w0, w1) = (f64::from(MIDDLE), f64::from(p.w0), f64::from(p.w1));
                a + (1.0 - a) * chebyshev(w0 - w1 * z) / chebyshev(w0)
            };
            let slope = (at(1.0e-4) - 1.0) / 1.0e-4;
            assert!((slope + 1.0).abs() < 1.0e-2, "{stages} stages: slope {slope}");
            for k in 1..=1000 {
                let q = at(f64::from(p.reach) * f64::from(k) / 1000.0);
                assert!(q > -1.0e-3 && q < 1.0, "{stages} stages: {q}");
            }
            assert!(p.reach > 0.85 * (stages * stages) as f32, "{stages} stages reach {}", p.reach);
        }
    }

    /// A strip of `n` by 3 vertices in a cylinder of radius `r` `[m]`, flat at rest.
    fn strip(n: u32, d: f32) -> RestShape {
        let mut mesh = SourceMesh::default();
        for i in 0..n {
            mesh.positions.extend((0..3).map(|j| vec3(i as f32 * d, 0.0, j as f32 * d)));
        }
        for i in 0..n - 1 {
            for j in 0..2 {
                let a = 3 * i + j;
                mesh.triangles.extend([[a, a + 1, a + 3], [a + 1, a + 4, a + 3]]);
            }
        }
        RestShape::build(&mesh).map(|(rest, _)| rest).unwrap_or_default()
    }

    /// The strip bent along a zigzag of unequal triangles, `turn` `[rad]` at each.
    fn zigzag(turn: f32) -> RestShape {
        let mut mesh = SourceMesh::default();
        let mut at = glam::Vec2::ZERO;
        for i in 0..20u8 {
            mesh.positions.extend((0..3u8).map(|j| vec3(at.x, at.y, 0.01 * f32::from(j) + 0.002 * f32::from((i + j) % 2))));
            let angle = if i % 2 == 0 { turn } else { 0.0 };
            at += glam::Vec2::from_angle(angle) * (0.004 + 0.003 * f32::from(i % 3));
        }
        for a in (0..19u32).flat_map(|i| [3 * i, 3 * i + 1]) {
            mesh.triangles.extend([[a, a + 1, a + 3], [a + 1, a + 4, a + 3]]);
        }
        RestShape::build(&mesh).map(|(rest, _)| rest).unwrap_or_default()
    }

    #[test]
    fn what_is_bent_at_rest_stays_as_it_is_with_friction_and_without() {
        for (turn, bend_hysteresis) in [0.3, 1.0, 2.0].into_iter().flat_map(|turn| [(turn, 0.0), (turn, 40.0)]) {
            let rest = zigzag(turn);
            assert!(!rest.bends.is_flat);
            let fabric = Fabric { bend_stiffness: 1.0e-4, bend_hysteresis, ..Fabric::default() };
            let weigh = |(x, area): (&glam::Vec3, &f32)| x.extend(1.0 / (fabric.density * area));
            let mut x: Vec<Vec4> = rest.positions.iter().zip(&rest.areas).map(weigh).collect();
            let before = x.clone();
            let (mut factors, mut set) = (BendFactors::default(), Vec::new());
            factors.update(&rest.bends, &fabric, &rest.areas, &x);
            for _ in 0..100 {
                factors.fold(&rest.bends, &fabric, &x, &mut set);
                factors.solve(&rest.bends, 1.0 / 360.0, &mut x);
            }
            let moved = x.iter().zip(&before).map(|(a, b)| (*a - *b).truncate().length()).fold(0.0, f32::max);
            assert!(moved < 1.0e-5, "turned by {turn}, friction {bend_hysteresis}/m: moved by {moved} m");
        }
    }

    #[test]
    fn a_fold_pressed_to_five_millimetres_opens_to_the_radius_that_friction_holds() {
        let rest = strip(41, 0.002);
        let fabric = Fabric { bend_hysteresis: 40.0, ..Fabric::default() };
        let mut factors = BendFactors::default();
        let lay = |r: f32| -> Vec<Vec4> {
            let bend = |x: glam::Vec3| vec3(r * (x.x / r).sin(), r * (x.x / r).cos() - r, x.z);
            rest.positions.iter().zip(&rest.areas).map(|(x, area)| bend(*x).extend(1.0 / (fabric.density * area))).collect()
        };
        let mut set = Vec::new();
        let flat = lay(1.0e3);
        factors.update(&rest.bends, &fabric, &rest.areas, &flat);
        factors.fold(&rest.bends, &fabric, &flat, &mut set);
        factors.fold(&rest.bends, &fabric, &lay(0.005), &mut set);
        // Where the moment is zero: on a cylinder of another radius the force is least.
        let force = |factors: &mut BendFactors, r: f32, set: &[Vec4]| -> f32 {
            let mut x = lay(r);
            factors.fold(&rest.bends, &fabric, &x, &mut set.to_vec());
            let before = x.clone();
            factors.solve(&rest.bends, 1.0e-4, &mut x);
            x.iter().zip(&before).map(|(x, old)| (*x - *old).truncate().length_squared()).sum()
        };
        let radii: Vec<f32> = (0..60).map(|k| 0.006 * 1.05f32.powi(k)).collect();
        let forces: Vec<f32> = radii.iter().map(|r| force(&mut factors, *r, &set)).collect();
        let least = (0..60).min_by(|&a, &b| forces[a].total_cmp(&forces[b])).map_or(0.0, |k| radii[k]);
        let theory = 1.0 / fabric.bend_hysteresis;
        assert!((least / theory - 1.0).abs() < 0.3, "opens to {least} m, B / HB is {theory} m");
    }
}
