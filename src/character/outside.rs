//! What of a body sticks out of its colliders.

use super::spread::percentile;

/// How far vertices stick out of colliders `[m]`: those inside count as 0, margins do not count.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outside {
    /// Half of the vertices stick out by no more than this `[m]`.
    pub p50: f32,
    /// 90 % of the vertices stick out by no more than this `[m]`.
    pub p90: f32,
    /// 95 % of the vertices stick out by no more than this `[m]`.
    pub p95: f32,
    /// The vertex that sticks out most `[m]`.
    pub max: f32,
}

impl Outside {
    /// From how far each vertex sticks out `[m]`; 0 of none.
    pub(super) fn of(mut distances: Vec<f32>) -> Self {
        let mut at = |share| percentile(&mut distances, share);
        Self { p50: at(0.5), p90: at(0.9), p95: at(0.95), max: at(1.0) }
    }
}
