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
//! *Field.* A sum of random Fourier modes (Kraichnan 1970), each divergence-free because its amplitude is across its wave vector; wave numbers in
//! a geometric row with `|a| ∝ k^(-1/3)`, which is Kolmogorov's `E(k) ∝ k^(-5/3)`. The mean wind carries the eddies along (Taylor 1938,
//! frozen turbulence) while `ω_n ∝ k^(2/3)` lets them age.
//!
//! *Force.* A flat plate as in Wejchert & Haumann 1991, with drag and lift apart: drag along the wind on the projected area `A c / |v|`, lift across
//! it in the plane of wind and normal, both with `½ ρ |v|²`. `C_D` is 1.17 for a square plate across the wind (Hoerner 1965).
//!
//! *Stability.* The force is held for `hold` seconds, in which an explicit `½ ρ C A v² hold` may exceed `m v` many times (at 60 m/s and 0.1
//! kg/m²: four times). Explicitly the relative velocity would change by `x v`; divided by `√(1 + x²)` it changes by less than `v`, so that
//! it decays and is never reversed, while a gentle wind (`x < 0.1`) loses less than 0.5 % of its force. (Implicit Euler divides by `1 + x`
//! and loses 10 %.)

use glam::{DVec3, Mat4, Quat, Vec3, Vec3A, Vec4};

use super::rest::LANES;

/// Density of air at 15 °C and sea level `[kg/m³]`.
pub const AIR_DENSITY: f32 = 1.225;

/// Number of modes, two vectors of four. Ratio of neighbouring wave numbers is 1.1³, so that `k^(-1/3)` falls by 1.1.
const MODES: usize = 8;
const RATIO_CBRT: f32 = 1.1;

/// The air as one cloth sees it in one frame.
#[derive(Clone, Debug, PartialEq)]
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

    /// Lets `dt` seconds pass: the eddies age and travel with the mean wind. A change of `velocity` bends their way and does not make them jump.
    pub fn advance(&mut self, dt: f32) {
        if dt.is_finite() {
            self.time += f64::from(dt);
            self.travel += finite(self.velocity).as_dvec3() * f64::from(dt);
        }
    }

    /// Mean velocity with zones at a point of the frame of simulation `[m/s]`.
    #[must_use]
    pub fn mean_at(&self, point: Vec3) -> Vec3 {
        self.zones.iter().fold(finite(self.velocity), |wind, zone| zone.blend(point, wind))
    }

    /// Bound on the speed of the air anywhere `[m/s]`, but for one gust in a thousand: no particle is blown faster than this.
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

/// Gusts: their strength, size and seed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turbulence {
    /// Root mean square of each component of the gusts over the mean wind speed (dimensionless). Default 0; open country 0.15, a city 0.3.
    /// Range 0 to 5.
    pub intensity: f32,
    /// Size of the largest eddies `[m]`. Default 4, range 0.05 to 1000. Much larger than the cloth: the wind swells and fades as a whole;
    /// smaller than its triangles: noise.
    pub length: f32,
    /// How often the largest eddies turn over `[Hz]`, on top of the `speed / length` at which they pass by. Default 0.5, range 0 to 20.
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

/// A place with a wind of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WindZone {
    /// Shape of the zone around its centre.
    pub shape: ZoneShape,
    /// Centre, in the frame of simulation `[m]`.
    pub center: Vec3,
    /// Rotation of the zone.
    pub rotation: Quat,
    /// Velocity of the zone in the axes of the frame of simulation `[m/s]`.
    pub velocity: Vec3,
    /// Distance from the border inwards over which the zone rises to its full strength `[m]`. Default 0.2, range 0 to 1000; 0: a hard edge.
    pub falloff: f32,
    /// Whether the zone's wind adds to the wind around it or takes its place.
    pub mode: ZoneMode,
}

impl Default for WindZone {
    fn default() -> Self {
        Self {
            shape: ZoneShape::Sphere { radius: 1.0 },
            center: Vec3::ZERO,
            rotation: Quat::IDENTITY,
            velocity: Vec3::ZERO,
            falloff: 0.2,
            mode: ZoneMode::Add,
        }
    }
}

