//! How the points of a group are spread: percentiles, principal axes.
//!
//! ```text
//!   C = Σ (p - p̄)(p - p̄)ᵀ / n        C eᵢ = σᵢ² eᵢ,   σ₁ ≥ σ₂ ≥ σ₃
//! ```

use glam::{Mat3, Vec3};
use parry3d::utils::{SymmetricEigen3, center_cov};

/// Principal axes of points.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spread {
    /// Unit vectors, from the longest to the shortest extent.
    pub axes: [Vec3; 3],
    /// Standard deviation along each `[m]`.
    pub sigmas: [f32; 3],
}

impl Spread {
    /// None for points that all lie in one place.
    pub(super) fn of(points: &[Vec3]) -> Option<Self> {
        let (_, covariance) = center_cov(points);
        let trace = covariance.x_axis.x + covariance.y_axis.y + covariance.z_axis.z;
        // Also where the points are none or too far apart to square.
        if !(trace > f32::MIN_POSITIVE && trace.is_finite()) {
            return None;
        }
        // The solver compares with fixed bounds.
        let eigen = SymmetricEigen3::new(covariance * (1.0 / trace)).reverse();
        let Mat3 { x_axis, y_axis, z_axis } = eigen.eigenvectors;
        let axes = [x_axis, y_axis, z_axis];
        if !axes.iter().all(|axis| axis.is_normalized()) {
            return None;
        }
        Some(Self { axes, sigmas: eigen.eigenvalues.to_array().map(|v| (v.max(0.0) * trace).sqrt()) })
    }

    /// Shortest over middle extent, σ₃/σ₂: 1 is round, 0 is flat or a line.
    pub(super) fn flatness(&self) -> f32 {
        let [_, middle, short] = self.sigmas;
        if middle > 0.0 { short / middle } else { 0.0 }
    }
}

/// The value below which `share` of all lie, 0 to 1; changes their order. 0 of none.
pub(super) fn percentile(values: &mut [f32], share: f32) -> f32 {
    let Some(last) = values.len().checked_sub(1) else {
        return 0.0;
    };
    let at = ((share * last as f32).round() as usize).min(last);
    *values.select_nth_unstable_by(at, f32::total_cmp).1
}
