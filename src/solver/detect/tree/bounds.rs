//! Axis-aligned boxes, of points and of unit normals.

use glam::Vec3A;

use crate::solver::scales::ALIGNED;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Bounds {
    /// Smallest corner `[m]`.
    pub min: Vec3A,
    /// Largest corner `[m]`.
    pub max: Vec3A,
}

impl Bounds {
    /// The box that meets nothing, not even itself.
    pub const EMPTY: Self = Self { min: Vec3A::INFINITY, max: Vec3A::NEG_INFINITY };

    /// The box of all unit normals.
    pub(super) const ALL_NORMALS: Self = Self { min: Vec3A::NEG_ONE, max: Vec3A::ONE };

    /// The smallest box around both.
    #[inline]
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// For a box of unit normals: whether all lie within 60° of the direction of its centre.
    #[inline]
    pub(super) fn are_flat(&self) -> bool {
        let axis = self.min + self.max;
        let least = (axis * self.min).min(axis * self.max).element_sum();
        least > 0.0 && least * least > ALIGNED * ALIGNED * axis.length_squared()
    }

    /// The smallest box around points.
    #[inline]
    pub(super) fn around(points: impl Iterator<Item = Vec3A>) -> Self {
        points.fold(Self::EMPTY, |sum, x| Self { min: sum.min.min(x), max: sum.max.max(x) })
    }

    /// Whether all of it lies before the plane through the origin across `axis`.
    #[inline]
    pub(super) fn lies_before(&self, axis: Vec3A) -> bool {
        (axis * self.min).min(axis * self.max).element_sum() > 0.0
    }

    /// Whether two boxes come within `margin` `[m]` along every axis; touching counts.
    #[inline]
    #[must_use]
    pub fn meets(&self, other: &Self, margin: Vec3A) -> bool {
        (self.min - margin).cmple(other.max).all() && (other.min - margin).cmple(self.max).all()
    }
}
