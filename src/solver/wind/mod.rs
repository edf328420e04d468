//! Wind: a velocity field, and the force it puts on each triangle.
//!
//! ```text
//!  field     w(x, t) = m(x) + I |m(x)| Σ a_n cos(k_n · (x - s) + ω_n t + φ_n),    a_n ⟂ k_n
//!                      m = mean velocity with zones,  s = ∫ velocity dt
//!  triangle  v = w - v_triangle,   n turned so that c = v · n >= 0,   A its area
//!            F = ½ ρ A c (C_D v + C_L (|v| n - c v / |v|))
//!  particle  a = F w_i / √(1 + x²),   x = hold · w_i · Σ |F| / |v|
//! ```
//!
//! *Field.* A sum of random Fourier modes (Kraichnan 1970), each divergence-free because its amplitude is across its wave
//! vector. Wave numbers are in a geometric row with `|a| ∝ k^(-1/3)`, which is Kolmogorov's `E(k) ∝ k^(-5/3)`. The mean wind
//! carries the eddies along (Taylor 1938, frozen turbulence) while `ω_n ∝ k^(2/3)` lets them age.
//!
//! *Force.* A flat plate as in Wejchert & Haumann 1991, with drag and lift apart. Drag is along the wind on the projected area
//! `A c / |v|`. Lift is across it in the plane of wind and normal. Both have the factor `½ ρ |v|²`. `C_D` is 1.17 for a square
//! plate across the wind (Hoerner 1965).
//!
//! *Stability.* The force is held for `hold` seconds. In that time an explicit `½ ρ C A v² hold` may exceed `m v` many times
//! (at 60 m/s and 0.1 kg/m²: four times). Explicitly the relative velocity would change by `x v`. Divided by `√(1 + x²)` it
//! changes by less than `v`, so that it decays and is never reversed. A gentle wind (`x < 0.1`) loses less than 0.5 % of its
//! force. (Implicit Euler divides by `1 + x` and loses 10 %.)

mod forces;
mod plate;
#[cfg(test)]
mod tests;
mod turbulence;
mod zones;

use glam::{DVec3, Vec3};

pub use forces::{Aerodynamics, WindForces};
pub use turbulence::{Modes, Turbulence};
pub use zones::{WindZone, ZoneMode, ZoneShape};

use turbulence::intensity_of;

/// Density of air at 15 °C and sea level `[kg/m³]`.
pub(crate) const AIR_DENSITY: f32 = 1.225;

/// The air as one cloth sees it in one frame.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Wind {
    /// Mean velocity `[m/s]`. Default 0. Not finite counts as 0.
    pub velocity: Vec3,
    /// Density of the air `[kg/m³]`. Default 1.225, range 0 to 1000. 0: no air at all, not even drag.
    pub density: f32,
    /// Gusts.
    pub turbulence: Turbulence,
    /// Places with a wind of their own, in the frame of simulation, applied in this order.
    pub zones: Vec<WindZone>,
    /// The world's coordinates of the origin of the frame of simulation `[m]`, so that the gusts are one field in the world.
    pub origin: DVec3,
    /// How far the mean wind has carried the eddies since the start, `∫ velocity dt` `[m]`. See [`Wind::advance`].
    pub travel: DVec3,
    /// Time since the start `[s]`: the age of the eddies. See [`Wind::advance`].
    pub time: f64,
}

impl Wind {
    /// No air: no force, no cost.
    pub const NONE: Self = Self::still(0.0);

    /// Air at rest: drag on cloth that moves.
    pub const STILL: Self = Self::still(AIR_DENSITY);

    const fn still(density: f32) -> Self {
        Self {
            velocity: Vec3::ZERO,
            density,
            turbulence: Turbulence::NONE,
            zones: Vec::new(),
            origin: DVec3::ZERO,
            travel: DVec3::ZERO,
            time: 0.0,
        }
    }

    /// Lets `dt` seconds pass: the eddies age and travel with the mean wind. A change of `velocity` bends their way and does
    /// not make them jump.
    pub fn advance(&mut self, dt: f32) {
        if dt.is_finite() {
            self.time += f64::from(dt);
            self.travel += finite(self.velocity).as_dvec3() * f64::from(dt);
        }
    }

    /// Mean velocity with zones at a point of the frame of simulation `[m/s]`.
    #[must_use]
    pub(crate) fn mean_at(&self, point: Vec3) -> Vec3 {
        self.zones.iter().fold(finite(self.velocity), |wind, zone| zone.blend(point, wind))
    }

    /// Bound on the speed of the air anywhere `[m/s]`, except in one gust of a thousand: no particle is blown faster than this.
    #[must_use]
    pub fn fastest(&self) -> f32 {
        if !self.blows() {
            return 0.0;
        }
        let mean = self.zones.iter().fold(finite(self.velocity).length(), |speed, zone| speed + finite(zone.velocity).length());
        mean * (1.0 + 3.0 * intensity_of(self))
    }

    fn blows(&self) -> bool {
        self.density > 0.0 && self.density.is_finite()
    }
}

impl Default for Wind {
    fn default() -> Self {
        Self::STILL
    }
}

fn finite(v: Vec3) -> Vec3 {
    if v.is_finite() { v.clamp_length_max(1.0e4) } else { Vec3::ZERO }
}
