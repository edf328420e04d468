//! Air that goes with the cloth.
//!
//! A sheet that waves with a wavelength `λ` moves the air on both of its sides with it, out to some `λ / 2π`: across its plane it has the mass of
//! `m = ρ_air λ / π` per area on top of its own `ρ` (potential flow over a wavy wall), which has inertia and no weight. So light fabric floats: silk
//! of 0.06 kg/m² carries as much air again. Folds of cloth have the wavelength of a sheet that hangs by its own weight (Cerda and Mahadevan 2003):
//!
//! ```text
//! λ = 2 √π c^(3/4) L^(1/4)      c = (B / (ρ g))^(1/3), L: size of the cloth, λ at most 2 L
//! Δv ← Δv - m / (ρ + m) n (n · Δv)      of each particle in a frame
//! ```
//!
//! What holds the cloth still holds it as before: only a change of velocity is made less.

use core::f32::consts::PI;

use glam::Vec4;

use crate::solver::rest::RestShape;
use crate::solver::settings::Fabric;

/// Velocities at the start of a frame, and buffers.
#[derive(Clone, Debug, Default)]
pub struct Carried {
    /// Velocities at the start of the frame [m/s]; empty while no air is carried.
    before: Vec<Vec4>,
    /// Sum of area times normal of the faces around each particle, over three times the particle's own area (dimensionless).
    normals: Vec<Vec4>,
}

/// Mass per area of the air that goes with a cloth of `area` [m²], over all that moves (dimensionless), 0 to 1.
#[must_use]
pub fn share(fabric: &Fabric, area: f32, gravity: f32, air_density: f32) -> f32 {
    let size = area.sqrt();
    let length = (fabric.bend_stiffness / (fabric.density * gravity)).cbrt();
    let wave = (2.0 * PI.sqrt() * length.powf(0.75) * size.powf(0.25)).min(2.0 * size);
    let air = air_density * wave / PI;
    // Not a number without gravity and stiffness.
    if air > 0.0 { (air / (air + fabric.density)).min(1.0) } else { 0.0 }
}

impl Carried {
    /// Memory held [B].
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(&self.before[..]) + size_of_val(&self.normals[..])
    }

    /// Notes the velocities at the start of a frame; `substep` [s] lies between `previous` and `positions`, 0 before the first. None without a `share`.
    pub fn note(&mut self, share: f32, substep: f32, positions: &[Vec4], previous: &[Vec4]) {
        self.before.clear();
        if share > 0.0 {
            let rate = if substep > 0.0 { 1.0 / substep } else { 0.0 };
            self.before.extend(positions.iter().zip(previous).map(|(x, old)| (*x - *old) * rate));
        }
    }

    /// Leaves out all.
    pub fn clear(&mut self) {
        self.before.clear();
    }

    /// Leaves out particles that lie on something: no air is between.
    pub fn leave_out(&mut self, touching: impl Iterator<Item = u32>) {
        if !self.before.is_empty() {
            touching.for_each(|p| self.before[p as usize] = Vec4::NAN);
        }
    }

    /// Takes from what the frame changed of the velocities across the cloth what the air keeps, a `share` (dimensionless).
    pub fn keep(&mut self, share: f32, rest: &RestShape, substep: f32, positions: &[Vec4], previous: &mut [Vec4]) {
        if self.before.is_empty() {
            return;
        }
        self.normals.clear();
        self.normals.resize(positions.len(), Vec4::ZERO);
        for face in &rest.topology.faces {
            let [a, b, c] = face.map(|p| positions[p as usize].truncate());
            let normal = (b - a).cross(c - a).extend(0.0);
            for &p in face {
                self.normals[p as usize] += normal;
            }
        }
        let all = positions.iter().zip(previous).zip(&self.before).zip(&self.normals).zip(&rest.areas);
        for ((((x, old), before), normal), &area) in all {
            let change = (*x - *old) - *before * substep;
            // Where cloth is folded to a point the air is on no side of it, and the normals cancel.
            let normal = *normal / (6.0 * area);
            let kept = normal * (share * normal.dot(change) / normal.length().max(1.0e-6));
            if x.w > 0.0 && kept.is_finite() {
                *old += kept.with_w(0.0);
            }
        }
    }
}
