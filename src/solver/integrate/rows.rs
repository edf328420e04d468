//! Four vectors at once, coordinate by coordinate.

use core::ops::{Add, Mul, Sub};

use glam::{Mat4, Vec4};

use crate::solver::rest::LANES;

/// Four vectors: all `x`, all `y`, all `z`.
#[derive(Clone, Copy, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Rows(pub [Vec4; 3]);

impl From<[Vec4; LANES]> for Rows {
    fn from(v: [Vec4; LANES]) -> Self {
        let rows = Mat4::from_cols(v[0], v[1], v[2], v[3]).transpose();
        Self([rows.x_axis, rows.y_axis, rows.z_axis])
    }
}

impl Add for Rows {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k] + other.0[k]))
    }
}

impl Sub for Rows {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k] - other.0[k]))
    }
}

impl Mul<Vec4> for Rows {
    type Output = Self;
    #[inline(always)]
    fn mul(self, by: Vec4) -> Self {
        Self(self.0.map(|row| row * by))
    }
}

impl Rows {
    /// Scalar products.
    #[inline(always)]
    pub(super) fn dot(self, other: Self) -> Vec4 {
        self.0[0] * other.0[0] + self.0[1] * other.0[1] + self.0[2] * other.0[2]
    }

    /// Lengths, never zero, so that they can be divided by.
    #[inline(always)]
    pub(super) fn length(self) -> Vec4 {
        self.dot(self).sqrt().max(Vec4::splat(f32::MIN_POSITIVE))
    }

    /// Vector products.
    #[inline(always)]
    pub(super) fn cross(self, other: Self) -> Self {
        let ([ax, ay, az], [bx, by, bz]) = (self.0, other.0);
        Self([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])
    }

    /// The vectors, one by one, with a `w` of zero.
    #[inline(always)]
    pub(super) fn columns(self) -> [Vec4; LANES] {
        let columns = Mat4::from_cols(self.0[0], self.0[1], self.0[2], Vec4::ZERO).transpose();
        [columns.x_axis, columns.y_axis, columns.z_axis, columns.w_axis]
    }
}
