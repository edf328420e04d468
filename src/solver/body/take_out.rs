//! Takes points out of bodies: places that cloth is to go to, where it cannot be.

use glam::{Vec3, Vec3A, Vec4};
use parry3d::bounding_volume::BoundingVolume;

use super::geometry::{for_each_geometry, half_thickness};
use super::{Body, motion};

/// Times that all bodies are gone through: out of one may be into another.
const ROUNDS: u32 = 2;

/// Moves `points` `[m]`, one for each particle of a cloth, out of bodies to the distance `keep` `[m]` on top of their margins.
/// Bodies are where they are at the end of the frame. Points deeper than half of the way to the middle of a body are moved ever
/// less. A point at the middle is not moved: the way out on the other side is as short. `planes` is a buffer.
pub(in crate::solver) fn take_out(bodies: &[Body], keep: f32, points: &mut [Vec3], planes: &mut Vec<Vec4>) {
    for _ in 0..ROUNDS {
        for body in bodies {
            let Some(pose) = motion::valid(body.to) else { continue };
            let keep = keep + body.margin;
            for_each_geometry(&*body.shape.0, planes, |_, local, shape, geometry| {
                let at = pose * local;
                let near = shape.compute_aabb(&at).loosened(keep);
                let inner = half_thickness(shape);
                let is_near = |point: &Vec3| near.mins.cmple(*point).all() && near.maxs.cmpge(*point).all();
                for (i, point) in (0..).zip(&mut *points).filter(|(_, point)| is_near(point)) {
                    let sample = geometry.sample(Vec3A::from(at.inverse_transform_point(*point)), keep);
                    let sample = sample.deeper(body.inset(i, keep));
                    let depth = -sample.distance;
                    if sample.distance >= keep || sample.normal == Vec3A::ZERO {
                        continue;
                    }
                    let share =
                        if inner > 0.0 && inner.is_finite() { (2.0 * (1.0 - depth / inner)).clamp(0.0, 1.0) } else { 1.0 };
                    *point += at.rotation * Vec3::from(sample.normal) * (share * (keep - sample.distance));
                }
            });
        }
    }
}
