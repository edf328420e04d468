//! Four vectors at once, by axis, so that each operation does all of them. Every lane rounds as [`Vec3A`] does alone.

use glam::{Mat4, Vec3A, Vec4};

/// Lanes of a vector.
pub(crate) const WIDE: usize = 4;

/// Four vectors, one in each lane.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Four {
    pub x: Vec4,
    pub y: Vec4,
    pub z: Vec4,
}

impl Four {
    pub(crate) const ZERO: Self = Self { x: Vec4::ZERO, y: Vec4::ZERO, z: Vec4::ZERO };

    /// One vector in all lanes.
    #[inline(always)]
    pub(crate) fn splat(v: Vec3A) -> Self {
        Self { x: Vec4::splat(v.x), y: Vec4::splat(v.y), z: Vec4::splat(v.z) }
    }

    /// Four vectors, whose `w` does not matter.
    #[inline(always)]
    pub(crate) fn of([a, b, c, d]: [Vec4; WIDE]) -> Self {
        let t = Mat4::from_cols(a, b, c, d).transpose();
        Self { x: t.x_axis, y: t.y_axis, z: t.z_axis }
    }

    #[inline(always)]
    pub(crate) fn dot(self, other: Self) -> Vec4 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline(always)]
    pub(crate) fn length_squared(self) -> Vec4 {
        self.dot(self)
    }

    #[inline(always)]
    pub(crate) fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - other.y * self.z,
            y: self.z * other.x - other.z * self.x,
            z: self.x * other.y - other.x * self.y,
        }
    }

    /// Each vector times a number of its own.
    #[inline(always)]
    pub(crate) fn times(self, by: Vec4) -> Self {
        Self { x: self.x * by, y: self.y * by, z: self.z * by }
    }

    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        Self { x: self.x.max(other.x), y: self.y.max(other.y), z: self.z.max(other.z) }
    }

    #[inline(always)]
    pub(crate) fn abs(self) -> Self {
        Self { x: self.x.abs(), y: self.y.abs(), z: self.z.abs() }
    }
}

impl core::ops::Add for Four {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl core::ops::Sub for Four {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }
}

/// What `of` makes of each lane, or of each of four particles; `map` of an array is not always inlined.
#[inline(always)]
pub(crate) fn each<T>(of: impl Fn(usize) -> T) -> [T; WIDE] {
    [of(0), of(1), of(2), of(3)]
}

/// As [`f32::clamp`] to 0 to 1, signs of zeros and what is not a number included.
#[inline(always)]
pub(crate) fn saturate(v: Vec4) -> Vec4 {
    let v = Vec4::select(v.cmplt(Vec4::ZERO), Vec4::ZERO, v);
    Vec4::select(v.cmpgt(Vec4::ONE), Vec4::ONE, v)
}
