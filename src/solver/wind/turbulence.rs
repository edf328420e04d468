//! Gusts: a sum of random modes, made once and looked up at points.

use glam::{Vec3, Vec3A, Vec4};

use super::{Wind, finite};

/// Number of modes, two vectors of four. Ratio of neighbouring wave numbers is 1.1³, so that `k^(-1/3)` falls by 1.1.
const MODES: usize = 8;
const RATIO_CBRT: f32 = 1.1;

/// Gusts: their strength, size and seed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Turbulence {
    /// Root mean square of each component of the gusts over the mean wind speed (dimensionless). Default 0; open country 0.15,
    /// a city 0.3. Range 0 to 5.
    pub intensity: f32,
    /// Size of the largest eddies `[m]`. Default 4, range 0.05 to 1000. Much larger than the cloth: the wind swells and fades
    /// as a whole; smaller than its triangles: noise.
    pub length: f32,
    /// How often the largest eddies turn over `[Hz]`, on top of the `speed / length` at which they pass by. Default 0.5, range
    /// 0 to 20.
    pub frequency: f32,
    /// Same seed, same gusts.
    pub seed: u64,
}

impl Turbulence {
    /// A steady wind.
    pub const NONE: Self = Self { intensity: 0.0, length: 4.0, frequency: 0.5, seed: 0 };
}

impl Default for Turbulence {
    fn default() -> Self {
        Self::NONE
    }
}

/// The modes of a turbulence, made once per seed and length.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Modes {
    made_for: (u64, u32),
    /// Wave vectors `[turns/m]`, by component, four modes a vector.
    wave: [[Vec4; 3]; MODES / 4],
    /// Amplitudes for a root mean square of 1 per component.
    amplitude: [[Vec4; 3]; MODES / 4],
    /// Phase at the origin `[turns]`.
    phase: [f32; MODES],
    /// Frequency over that of the largest eddies (dimensionless).
    aging: [f32; MODES],
}

impl Modes {
    /// Draws the modes of a turbulence.
    #[must_use]
    pub fn new(turbulence: &Turbulence) -> Self {
        let length = length_of(turbulence);
        let mut random = fastrand::Rng::with_seed(turbulence.seed ^ 0x9e37_79b9_7f4a_7c15);
        let mut modes = Self {
            made_for: (turbulence.seed, length.to_bits()),
            wave: [[Vec4::ZERO; 3]; MODES / 4],
            amplitude: [[Vec4::ZERO; 3]; MODES / 4],
            phase: [0.0; MODES],
            aging: [0.0; MODES],
        };
        // Wave number [turns/m] and amplitude of each mode; 3/2 σ² = Σ |a|²/4 a component, so Σ |a|² = 6 for σ = 1.
        let mut number = 1.0 / length;
        let mut strength = 1.0;
        let mut energy = 0.0;
        let mut drawn = [(Vec3::ZERO, Vec3::ZERO); MODES];
        for ((wave, amplitude), (phase, aging)) in
            drawn.iter_mut().map(|(w, a)| (w, a)).zip(modes.phase.iter_mut().zip(&mut modes.aging))
        {
            let direction = on_sphere(&mut random);
            let across = on_sphere(&mut random).cross(direction).normalize_or(direction.any_orthonormal_vector());
            *wave = direction * number;
            *amplitude = across * strength;
            *phase = random.f32();
            // An eddy turns over in the time its own speed takes across it: ω ∝ |a| k.
            *aging = strength * number * length;
            energy += strength * strength;
            number *= RATIO_CBRT * RATIO_CBRT * RATIO_CBRT;
            strength /= RATIO_CBRT;
        }
        let scale = (6.0_f32 / energy).sqrt();
        for (i, (wave, amplitude)) in drawn.into_iter().enumerate() {
            for axis in 0..3 {
                modes.wave[i / 4][axis][i % 4] = wave[axis];
                modes.amplitude[i / 4][axis][i % 4] = amplitude[axis] * scale;
            }
        }
        modes
    }

    pub(super) fn fits(&self, turbulence: &Turbulence) -> bool {
        self.made_for == (turbulence.seed, length_of(turbulence).to_bits())
    }

    /// Phases at the origin of the frame now `[turns]`, reduced in double precision: exact at any distance and time.
    pub(super) fn now(&self, wind: &Wind) -> [Vec4; MODES / 4] {
        let start = wind.origin - wind.travel;
        let frequency = f64::from(finite(Vec3::splat(wind.turbulence.frequency)).x);
        let mut now = [Vec4::ZERO; MODES / 4];
        for i in 0..MODES {
            let k = [0, 1, 2].map(|axis: usize| f64::from(self.wave[i / 4][axis][i % 4]));
            let phase = k[0] * start.x
                + k[1] * start.y
                + k[2] * start.z
                + f64::from(self.phase[i])
                + f64::from(self.aging[i]) * frequency * wind.time;
            now[i / 4][i % 4] = if phase.is_finite() { (phase - phase.floor()) as f32 } else { 0.0 };
        }
        now
    }

    /// Gust of unit strength at a point.
    #[inline]
    pub(super) fn at(&self, now: &[Vec4; MODES / 4], point: Vec3A) -> Vec3A {
        let (x, y, z) = (Vec4::splat(point.x), Vec4::splat(point.y), Vec4::splat(point.z));
        let mut sum = [Vec4::ZERO; 3];
        for ((k, a), phase) in self.wave.iter().zip(&self.amplitude).zip(now) {
            let wave = cos_turns(k[0] * x + k[1] * y + k[2] * z + *phase);
            for axis in 0..3 {
                sum[axis] += a[axis] * wave;
            }
        }
        Vec3A::new(sum[0].element_sum(), sum[1].element_sum(), sum[2].element_sum())
    }
}

