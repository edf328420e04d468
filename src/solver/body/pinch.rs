//! Cloth that is pinched between two bones of the character that wears it: an arm against the chest, a thigh against a thigh.
//!
//! No contact can be right there: pushed out of one bone it is in the other, and animation moves both as it likes. Such
//! particles are let be until the bones part (Baraff, Witkin and Kass 2003, "Untangling cloth", call that flypaper).

use glam::{Vec3, Vec3A, Vec4};
use parry3d::bounding_volume::BoundingVolume;

use super::geometry::for_each_geometry;
use super::{Body, motion};
use crate::solver::scales::ALIGNED;

/// Gap between two bones below which cloth is pinched, and below which it stays so, in distances that are kept from a bone
/// (dimensionless).
const PINCHED: f32 = 2.0;
const RELEASED: f32 = 3.0;

/// The particles that are pinched, and buffers to find them.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Pinches {
    /// Sorted.
    particles: Vec<u32>,
    before: Vec<u32>,
    /// Normal of the nearest bone so far and distance to it `[m]`, by particle; infinite: none.
    nearest: Vec<Vec4>,
    planes: Vec<Vec4>,
}

impl Pinches {
    /// The particles that are pinched, sorted.
    #[must_use]
    pub(crate) fn particles(&self) -> &[u32] {
        &self.particles
    }

    /// Finds what is between two bones that leave it no room, as they are at the end of the frame. `thickness` is that of the
    /// fabric `[m]`.
    pub(crate) fn find(&mut self, bodies: &[Body], thickness: f32, positions: &[Vec4]) {
        let Self { particles, before, nearest, planes } = self;
        core::mem::swap(particles, before);
        particles.clear();
        if bodies.iter().filter(|body| body.bone).nth(1).is_none() {
            return;
        }
        nearest.clear();
        nearest.resize(positions.len(), Vec4::INFINITY);
        for body in bodies.iter().filter(|body| body.bone) {
            let Some(pose) = motion::valid(body.to) else { continue };
            let keep = thickness + body.margin;
            for_each_geometry(&*body.shape.0, planes, |_, local, shape, geometry| {
                let at = pose * local;
                let near = shape.compute_aabb(&at).loosened(RELEASED * keep);
                for (i, (x, nearest)) in (0..).zip(positions.iter().zip(&mut *nearest)).filter(|(_, (x, _))| x.w > 0.0) {
                    let x = x.truncate();
                    if !(near.mins.cmple(x).all() && near.maxs.cmpge(x).all()) {
                        continue;
                    }
                    let sample = geometry.sample(Vec3A::from(at.inverse_transform_point(x)), RELEASED * keep);
                    if sample.normal == Vec3A::ZERO {
                        continue;
                    }
                    let normal = at.rotation * Vec3::from(sample.normal);
                    let most = if before.binary_search(&i).is_ok() { RELEASED } else { PINCHED };
                    let distance = sample.distance + body.inset(i, keep);
                    let gap = distance + nearest.w;
                    if gap < most * keep && normal.dot(nearest.truncate()) < -ALIGNED {
                        particles.push(i);
                    }
                    if distance < nearest.w {
                        *nearest = normal.extend(distance);
                    }
                }
            });
        }
        particles.sort_unstable();
        particles.dedup();
    }
}

#[cfg(test)]
mod tests {
    use glam::vec3;

    use super::*;
    use crate::solver::body::{Pose, SharedShape};

    #[test]
    fn what_two_bones_leave_no_room_is_pinched_until_they_part() {
        let bones = |gap: f32| {
            [-0.1, 0.1 + gap].map(|x| {
                let at = Pose::from_parts(vec3(x, 0.0, 0.0), glam::Quat::IDENTITY);
                Body { bone: true, ..Body::at_rest(SharedShape::capsule_y(0.2, 0.1), at) }
            })
        };
        let mut pinches = Pinches::default();
        let mut pinched = |gap: f32| {
            let points = [vec3(0.5 * gap, 0.0, 0.0).extend(1.0), vec3(0.0, 0.0, 0.2).extend(1.0)];
            pinches.find(&bones(gap), 0.01, &points);
            pinches.particles().to_vec()
        };
        assert_eq!(pinched(0.05), [0; 0], "there is room");
        assert_eq!(pinched(0.015), [0]);
        assert_eq!(pinched(-0.02), [0], "they overlap");
        assert_eq!(pinched(0.025), [0], "not yet apart");
        assert_eq!(pinched(0.035), [0; 0]);
        assert_eq!(pinched(0.025), [0; 0]);
        let others = bones(-0.02).map(|body| Body { bone: false, ..body });
        pinches.find(&others, 0.01, &[Vec4::W]);
        assert!(pinches.particles().is_empty(), "what is no bone of the wearer leaves half of the room");
    }
}