/// Shape of a [`WindZone`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ZoneShape {
    /// A ball `[m]`.
    Sphere {
        /// Radius `[m]`.
        radius: f32,
    },
    /// A box `[m]`.
    Box {
        /// Half of its sizes along its own axes `[m]`.
        half_extents: Vec3,
    },
}

/// How a zone's wind meets the wind around it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ZoneMode {
    /// Velocities add: a fan.
    #[default]
    Add,
    /// The zone's velocity takes the place of the wind: a shelter, a tunnel.
    Replace,
}

impl WindZone {
    /// 0 outside the shape, 1 deeper inside than the falloff, smooth between.
    #[must_use]
    pub fn weight(&self, point: Vec3) -> f32 {
        let q = point - self.center;
        let distance = match self.shape {
            ZoneShape::Sphere { radius } => q.length() - radius,
            ZoneShape::Box { half_extents } => ((self.rotation.inverse() * q).abs() - half_extents).max_element(),
        };
        // False for a distance that is not a number.
        if distance <= -self.falloff {
            1.0
        } else if distance < 0.0 {
            let t = -distance / self.falloff;
            t * t * (3.0 - 2.0 * t)
        } else {
            0.0
        }
    }

    fn blend(&self, point: Vec3, wind: Vec3) -> Vec3 {
        let weight = self.weight(point);
        let own = finite(self.velocity);
        match self.mode {
            ZoneMode::Add => wind + own * weight,
            ZoneMode::Replace => wind.lerp(own, weight),
        }
    }
}

/// How a fabric takes the wind.
#[derive(Clone, Copy, Debug, PartialEq)]
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