/// Cosine of a phase in turns, four at a time; error below 2e-4. Only sums and products: the same bits on every machine.
#[inline]
fn cos_turns(phase: Vec4) -> Vec4 {
    let f = phase - phase.round();
    // cos(2π f) = sin(2π (¼ - |f|)), odd polynomial on ±¼.
    let s = (Vec4::splat(0.25) - f.abs()) * core::f32::consts::TAU;
    let s2 = s * s;
    let p = Vec4::splat(-1.0 / 5040.0) * s2 + Vec4::splat(1.0 / 120.0);
    let p = p * s2 - Vec4::splat(1.0 / 6.0);
    (p * s2 + Vec4::ONE) * s
}

/// A direction with equal chance for all (Marsaglia 1972, by rejection).
fn on_sphere(random: &mut fastrand::Rng) -> Vec3 {
    for _ in 0..64 {
        let mut axis = || random.f32() * 2.0 - 1.0;
        let v = Vec3::new(axis(), axis(), axis());
        let length2 = v.length_squared();
        if length2 > 0.01 && length2 <= 1.0 {
            return v / length2.sqrt();
        }
    }
    Vec3::X
}

pub(super) fn intensity_of(wind: &Wind) -> f32 {
    if wind.turbulence.intensity.is_finite() { wind.turbulence.intensity.clamp(0.0, 5.0) } else { 0.0 }
}

fn length_of(turbulence: &Turbulence) -> f32 {
    if turbulence.length.is_finite() { turbulence.length.clamp(0.05, 1000.0) } else { Turbulence::NONE.length }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::solver::wind::WindForces;

    fn gusty(seed: u64) -> Wind {
        Wind {
            velocity: Vec3::X * 8.0,
            turbulence: Turbulence { intensity: 0.2, length: 2.0, frequency: 0.5, seed },
            ..Wind::STILL
        }
    }

    #[test]
    fn gusts_follow_their_seed_have_no_mean_and_the_stated_strength() {
        let mut forces = WindForces::default();
        let mut sample = |wind: &Wind, p: Vec3| forces.velocity_at(wind, p) - wind.velocity;
        let at = Vec3::new(1.0, 2.0, 3.0);
        let (a, b, c) = (sample(&gusty(1), at), sample(&gusty(2), at), sample(&gusty(1), at));
        assert_eq!(a, c, "same seed, other gusts");
        assert!((a - b).length() > 1.0e-3, "other seed, same gusts");
        let mut random = fastrand::Rng::with_seed(9);
        let (mut sum, mut squares) = (Vec3::ZERO, Vec3::ZERO);
        let count = 40_000;
        for i in 0..count {
            let mut axis = || random.f32() * 200.0;
            let gust = sample(&gusty(i % 50), Vec3::new(axis(), axis(), axis()));
            sum += gust;
            squares += gust * gust;
        }
        let (mean, rms) = (sum / count as f32, (squares / count as f32).map(f32::sqrt));
        assert!(mean.length() < 0.05, "mean {mean} m/s");
        assert!((rms / 1.6 - Vec3::ONE).abs().max_element() < 0.15, "rms {rms} m/s, wanted 1.6");
    }

    #[test]
    fn gusts_are_divergence_free_and_carried_by_the_wind() {
        let mut forces = WindForces::default();
        let mut wind = gusty(3);
        let (mut worst, mut slope) = (0.0_f32, 0.0_f32);
        for i in 0..100 {
            let p = Vec3::new(0.17 * i as f32, 0.31 * i as f32, 0.05 * i as f32);
            let e = 0.02;
            let mut d =
                |axis: Vec3| (forces.velocity_at(&wind, p + axis * e) - forces.velocity_at(&wind, p - axis * e)) / (2.0 * e);
            let (x, y, z) = (d(Vec3::X), d(Vec3::Y), d(Vec3::Z));
            worst = worst.max((x.x + y.y + z.z).abs());
            slope = slope.max(x.length()).max(y.length());
        }
        assert!(worst < 0.01 * slope, "divergence {worst} 1/s at slopes of {slope} 1/s");
        wind.turbulence.frequency = 0.0;
        let (p, before) = (Vec3::ONE, forces.velocity_at(&wind, Vec3::ONE));
        for _ in 0..100 {
            wind.advance(0.01);
        }
        let after = forces.velocity_at(&wind, p + Vec3::X * 8.0);
        assert!((after - before).length() < 1.0e-3, "{before} m/s was carried to {after} m/s");
    }

    #[test]
    fn gusts_are_one_field_in_the_world_10_km_from_its_origin() {
        let mut forces = WindForces::default();
        let near = Wind { origin: DVec3::new(10_000.0, 0.0, 10_000.0), ..gusty(5) };
        let next = Wind { origin: near.origin + DVec3::X * 3.0, ..near.clone() };
        let (a, b) = (forces.velocity_at(&near, Vec3::X * 4.0), forces.velocity_at(&next, Vec3::X));
        assert!((a - b).length() < 1.0e-4, "{a} and {b} m/s at the same place");
    }
}
