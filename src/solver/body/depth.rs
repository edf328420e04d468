//! How deep points lie in bodies.

use glam::{Vec3, Vec3A};
use parry3d::bounding_volume::BoundingVolume;

use super::geometry::for_each_geometry;
use super::{Body, motion};

/// How deep each of the `points` `[m]` lies in the deepest of the bodies `[m]`; 0 outside of all. Bodies are where they are at
/// the end of the frame. Margins do not count, and surfaces have no inside.
#[must_use]
pub fn depths(bodies: &[Body], points: &[Vec3]) -> Vec<f32> {
    let (mut depths, mut planes) = (vec![0.0f32; points.len()], Vec::new());
    for body in bodies {
        let Some(pose) = motion::valid(body.to) else { continue };
        for_each_geometry(&*body.shape.0, &mut planes, |_, local, shape, geometry| {
            let at = pose * local;
            let around = shape.compute_aabb(&at).loosened(f32::EPSILON);
            let inside = |point: Vec3| around.mins.cmple(point).all() && around.maxs.cmpge(point).all();
            for (depth, point) in depths.iter_mut().zip(points).filter(|(_, point)| inside(**point)) {
                let sample = geometry.sample(Vec3A::from(at.inverse_transform_point(*point)), 0.0);
                if sample.normal != Vec3A::ZERO {
                    *depth = depth.max(-sample.distance);
                }
            }
        });
    }
    depths
}

#[cfg(test)]
mod tests {
    use parry3d::math::Pose;
    use parry3d::shape::SharedShape;

    use super::*;

    #[test]
    fn a_point_is_as_deep_as_in_the_body_that_it_is_deepest_in() {
        let ball = Body { margin: 0.1, ..Body::at_rest(SharedShape::ball(0.2), Pose::from_translation(Vec3::X)) };
        let capsule = Body::at_rest(SharedShape::capsule_y(0.5, 0.1), Pose::IDENTITY);
        let lost = Body::at_rest(SharedShape::ball(9.0), Pose::from_translation(Vec3::NAN));
        let points = [Vec3::X * 1.05, Vec3::X * 1.25, Vec3::new(0.0, 0.4, 0.03), Vec3::ZERO, Vec3::ONE, Vec3::NAN];
        let found = depths(&[ball, capsule, lost], &points);
        for (found, expected) in found.iter().zip([0.15, 0.0, 0.07, 0.1, 0.0, 0.0]) {
            assert!((found - expected).abs() < 1.0e-6, "{found} for {expected}");
        }
    }
}
