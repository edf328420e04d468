//! A transform taken apart: where the cloth is, and the scale that its rest shape bakes in.

use bevy::math::{Affine3A, DVec3, Mat3};
use bevy::prelude::*;

/// Relative change of scale that makes a new rest shape (dimensionless). Rounding of a turning transform stays below.
const SCALE_TOLERANCE: f32 = 1.0e-4;
/// Farthest from the origin along an axis `[m]`: transforms there are rounded to a metre.
const FARTHEST: f32 = 1.0e7;
/// Scales are rounded to this many bits, so that equal transforms share one rest shape.
const SCALE_BITS: i32 = 16;

/// `matrix = rotation * bake`, `point = rotation * (bake * p) + translation`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Placement {
    pub rotation: Quat,
    pub translation: Vec3,
    /// Scale and shear.
    pub bake: Mat3,
}

impl Default for Placement {
    fn default() -> Self {
        Self { rotation: Quat::IDENTITY, translation: Vec3::ZERO, bake: Mat3::IDENTITY }
    }
}

impl Placement {
    /// None if a number is not finite, it is [too far](FARTHEST) from the origin, or an axis has no length.
    pub(crate) fn of(affine: &Affine3A) -> Option<Self> {
        let matrix = Mat3::from(affine.matrix3);
        if !affine.is_finite() || affine.translation.abs().max_element() > FARTHEST {
            return None;
        }
        let lengths = Vec3::new(matrix.x_axis.length(), matrix.y_axis.length(), matrix.z_axis.length());
        let volume = matrix.determinant().abs();
        if !(lengths.min_element() > 1.0e-6 && volume > 1.0e-6 * lengths.element_product()) {
            return None;
        }
        let (_, rotation, _) = affine.to_scale_rotation_translation();
        let rotation = rotation.normalize();
        let bake = round(Mat3::from_quat(rotation).transpose() * matrix);
        bake.is_finite().then_some(Self { rotation, translation: affine.translation.into(), bake })
    }

    /// Whether a rest shape made for `bake` still fits.
    pub(crate) fn fits(&self, bake: &Mat3) -> bool {
        let size = bake.to_cols_array().into_iter().map(f32::abs).fold(0.0, f32::max);
        self.bake.abs_diff_eq(*bake, SCALE_TOLERANCE * size)
    }

    /// Rotation and translation as they are seen from `origin`.
    pub(crate) fn in_frame(&self, origin: DVec3) -> Affine3A {
        Affine3A::from_rotation_translation(self.rotation, self.translation_from(origin))
    }

    /// Translation as it is seen from `origin` `[m]`.
    pub(crate) fn translation_from(&self, origin: DVec3) -> Vec3 {
        (self.translation.as_dvec3() - origin).as_vec3()
    }

    /// Rotation and translation.
    pub(crate) fn isometry(&self) -> Isometry3d {
        Isometry3d::new(self.translation, self.rotation)
    }
}

/// Whether all numbers of a transform are finite, and none is [farther](FARTHEST) from zero than places may be.
pub(crate) fn is_near(affine: &Affine3A) -> bool {
    affine.is_finite() && affine.to_cols_array().iter().all(|x| x.abs() <= FARTHEST)
}

/// An affine transform as it is seen from `origin`.
pub(crate) fn seen_from(affine: &Affine3A, origin: DVec3) -> Affine3A {
    let translation = Vec3::from(affine.translation).as_dvec3() - origin;
    Affine3A { matrix3: affine.matrix3, translation: translation.as_vec3().into() }
}

/// How many times as large one baked scale is as another, if it is a multiple of it.
pub(crate) fn multiple(bake: &Mat3, of: &Mat3) -> Option<f32> {
    let times = uniform_scale(bake) / uniform_scale(of);
    let size = bake.to_cols_array().into_iter().map(f32::abs).fold(0.0, f32::max);
    (times.is_finite() && times > 0.0 && bake.abs_diff_eq(*of * times, SCALE_TOLERANCE * size)).then_some(times)
}

/// Uniform scale of a matrix: the cube root of its volume.
pub(crate) fn uniform_scale(matrix: &Mat3) -> f32 {
    matrix.determinant().abs().cbrt()
}

fn round(matrix: Mat3) -> Mat3 {
    let size = matrix.to_cols_array().into_iter().map(f32::abs).fold(0.0, f32::max);
    let step = (size.log2().floor() - SCALE_BITS as f32).exp2();
    Mat3::from_cols_array(&matrix.to_cols_array().map(|x| (x / step).round() * step))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn placement(transform: Transform) -> Option<Placement> {
        Placement::of(&transform.compute_affine())
    }

    #[test]
    fn turning_and_moving_leave_the_baked_scale_as_it_is() {
        let scale = Vec3::new(0.3, 2.0, 1.7);
        let still = placement(Transform::from_scale(scale)).expect("a good transform");
        for i in 0..200 {
            let turn = Quat::from_euler(EulerRot::XYZ, i as f32, 0.3 * i as f32, -1.1 * i as f32);
            let moved = Transform { translation: Vec3::splat(1.0e4), rotation: turn, scale };
            let moved = placement(moved).expect("a good transform");
            assert!(moved.fits(&still.bake), "turn {i}: {:?} against {:?}", moved.bake, still.bake);
        }
    }

    #[test]
    fn a_mirrored_scale_keeps_its_sign_and_a_flat_or_broken_one_is_refused() {
        let mirrored = placement(Transform::from_scale(Vec3::new(1.0, -1.0, 1.0))).expect("a good transform");
        assert!(mirrored.bake.determinant() < 0.0);
        assert!(placement(Transform::from_scale(Vec3::new(1.0, 0.0, 1.0))).is_none());
        assert!(placement(Transform::from_scale(Vec3::splat(f32::NAN))).is_none());
        assert!(placement(Transform::from_xyz(f32::INFINITY, 0.0, 0.0)).is_none());
    }

    #[test]
    fn rotation_times_baked_scale_is_the_transform() {
        let t = Transform { translation: Vec3::ONE, rotation: Quat::from_rotation_y(1.0), scale: Vec3::new(-2.0, 0.5, 3.0) };
        let p = placement(t).expect("a good transform");
        let at = Vec3::new(0.3, -0.7, 0.2);
        let got = p.rotation * (p.bake * at) + p.translation;
        assert!(got.abs_diff_eq(t.transform_point(at), 1.0e-4), "{got} against {}", t.transform_point(at));
    }
}
