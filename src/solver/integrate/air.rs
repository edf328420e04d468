//! Air that goes with the cloth.
//!
//! A sheet that waves with a wavelength `λ` moves the air on both of its sides with it, out to some `λ / 2π`. Across its plane
//! it has the mass of `m = ρ_air λ / π` per area on top of its own `ρ` (potential flow over a wavy wall). That mass has inertia
//! and no weight. So light fabric floats: silk of 0.06 kg/m² carries as much air again. Folds of cloth have the wavelength of a
//! sheet that hangs by its own weight (Cerda and Mahadevan 2003):
//!
//! ```text
//! λ = 2 √π c^(3/4) L^(1/4)      c = (B / (ρ g))^(1/3), L: size of the cloth, λ at most 2 L
//! Δv ← Δv - m / (ρ + m) n (n · Δv)      of each particle in a substep: added mass
//! ```
//!
//! What holds the cloth still holds it as before: only a change of velocity is made less. Without gravity nothing tells a
//! wavelength, and there is no air.

use core::f32::consts::PI;

use glam::Vec4;

use crate::solver::rest::RestShape;
use crate::solver::settings::Fabric;

/// The air around the particles of a cloth in a frame.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Carried {
    /// Velocities at the start of the substep `[m/s]`; empty while no air is carried.
    before: Vec<Vec4>,
    /// Normals at the start of the frame, as long as the root of the share of the air that goes along (dimensionless).
    normals: Vec<Vec4>,
}

/// Mass per area of the air that goes with a cloth of `area` `[m²]`, over all that moves (dimensionless), 0 to 1.
#[must_use]
pub(crate) fn share(fabric: &Fabric, area: f32, gravity: f32, air_density: f32) -> f32 {
    let size = area.sqrt();
    let length = (fabric.bend_stiffness / (fabric.density * gravity)).cbrt();
    let wave = (2.0 * PI.sqrt() * length.powf(0.75) * size.powf(0.25)).min(2.0 * size);
    let air = air_density * wave / PI;
    if air > 0.0 && gravity > 0.0 { (air / (air + fabric.density)).min(1.0) } else { 0.0 }
}

impl Carried {
    /// Memory held `[B]`.
    #[must_use]
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.before[..]) + size_of_val(&self.normals[..])
    }

    /// Begins a frame with a `share` of air in what moves across the cloth (dimensionless), 0 for none.
    pub(crate) fn begin(&mut self, share: f32, rest: &RestShape, positions: &[Vec4]) {
        self.before.clear();
        self.normals.clear();
        // In a frame without air, too: none after the first allocates.
        self.before.reserve(positions.len());
        self.normals.reserve(positions.len());
        if !(share > 0.0) {
            return;
        }
        self.normals.resize(positions.len(), Vec4::ZERO);
        for face in &rest.topology.faces {
            let [a, b, c] = face.map(|p| positions[p as usize].truncate());
            let normal = (b - a).cross(c - a).extend(0.0);
            for &p in face {
                self.normals[p as usize] += normal;
            }
        }
        for ((normal, &area), x) in self.normals.iter_mut().zip(&rest.areas).zip(positions) {
            // Where cloth is folded to a point the air is on no side of it, and the normals cancel.
            let length = normal.length();
            let part = share * (length / (6.0 * area)).min(1.0);
            let scale = part.sqrt() / length;
            *normal = if x.w > 0.0 && scale.is_finite() { *normal * scale } else { Vec4::ZERO };
        }
    }

    /// Ends it: no air is carried until the next begins.
    pub(crate) fn end(&mut self) {
        self.normals.clear();
    }

    /// Leaves out particles that lie on something until the end of the frame: no air is between.
    pub(crate) fn leave_out(&mut self, touching: impl Iterator<Item = u32>) {
        if !self.normals.is_empty() {
            touching.for_each(|p| self.normals[p as usize] = Vec4::ZERO);
        }
    }

    /// Notes the velocities at the start of a substep; `substep` `[s]` lies between `previous` and `positions`, 0 before the
    /// first.
    pub(crate) fn note(&mut self, substep: f32, positions: &[Vec4], previous: &[Vec4]) {
        self.before.clear();
        if !self.normals.is_empty() {
            let rate = if substep > 0.0 { 1.0 / substep } else { 0.0 };
            self.before.extend(positions.iter().zip(previous).map(|(x, old)| (*x - *old) * rate));
        }
    }

    /// Takes from what a substep of `substep` `[s]` changed of the velocities across the cloth what the air keeps.
    pub(crate) fn keep(&self, substep: f32, positions: &[Vec4], previous: &mut [Vec4]) {
        for (((x, old), before), normal) in positions.iter().zip(previous).zip(&self.before).zip(&self.normals) {
            let change = (*x - *old) - *before * substep;
            *old += *normal * normal.dot(change);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_fabric_has_as_much_air_again_and_without_gravity_there_is_none() {
        let silk = Fabric { density: 0.06, bend_stiffness: 1.55e-6, ..Fabric::default() };
        assert!((0.4..0.6).contains(&share(&silk, 1.0, 9.81, 1.225)), "{}", share(&silk, 1.0, 9.81, 1.225));
        let limp = Fabric { bend_stiffness: 0.0, ..silk.clone() };
        for (fabric, gravity, density) in [(&silk, 0.0, 1.225), (&silk, 9.81, 0.0), (&limp, 0.0, 1.225), (&limp, 9.81, 1.225)] {
            assert_eq!(share(fabric, 1.0, gravity, density), 0.0, "{gravity} m/s², {density} kg/m³");
        }
    }
}
