//! Skinned constraints: cloth that follows the animated skin of a character, within limits.
//!
//! ```text
//! drive     x ← x* + (ω²h² (q - x*) + 2ζωh (x + u - x*)) / (1 + 2ζωh + ω²h²)   implicit Euler; x* predicted, u what q moved by
//! backstop  c = q - n (b + R);   |x - c| < R:  x ← c + R (x - c)/|x - c|
//! distance  Δ = x - q;           |Δ| > d:      x ← q + d Δ/|Δ|                    last, so that it has the last word
//! draw      x, x₀ ← + Δ, at most v h + |u|     of what a bone goes through, before forces act and without speed; v: 2 m/s
//! ```
//!
//! `q` and `n` are the place and the normal that the skin gives a particle. They move within the frame, so that no substep sees
//! a jump. Limits act on positions before speeds are taken, so that what they stop has no speed outwards. The names are those
//! of Jolt's skinned constraints.

mod avoid;
mod drive;
mod limit;
mod tangled;

use glam::Vec3;

pub(in crate::solver) use avoid::FASTEST;
pub use avoid::{AvoidBuffers, Surroundings};
pub use tangled::TangledLimits;

/// Below this maximum distance a particle is as good as pinned `[m]`.
pub(crate) const PINNED: f32 = 1.0e-3;

/// Where the skin wants the particles of one cloth in a frame, and how far they may be from there.
///
/// Arrays of targets hold one entry per particle. Those of limits do, too, or none where nothing has that limit.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Skinned {
    /// Targets `[m]`, in the frame of simulation, at the start and at the end of the frame.
    pub from: Vec<Vec3>,
    /// See [`Self::from`].
    pub to: Vec<Vec3>,
    /// Unit normals of the skin at the start and at the end of the frame; zero where it has none. Empty without a backstop.
    pub normals_from: Vec<Vec3>,
    /// See [`Self::normals_from`].
    pub normals_to: Vec<Vec3>,
    /// Farthest distance from the target `[m]`; infinite: none.
    pub max_distance: Vec<f32>,
    /// How far behind the target, against the normal, the surface of the backstop lies `[m]`; infinite: none. Off where it is
    /// no less than the maximum distance.
    pub backstop_distance: Vec<f32>,
    /// Radius of the ball behind each particle `[m]`.
    pub backstop_radius: f32,
    /// What maximum distances are multiplied by (dimensionless). Below 1 a particle without one has [`Self::radius`].
    pub scale: f32,
    /// Radius of the ball around the cloth at rest `[m]`.
    pub radius: f32,
    /// Frequency of the spring to the target `[Hz]`; 0: none.
    pub frequency: Vec<f32>,
    /// Damping of that spring over critical damping (dimensionless).
    pub damping_ratio: f32,
    /// Where the skin itself is at the end of the frame, and from there to the targets `[m]`, while they are taken out of
    /// bodies.
    pub(super) skin: Vec<Vec3>,
    pub(super) way_out: Vec<Vec3>,
}

impl Skinned {
    /// Nothing that is asked of a cloth of that radius `[m]`.
    #[must_use]
    pub(crate) fn of_radius(radius: f32) -> Self {
        Self { backstop_radius: 1.0, scale: 1.0, radius, damping_ratio: 1.0, ..Self::default() }
    }

    /// Whether it does anything.
    #[must_use]
    pub fn is_active(&self) -> bool {
        !(self.max_distance.is_empty() && self.backstop_distance.is_empty() && self.frequency.is_empty() && self.scale >= 1.0)
    }

    /// Farthest distance of particle `i` from its target `[m]`; infinite where there is no limit.
    #[must_use]
    pub fn distance(&self, i: usize) -> f32 {
        match self.max_distance.get(i) {
            Some(&distance) if distance.is_finite() => distance * self.scale,
            _ if self.scale < 1.0 => self.radius * self.scale,
            _ => f32::INFINITY,
        }
    }

    /// Target of particle `i` `[m]` when the share `s` of the frame has passed.
    #[must_use]
    pub fn target(&self, i: usize, s: f32) -> Vec3 {
        self.from[i].lerp(self.to[i], s)
    }

    /// Speed `[m/s]` of the target that moves fastest against the mean of all, in a frame of `dt` `[s]`.
    #[must_use]
    pub fn fastest(&self, dt: f32) -> f32 {
        let mean = self.ways().sum::<Vec3>() / self.to.len().max(1) as f32;
        self.ways().map(|way| way.distance_squared(mean)).fold(0.0, f32::max).sqrt() / dt
    }

    /// The way of each target in the frame `[m]`.
    fn ways(&self) -> impl Iterator<Item = Vec3> + '_ {
        self.from.iter().zip(&self.to).map(|(from, to)| *to - *from)
    }

    /// Longest way of a target in the frame `[m]`.
    pub(super) fn longest_way(&self) -> f32 {
        if !self.is_active() {
            return 0.0;
        }
        self.ways().map(Vec3::length_squared).fold(0.0, f32::max).sqrt()
    }

    /// Whether there is a target for each of `count` particles.
    pub(super) fn fits(&self, count: usize) -> bool {
        self.from.len() == count && self.to.len() == count
    }
}
