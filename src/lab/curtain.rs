//! A hanging curtain, whose folds have a length of their own: the stiffer the cloth and the less it weighs down, the wider.
//!
//! ```text
//! λ = 2 √π (B / T)^(1/4) L^(1/2)    T = ρ g (L - y): tension [N/m] at y below the rail, L: height [m] (Cerda, Mahadevan 2003)
//! ```
//!
//! Hooks on the rail give its upper edge more folds than that; on the way down they join.

use glam::vec3;

use super::{FRAME_RATE, bending_length, hold, rate, settle, specimen, vertex};
use crate::solver::scene::{Scene, grid};
use crate::solver::settings::Fabric;

/// Width of the cloth and its height `[m]`.
pub const SIZE: (f32, f32) = (2.8, 1.4);
/// Width of the hung curtain over that of its cloth (dimensionless).
pub const GATHERED: f32 = 0.9;
/// Hooks: as many as the coarsest mesh has vertices on its upper edge.
pub const HOOKS: u32 = 31;

/// Height of the noise that it starts with `[m]`.
const NOISE: f32 = 1.0e-3;
/// How far an extremum stands out from the ones beside it, over the depth of the folds (dimensionless).
const PROMINENCE: f32 = 0.15;

/// What a curtain shows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Folds {
    /// Folds at half its height; one that ends at a border is a half.
    pub count: f32,
    /// Their length along the rail `[m]`.
    pub wavelength: f32,
    /// Height from the rail to the lowest point `[m]`.
    pub height: f32,
}

/// Wavelength that theory gives at half the height `[m]`.
#[must_use]
pub fn theory(fabric: &Fabric) -> f32 {
    let tension = 0.5 * SIZE.1;
    2.0 * core::f32::consts::PI.sqrt() * (bending_length(fabric).powi(3) / tension).powf(0.25) * SIZE.1.sqrt()
}

/// A curtain of `n` vertices along its height, at least 16, that has come to rest on its hooks, started with noise of that
/// seed.
#[must_use]
pub fn hung(fabric: &Fabric, n: u32, seed: u64) -> Scene {
    let columns = 2 * n - 1;
    let mesh = grid(columns, n, |u, v| vec3(SIZE.0 * (u - 0.5), -SIZE.1 * v, 0.0));
    // Vertices lie column by column.
    let column = |hook: u32| (hook as f32 * (columns - 1) as f32 / (HOOKS - 1) as f32).round() as u32;
    let pins: Vec<u32> = (0..HOOKS).map(|hook| column(hook) * n).collect();
    let mut scene = specimen(&mesh, fabric, &pins, rate(SIZE.1 / (n - 1) as f32));
    let mut rng = fastrand::Rng::with_seed(seed);
    let cloth = &mut scene.cloths[0];
    for (x, rest) in cloth.sim.state.positions.iter_mut().zip(&cloth.rest.positions) {
        let noise = if x.w > 0.0 { NOISE * (2.0 * rng.f32() - 1.0) } else { 0.0 };
        *x = vec3(GATHERED * rest.x, rest.y, noise).extend(x.w);
    }
    hold(cloth);
    settle(&mut scene, FRAME_RATE, 10.0);
    scene
}

/// What a curtain of [`hung`] shows.
#[must_use]
pub fn test(fabric: &Fabric, n: u32, seed: u64) -> Folds {
    let scene = hung(fabric, n, seed);
    let row = (0..2 * n - 1).map(|column| column * n + n / 2);
    let count = 0.5 * extrema(row.map(|v| vertex(&scene, v).z)) as f32;
    Folds { count, wavelength: GATHERED * SIZE.0 / count, height: -scene.cloths[0].lowest() }
}

/// Extrema of a curve that stand out.
fn extrema(curve: impl Iterator<Item = f32> + Clone) -> u32 {
    let (low, high) = curve.clone().fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), z| (low.min(z), high.max(z)));
    let least = PROMINENCE * (high - low);
    let (mut count, mut way, mut valley, mut top) = (0, 0, f32::INFINITY, f32::NEG_INFINITY);
    for z in curve {
        (valley, top) = (valley.min(z), top.max(z));
        if way <= 0 && z > valley + least {
            count += u32::from(way < 0);
            (way, top) = (1, z);
        } else if way >= 0 && z < top - least {
            count += u32::from(way > 0);
            (way, valley) = (-1, z);
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folds_are_counted_and_ripples_on_them_are_not() {
        for folds in [2.0_f32, 4.0, 7.0] {
            let wave = |k: u32| {
                let t = k as f32 / 200.0 * core::f32::consts::TAU;
                0.05 * (folds * t).sin() + 0.002 * (41.0 * t).sin()
            };
            assert_eq!(extrema((0..=200).map(wave)), 2 * folds as u32);
        }
    }
}
