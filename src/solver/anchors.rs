//! Particles that pins hold.

use glam::Vec3;

/// A pin of at least this weight is rigid (dimensionless).
pub(crate) const RIGID: f32 = 0.999;

/// Particles that are held, and where.
///
/// Targets are in the frame of simulation and interpolated over the substeps of a frame. `from` and `to` are kept by the
/// caller: each frame's `from` is the last frame's `to`.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Anchors {
    /// Held particles, sorted, each once.
    pub particles: Vec<u32>,
    /// How firmly each is held: 1 = rigidly (infinite mass), towards 0 = hardly. Same length as `particles`.
    pub weights: Vec<f32>,
    /// Target at the start of the frame `[m]`.
    pub from: Vec<Vec3>,
    /// Target at the end of the frame `[m]`.
    pub to: Vec<Vec3>,
}

impl Anchors {
    /// Longest way of a target in the frame `[m]`.
    pub(super) fn longest_way(&self) -> f32 {
        self.from.iter().zip(&self.to).map(|(a, b)| a.distance_squared(*b)).fold(0.0, f32::max).sqrt()
    }
}
