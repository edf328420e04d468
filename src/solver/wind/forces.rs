//! The force of the wind on every particle of a cloth, and what it accelerates it by.

#[cfg(any(test, feature = "debug"))]
use glam::Vec3;
use glam::{Vec3A, Vec4};

use super::plate::Plate;
use super::turbulence::{Modes, Turbulence, intensity_of};
use super::{Wind, finite};
use crate::solver::rest::LANES;

/// How a fabric takes the wind.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Aerodynamics {
    /// Drag coefficient `C_D` (dimensionless). Default 1.2, range 0 to 10.
    pub drag: f32,
    /// Lift coefficient `C_L` (dimensionless). Default 0.6, range 0 to 10.
    pub lift: f32,
}

impl Default for Aerodynamics {
    fn default() -> Self {
        Self { drag: 1.2, lift: 0.6 }
    }
}

/// Forces of the wind on one cloth. Buffers are reused: nothing is allocated once they are warm.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct WindForces {
    modes: Option<Modes>,
    /// Wind relative to each particle `[m/s]`.
    relative: Vec<Vec4>,
    /// `xyz` force `[N]`, `w` coefficient of drag `|F| / |v|` `[kg/s]` of each particle.
    forces: Vec<Vec4>,
}

impl WindForces {
    /// Velocity of the air at a point of the frame of simulation `[m/s]`, gusts and zones included.
    #[cfg(any(test, feature = "debug"))]
    pub(crate) fn velocity_at(&mut self, wind: &Wind, point: Vec3) -> Vec3 {
        let mean = wind.mean_at(point);
        let intensity = intensity_of(wind);
        if intensity <= 0.0 {
            return mean;
        }
        let modes = self.modes_of(&wind.turbulence);
        let gust = modes.at(&modes.now(wind), point.into());
        mean + Vec3::from(gust) * (intensity * mean.length())
    }

    /// Adds the acceleration of each particle by the air to `acc` (`xyz` `[m/s²]`, `w` unused).
    ///
    /// `positions`: `w` = inverse mass `[1/kg]`, particles with 0 get nothing. `substep`: time between `previous` and
    /// `positions` `[s]`, 0 or less when the cloth is at rest. `hold`: how long the accelerations will be used before the next
    /// call `[s]`. Faces with an index past the end: no force.
    #[expect(clippy::too_many_arguments, reason = "arrays of a cloth, which the frame keeps apart")]
    pub fn apply(
        &mut self,
        wind: &Wind,
        fabric: Aerodynamics,
        faces: &[[u32; 3]],
        positions: &[Vec4],
        previous: &[Vec4],
        substep: f32,
        hold: f32,
        acc: &mut [Vec4],
    ) {
        let drag = coefficient(fabric.drag);
        let lift = coefficient(fabric.lift);
        let known = positions.len().min(previous.len());
        if !wind.blows() || (drag <= 0.0 && lift <= 0.0) || faces.as_flattened().iter().any(|&i| i as usize >= known) {
            return;
        }
        self.relative_velocities(wind, positions, previous, substep);
        self.forces.clear();
        self.forces.resize(positions.len(), Vec4::ZERO);
        let plate = Plate { share: wind.density.min(1000.0) / 12.0, drag, lift };
        let (positions, relative, forces) = (&positions[..known], &self.relative[..known], &mut self.forces[..known]);
        let (fours, rest) = faces.as_chunks::<LANES>();
        for four in fours {
            plate.press(four, positions, relative, forces);
        }
        if let Some(&last) = rest.last() {
            // Lanes left over have no area, so they take no force.
            let four = std::array::from_fn(|lane| rest.get(lane).copied().unwrap_or([last[0]; 3]));
            plate.press(&four, positions, relative, forces);
        }
        let hold = if hold.is_finite() { hold.max(0.0) } else { 0.0 };
        for ((acc, force), position) in acc.iter_mut().zip(&self.forces).zip(positions) {
            let w = position.w;
            let x = hold * w * force.w;
            let a = (*force * (w / (1.0 + x * x).sqrt())).with_w(0.0);
            if a.is_finite() {
                *acc += a;
            }
        }
    }

    fn modes_of(&mut self, turbulence: &Turbulence) -> &Modes {
        match &mut self.modes {
            Some(modes) if modes.fits(turbulence) => {}
            other => *other = None,
        }
        self.modes.get_or_insert_with(|| Modes::new(turbulence))
    }

    /// One evaluation of the field per particle: half as many as triangles.
    fn relative_velocities(&mut self, wind: &Wind, positions: &[Vec4], previous: &[Vec4], substep: f32) {
        let mut relative = core::mem::take(&mut self.relative);
        relative.clear();
        let rate = if substep > 0.0 { 1.0 / substep } else { 0.0 };
        let still = finite(wind.velocity).extend(0.0);
        let motion = |p: &Vec4, q: &Vec4| (*p - *q) * rate;
        let intensity = intensity_of(wind);
        let pairs = positions.iter().zip(previous);
        if intensity <= 0.0 && wind.zones.is_empty() {
            relative.extend(pairs.map(|(p, q)| still - motion(p, q)));
        } else if wind.zones.is_empty() {
            let strength = intensity * still.length();
            let modes = self.modes_of(&wind.turbulence);
            let now = modes.now(wind);
            relative.extend(pairs.map(|(p, q)| {
                let gust = modes.at(&now, Vec3A::from_vec4(*p)) * strength;
                still + gust.extend(0.0) - motion(p, q)
            }));
        } else {
            let modes = self.modes_of(&wind.turbulence);
            let now = modes.now(wind);
            relative.extend(pairs.map(|(p, q)| {
                let mean = wind.mean_at(p.truncate());
                let strength = intensity * mean.length();
                let gust = if strength > 0.0 { modes.at(&now, Vec3A::from_vec4(*p)) * strength } else { Vec3A::ZERO };
                mean.extend(0.0) + gust.extend(0.0) - motion(p, q)
            }));
        }
        self.relative = relative;
    }
}

fn coefficient(c: f32) -> f32 {
    if c.is_finite() { c.clamp(0.0, 10.0) } else { 0.0 }
}