/// The modes of a turbulence, made once per seed and length.
#[derive(Clone, Debug, PartialEq)]
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

    fn fits(&self, turbulence: &Turbulence) -> bool {
        self.made_for == (turbulence.seed, length_of(turbulence).to_bits())
    }

    /// Phases at the origin of the frame now `[turns]`, reduced in double precision: exact at any distance and time.
    fn now(&self, wind: &Wind) -> [Vec4; MODES / 4] {
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
    fn at(&self, now: &[Vec4; MODES / 4], point: Vec3A) -> Vec3A {
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

/// Forces of the wind on one cloth. Buffers are reused: nothing is allocated once they are warm.
#[derive(Clone, Debug, Default)]
pub struct WindForces {
    modes: Option<Modes>,
    /// Wind relative to each particle `[m/s]`.
    relative: Vec<Vec4>,
    /// `xyz` force `[N]`, `w` coefficient of drag `|F| / |v|` `[kg/s]` of each particle.
    forces: Vec<Vec4>,
}

impl WindForces {
    /// Velocity of the air at a point of the frame of simulation `[m/s]`, gusts and zones included.
    pub fn velocity_at(&mut self, wind: &Wind, point: Vec3) -> Vec3 {
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
    /// `positions`: `w` = inverse mass `[1/kg]`, particles with 0 get nothing. `substep`: time between `previous` and `positions` `[s]`, 0 or
    /// less when the cloth is at rest. `hold`: how long the accelerations will be used before the next call `[s]`. Faces with an index past
    /// the end: no force.
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

/// What a triangle does with the wind.
#[derive(Clone, Copy)]
struct Plate {
    /// `ρ / 12`: ½ of the dynamic pressure, ½ of the cross product, ⅓ for each corner `[kg/m³]`.
    share: f32,
    drag: f32,
    lift: f32,
}

impl Plate {
    /// Adds the forces on four triangles to their corners.
    #[inline(always)]
    fn press(self, faces: &[[u32; 3]; LANES], positions: &[Vec4], relative: &[Vec4], forces: &mut [Vec4]) {
        let corner = |k: usize| -> [Vec4; LANES] { std::array::from_fn(|lane| positions[faces[lane][k] as usize]) };
        let wind = std::array::from_fn(|lane| {
            let [a, b, c] = faces[lane].map(|i| relative[i as usize]);
            (a + b + c) * (1.0 / 3.0)
        });
        let force = self.forces(corner(0), corner(1), corner(2), wind);
        for (face, force) in faces.iter().zip(force) {
            for &i in face {
                forces[i as usize] += force;
            }
        }
    }

    /// `F / 3` of four triangles `a b c` in the relative wind `v`, with a bound on `|F| / (3 |v|)` in the fourth lane.
    ///
    /// With `N` twice the area along the normal, `c = |N · v|` and `cos θ = c / (|N| |v|)`:
    ///
    /// ```text
    /// F = ½ρ ½c (v (C_D - C_L cos θ) ± N C_L |v| / |N|)        |F| <= ½ρ ½c |v| (C_D + C_L sin² θ)
    /// ```
    #[inline]
    fn forces(self, a: [Vec4; LANES], b: [Vec4; LANES], c: [Vec4; LANES], wind: [Vec4; LANES]) -> [Vec4; LANES] {
        let e: Rows = rows(std::array::from_fn(|lane| b[lane] - a[lane]));
        let f: Rows = rows(std::array::from_fn(|lane| c[lane] - a[lane]));
        let v: Rows = rows(wind);
        let normal = [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]];
        let (area2, speed2, across) = (dot(normal, normal), dot(v, v), dot(normal, v));
        // False for what is not a number. The upper bounds are far beyond sound and keep the products finite.
        let acts = area2.cmpgt(Vec4::splat(1.0e-24))
            & speed2.cmpgt(Vec4::splat(1.0e-12))
            & area2.cmplt(Vec4::splat(1.0e12))
            & speed2.cmplt(Vec4::splat(1.0e8));
        let inverse = (area2 * speed2).sqrt().recip();
        let cosine = across.abs() * inverse;
        let pressure = across.abs() * self.share;
        let along = pressure * (Vec4::splat(self.drag) - cosine * self.lift);
        // The side of the normal away from the wind: the sign of `across` times `|across|` is `across`.
        let lee = across * (speed2 * inverse) * (self.share * self.lift);
        let strength = pressure * (Vec4::splat(self.drag + self.lift) - cosine * cosine * self.lift);
        let [x, y, z] = std::array::from_fn(|axis| v[axis] * along + normal[axis] * lee);
        let force = [x, y, z, strength].map(|row| Vec4::select(acts, row, Vec4::ZERO));
        let m = Mat4::from_cols(force[0], force[1], force[2], force[3]).transpose();
        [m.x_axis, m.y_axis, m.z_axis, m.w_axis]
    }
}

/// Components of four vectors, each in one register.
type Rows = [Vec4; 3];

#[inline]
fn rows(v: [Vec4; LANES]) -> Rows {
    let m = Mat4::from_cols(v[0], v[1], v[2], v[3]).transpose();
    [m.x_axis, m.y_axis, m.z_axis]
}

#[inline]
fn dot(a: Rows, b: Rows) -> Vec4 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
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

fn finite(v: Vec3) -> Vec3 {
    if v.is_finite() { v.clamp_length_max(1.0e4) } else { Vec3::ZERO }
}

fn coefficient(c: f32) -> f32 {
    if c.is_finite() { c.clamp(0.0, 10.0) } else { 0.0 }
}

fn intensity_of(wind: &Wind) -> f32 {
    if wind.turbulence.intensity.is_finite() { wind.turbulence.intensity.clamp(0.0, 5.0) } else { 0.0 }
}

fn length_of(turbulence: &Turbulence) -> f32 {
    if turbulence.length.is_finite() { turbulence.length.clamp(0.05, 1000.0) } else { Turbulence::NONE.length }
}

#[cfg(test)]
mod tests {
    use super::*;

    const H: f32 = 1.0 / 480.0;

    /// A sheet of `n x n` particles of 1 m² in the plane across `up`, and its faces.
    fn sheet(n: usize, density: f32, velocity: Vec3) -> (Vec<Vec4>, Vec<Vec4>, Vec<[u32; 3]>) {
        let (mut positions, mut faces) = (Vec::new(), Vec::new());
        for i in 0..n {
            for j in 0..n {
                positions.push(Vec4::new(i as f32, 0.0, j as f32, 0.0) / (n - 1) as f32);
            }
        }
        let mut mass = vec![0.0_f32; n * n];
        for i in 0..n - 1 {
            for j in 0..n - 1 {
                let a = (i * n + j) as u32;
                let b = a + n as u32;
                for face in [[a, a + 1, b], [b, a + 1, b + 1]] {
                    faces.push(face);
                    for corner in face {
                        mass[corner as usize] += density / (6.0 * ((n - 1) * (n - 1)) as f32);
                    }
                }
            }
        }
        for (p, m) in positions.iter_mut().zip(mass) {
            p.w = 1.0 / m;
        }
        let previous = positions.iter().map(|p| (p.truncate() - velocity * H).extend(0.0)).collect();
        (positions, previous, faces)
    }

    /// Mean force on the sheet `[N]`.
    fn force(wind: &Wind, fabric: Aerodynamics, velocity: Vec3) -> Vec3 {
        let (positions, previous, faces) = sheet(9, 0.2, velocity);
        let mut acc = vec![Vec4::ZERO; positions.len()];
        WindForces::default().apply(wind, fabric, &faces, &positions, &previous, H, 0.0, &mut acc);
        acc.iter().zip(&positions).map(|(a, p)| a.truncate() / p.w).sum()
    }

    fn steady(velocity: Vec3) -> Wind {
        Wind { velocity, ..Wind::STILL }
    }

    #[test]
    fn the_force_is_that_of_a_plate_and_grows_with_the_square_of_the_relative_speed() {
        let plate = Aerodynamics { drag: 1.2, lift: 0.6 };
        let at = |v: Vec3| force(&steady(v), plate, Vec3::ZERO);
        let theory = 0.5 * 1.225 * 1.2 * 25.0;
        let across = at(Vec3::Y * 5.0);
        assert!((across - Vec3::Y * theory).length() < 1.0e-3 * theory, "{across} N, theory {theory} N");
        let twice = at(Vec3::Y * 10.0);
        assert!((twice.y / across.y - 4.0).abs() < 1.0e-3, "twice the speed: {} times the force", twice.y / across.y);
        let moving = force(&steady(Vec3::Y * 2.0), plate, Vec3::Y * -3.0);
        assert!((moving - across).length() < 1.0e-2, "only the relative speed counts: {moving} and {across}");
        // At 45 degrees: drag ½ρ C_D A v² cos, lift ½ρ C_L A v² cos sin across the wind.
        let slanted = at(Vec3::new(5.0, 5.0, 0.0) / 2.0_f32.sqrt());
        let along = Vec3::new(1.0, 1.0, 0.0).normalize();
        let (drag, lift) = (slanted.dot(along), slanted.dot(Vec3::new(-1.0, 1.0, 0.0).normalize()));
        let pressure = 0.5 * 1.225 * 25.0;
        assert!((drag - pressure * 1.2 * 0.5_f32.sqrt()).abs() < 1.0e-2, "drag {drag}");
        assert!((lift - pressure * 0.6 * 0.5).abs() < 1.0e-2, "lift {lift}");
        assert!(at(Vec3::X * 5.0).length() < 1.0e-6, "wind along the sheet");
    }

    #[test]
    fn still_air_slows_cloth_and_no_air_does_not() {
        let drag = force(&Wind::STILL, Aerodynamics::default(), Vec3::Y * -3.0);
        assert!(drag.y > 1.0, "{drag}");
        assert_eq!(force(&Wind::NONE, Aerodynamics::default(), Vec3::Y * -3.0), Vec3::ZERO);
    }

    /// Speed after `seconds` of a sheet that moves as a whole.
    fn run(wind: &Wind, density: f32, gravity: f32, hold_steps: u32, seconds: f32, mut each: impl FnMut(f32)) -> f32 {
        let (mut positions, mut previous, faces) = sheet(5, density, Vec3::ZERO);
        let mut forces = WindForces::default();
        let mut acc = vec![Vec4::ZERO; positions.len()];
        let steps = (seconds / H) as u32;
        let mut speed = 0.0;
        for step in 0..steps {
            if step % hold_steps == 0 {
                acc.fill(Vec4::ZERO);
                forces.apply(wind, Aerodynamics::default(), &faces, &positions, &previous, H, hold_steps as f32 * H, &mut acc);
            }
            for ((x, prev), a) in positions.iter_mut().zip(&mut previous).zip(&acc) {
                let next = *x + (*x - *prev).truncate().extend(0.0) + (*a + Vec4::Y * -gravity) * (H * H);
                *prev = *x;
                *x = next;
            }
            speed = (positions[7] - previous[7]).y / H;
            each(speed);
        }
        speed
    }

    #[test]
    fn a_falling_sheet_reaches_its_terminal_velocity() {
        for density in [0.1_f32, 0.3, 1.0] {
            let theory = (2.0 * density * 9.81 / (1.225 * 1.2)).sqrt();
            let speed = -run(&Wind::STILL, density, 9.81, 4, 5.0, |_| {});
            assert!((speed / theory - 1.0).abs() < 0.01, "{density} kg/m²: {speed} m/s, theory {theory} m/s");
        }
    }

    #[test]
    fn a_storm_of_60_metres_per_second_never_throws_light_cloth_faster_than_itself() {
        for hold in [1, 4, 8, 48] {
            let mut fastest = 0.0_f32;
            let end = run(&steady(Vec3::Y * 60.0), 0.1, 0.0, hold, 1.0, |v| fastest = fastest.max(v));
            assert!(fastest < 60.2 && end > 55.0, "held {hold} substeps: up to {fastest} m/s, at the end {end} m/s");
        }
    }

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

    #[test]
    fn zones_add_or_replace_and_fade_at_their_border() {
        let zone =
            WindZone { velocity: Vec3::Y * 4.0, shape: ZoneShape::Box { half_extents: Vec3::ONE }, ..WindZone::default() };
        let mut wind = Wind { velocity: Vec3::X, zones: vec![zone], ..Wind::STILL };
        assert_eq!(wind.mean_at(Vec3::ZERO), Vec3::new(1.0, 4.0, 0.0));
        assert_eq!(wind.mean_at(Vec3::X * 1.01), Vec3::X);
        let half = wind.mean_at(Vec3::X * 0.9);
        assert!((half.y - 2.0).abs() < 1.0e-4, "{half} halfway through the border");
        wind.zones[0].mode = ZoneMode::Replace;
        assert_eq!(wind.mean_at(Vec3::ZERO), Vec3::Y * 4.0);
        wind.zones[0].shape = ZoneShape::Sphere { radius: 1.0 };
        assert_eq!(wind.mean_at(Vec3::splat(0.9)), Vec3::X);
    }

    #[test]
    fn bad_numbers_give_no_force_and_no_panic() {
        let (mut positions, previous, faces) = sheet(4, 0.2, Vec3::ZERO);
        positions[3] = Vec4::new(f32::NAN, 0.0, f32::INFINITY, 1.0);
        positions[0].w = 0.0;
        let mut acc = vec![Vec4::ZERO; positions.len()];
        for velocity in [Vec3::splat(f32::NAN), Vec3::splat(f32::MAX), Vec3::Y * 20.0] {
            let mut wind = Wind { velocity, turbulence: Turbulence { intensity: f32::NAN, ..Turbulence::NONE }, ..Wind::STILL };
            wind.advance(0.1);
            WindForces::default().apply(&wind, Aerodynamics::default(), &faces, &positions, &previous, H, H, &mut acc);
            let past_the_end = [faces[0], [0, 1, 999]];
            let mut none = vec![Vec4::ZERO; positions.len()];
            let plate = Aerodynamics::default();
            WindForces::default().apply(&wind, plate, &past_the_end, &positions, &previous, H, H, &mut none);
            assert!(none.iter().all(|a| *a == Vec4::ZERO), "{none:?}");
        }
        assert!(acc.iter().all(|a| a.is_finite()), "{acc:?}");
        assert_eq!(acc[0], Vec4::ZERO, "a pinned particle was accelerated");
        assert!(acc[5].y > 0.0, "{}", acc[5]);
    }
}
