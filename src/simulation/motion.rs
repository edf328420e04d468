//! How a carrier moved.

use bevy::math::{Affine3A, DVec3};
use bevy::prelude::*;

/// The rigid motion of a carrier between two frames, in the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion {
    pub from: Isometry3d,
    pub to: Isometry3d,
    /// Middle of what is carried `[m]`, as the carrier sees it: how far that goes is how far it is.
    pub center: Vec3,
}

impl Motion {
    /// Where the middle of what is carried was, and is `[m]`.
    pub(crate) fn middles(&self) -> [Vec3; 2] {
        [&self.from, &self.to].map(|at| Vec3::from(at.translation) + at.rotation * self.center)
    }

    /// How far it went `[m]`.
    pub(crate) fn distance(&self) -> f32 {
        let [from, to] = self.middles();
        from.distance(to)
    }

    /// By how much it turned `[rad]`.
    pub(crate) fn angle(&self) -> f32 {
        self.from.rotation.angle_between(self.to.rotation)
    }

    /// The rotation.
    pub(crate) fn turn(&self) -> Quat {
        self.to.rotation * self.from.rotation.inverse()
    }

    /// The motion of points as seen from `origin` `[m]`.
    pub(crate) fn motion(&self, origin: DVec3) -> impl Fn(Vec3) -> Vec3 + use<> {
        let seen = |at: &Isometry3d| (Vec3::from(at.translation).as_dvec3() - origin).as_vec3();
        let (from, to, turn) = (seen(&self.from), seen(&self.to), self.turn());
        move |x| turn * (x - from) + to
    }

    /// As [`Self::motion`].
    pub(crate) fn affine(&self, origin: DVec3) -> Affine3A {
        Affine3A::from_rotation_translation(self.turn(), self.motion(origin)(Vec3::ZERO))
    }

    /// Where something at `at` goes that is carried along.
    pub(crate) fn moved(&self, at: Isometry3d) -> Isometry3d {
        let turn = self.turn();
        let translation =
            turn * (Vec3::from(at.translation) - Vec3::from(self.from.translation)) + Vec3::from(self.to.translation);
        Isometry3d::new(translation, (turn * at.rotation).normalize())
    }

    /// Where it is after the share `linear` of its way and `angular` of its turn (dimensionless, 0 to 1).
    pub(crate) fn partly(&self, linear: f32, angular: f32) -> Isometry3d {
        let [from, to] = self.middles();
        let rotation = self.from.rotation.slerp(self.to.rotation, angular);
        Isometry3d::new(from.lerp(to, linear) - rotation * self.center, rotation)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_of_a_motion_turns_about_the_middle_of_what_is_carried() {
        let from = Isometry3d::new(Vec3::new(1.0, 2.0, 3.0), Quat::IDENTITY);
        let to = Isometry3d::new(Vec3::new(1.0, 2.0, 3.0), Quat::from_rotation_y(1.0));
        let jump = Motion { from, to, center: Vec3::X };
        let half = Motion { to: jump.partly(0.0, 0.5), ..jump };
        assert!(half.distance() < 1.0e-6, "{}", half.distance());
        assert!((half.angle() - 0.5).abs() < 1.0e-5, "{}", half.angle());
        let whole = jump.partly(1.0, 1.0);
        assert!(Vec3::from(whole.translation).distance(Vec3::from(to.translation)) < 1.0e-6);
    }

    #[test]
    fn points_and_poses_go_the_same_way() {
        let from = Isometry3d::new(Vec3::new(1.0, 0.0, 0.0), Quat::from_rotation_x(0.3));
        let to = Isometry3d::new(Vec3::new(4.0, 1.0, -2.0), Quat::from_rotation_y(1.0));
        let jump = Motion { from, to, center: Vec3::ZERO };
        let point = Vec3::new(0.3, -0.7, 0.9);
        let pose = jump.moved(Isometry3d::from_translation(point));
        let origin = DVec3::new(1.0, 1.0, 1.0);
        let moved = jump.motion(origin)(point - Vec3::ONE) + Vec3::ONE;
        assert!(moved.distance(Vec3::from(pose.translation)) < 1.0e-5, "{moved}");
    }
}
