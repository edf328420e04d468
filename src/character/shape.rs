//! The shape of a bone's collider: found in the space of the mesh in metres, given away in the space of the joint.
//!
//! ```text
//!   q = B p / u        r_q = r s / u        s = |det B|^⅓        metres per unit of the joint: u / s
//! ```
//!
//! `B` is the inverse bind matrix, `u` the metres per unit of the mesh.

use glam::{Affine3A, Vec3};

use super::capsule::Capsule;
use super::hull::Hull;

/// The shape of a collider, in the space of its joint and in units of that space.
#[derive(Clone, Debug, PartialEq)]
pub enum BoneShape {
    /// All points within `radius` of the segment from `a` to `b`; `a` equals `b` where it is a ball.
    Capsule {
        /// The end of the segment nearer to the joint.
        a: Vec3,
        /// The other end.
        b: Vec3,
        /// Distance of the surface from the segment.
        radius: f32,
    },
    /// The convex hull of `points`, which span a volume and are all corners of it.
    Hull {
        /// The corners.
        points: Vec<Vec3>,
    },
}

/// A shape in the space of the mesh `[m]`.
pub(super) enum Shape {
    Capsule(Capsule),
    Hull(Hull),
}

impl Shape {
    /// How far a point sticks out `[m]`; 0 inside.
    pub(super) fn outside(&self, point: Vec3) -> f32 {
        match self {
            Self::Capsule(capsule) => capsule.distance(point).max(0.0),
            Self::Hull(hull) => hull.outside(point),
        }
    }

    /// As the joint sees it, with the metres per unit of its space. None where units make a size vanish or overflow.
    pub(super) fn to_joint(&self, bind: &Affine3A, unit: f32) -> Option<(BoneShape, f32)> {
        let joint_unit = unit / scale(bind);
        let seen = |p: Vec3| bind.transform_point3(p / unit);
        let (shape, sound) = match self {
            Self::Capsule(capsule) => {
                let (a, b, radius) = (seen(capsule.a), seen(capsule.b), capsule.radius / joint_unit);
                (BoneShape::Capsule { a, b, radius }, a.is_finite() && b.is_finite() && radius.is_normal())
            }
            Self::Hull(hull) => {
                let points: Vec<Vec3> = hull.corners().iter().map(|&p| seen(p)).collect();
                let sound = points.iter().all(|p| p.is_finite());
                (BoneShape::Hull { points }, sound)
            }
        };
        (sound && joint_unit.is_normal()).then_some((shape, joint_unit))
    }

    /// From what a joint sees; the inverse of [`Self::to_joint`].
    pub(super) fn from_joint(shape: &BoneShape, bind: &Affine3A, unit: f32) -> Option<Self> {
        let bone = inverse(bind)?;
        let place = |p: Vec3| bone.transform_point3(p) * unit;
        match shape {
            &BoneShape::Capsule { a, b, radius } => {
                Some(Self::Capsule(Capsule { a: place(a), b: place(b), radius: radius * unit / scale(bind) }))
            }
            BoneShape::Hull { points } => Hull::of(&points.iter().map(|&p| place(p)).collect::<Vec<_>>()).map(Self::Hull),
        }
    }
}

/// Mean scale of a matrix, the cube root of what it does to volumes.
fn scale(matrix: &Affine3A) -> f32 {
    matrix.matrix3.determinant().abs().cbrt()
}

/// Joint to mesh, where the joint does not flatten what it moves.
pub(super) fn inverse(bind: &Affine3A) -> Option<Affine3A> {
    let sound = bind.is_finite() && bind.matrix3.determinant().is_normal();
    sound.then(|| bind.inverse()).filter(Affine3A::is_finite)
}
