//! Questions about shown cloth: where a ray meets it, and what is nearest to a point.

use std::borrow::Cow;

use bevy::ecs::system::SystemParam;
use bevy::math::{Affine3A, DVec3};
use bevy::prelude::*;

use crate::bind::seen_from;
use crate::components::{Cloth, ClothHit};
use crate::simulation::{ClothInputs, ClothRest, ClothShown};
use crate::solver::raycast::{self, Pick};

/// Asks cloths as they are drawn, held and interpolated shapes included. A cloth that was not drawn yet, cannot be simulated,
/// or has faded into its skin ([`ClothBlend`](crate::ClothBlend)) is not found.
///
/// Every triangle of the cloths whose box is met is asked.
#[derive(SystemParam)]
pub struct ClothQuery<'w, 's> {
    cloths: Query<'w, 's, ShownCloth, With<Cloth>>,
}

type ShownCloth = (Entity, &'static ClothRest, &'static ClothShown, &'static ClothInputs, &'static GlobalTransform);

impl ClothQuery<'_, '_> {
    /// The first point of any cloth that a ray meets within `farthest` `[m]`, from either side.
    #[must_use]
    pub fn cast_ray(&self, ray: Ray3d, farthest: f32) -> Option<ClothHit> {
        self.cast_ray_if(ray, farthest, |_| true)
    }

    /// As [`Self::cast_ray`], of the cloths that `asks` lets through.
    #[must_use]
    pub fn cast_ray_if(&self, ray: Ray3d, farthest: f32, asks: impl Fn(Entity) -> bool) -> Option<ClothHit> {
        let direction = Vec3::from(ray.direction);
        self.best(farthest, asks, |particles, origin, limit| {
            let origin = (ray.origin.as_dvec3() - origin).as_vec3();
            let (low, high) = bounds(particles);
            // Slabs; NaN, on an axis without motion, is passed over by `max` and `min`.
            let (u, v) = ((low - origin) / direction, (high - origin) / direction);
            let (near, far) = (u.min(v).max_element(), u.max(v).min_element());
            (near <= far * (1.0 + 1.0e-5) + 1.0e-4 && near <= limit && far >= -1.0e-4).then_some((origin, direction))
        })
    }

    /// The point of any cloth that is nearest to `point` `[m]`, no farther than `farthest` `[m]`.
    #[must_use]
    pub fn nearest_point(&self, point: Vec3, farthest: f32) -> Option<ClothHit> {
        self.nearest_point_if(point, farthest, |_| true)
    }

    /// As [`Self::nearest_point`], of the cloths that `asks` lets through.
    #[must_use]
    pub fn nearest_point_if(&self, point: Vec3, farthest: f32, asks: impl Fn(Entity) -> bool) -> Option<ClothHit> {
        self.best(farthest, asks, |particles, origin, limit| {
            let origin = (point.as_dvec3() - origin).as_vec3();
            let (low, high) = bounds(particles);
            let off = origin.clamp(low, high).distance(origin);
            // Farther off than its square can tell, nothing is near, however far one asks.
            (off <= limit && off.is_finite()).then_some((origin, Vec3::ZERO))
        })
    }

    /// The nearest of all cloths within reach. `place` gives the place and the direction in the frame of the cloth, or none
    /// when its box is out of reach. Without a direction the nearest point is asked for. Of two at the same distance the entity
    /// that comes first is taken.
    fn best(
        &self,
        farthest: f32,
        asks: impl Fn(Entity) -> bool,
        place: impl Fn(&[Vec3], DVec3, f32) -> Option<(Vec3, Vec3)>,
    ) -> Option<ClothHit> {
        let mut best: Option<ClothHit> = None;
        for (entity, rest, shown, inputs, global) in &self.cloths {
            let faces = &rest.shape().topology.faces;
            if inputs.is_animated() || shown.particles.len() != rest.shape().positions.len() || !asks(entity) {
                continue;
            }
            let particles = drawn(shown, inputs.active, &global.affine());
            let limit = best.as_ref().map_or(farthest, |hit| hit.distance);
            let Some((from, direction)) = place(&particles, shown.origin, limit) else { continue };
            let at = |p: u32| particles.get(p as usize).copied().unwrap_or(Vec3::NAN);
            let found = if direction == Vec3::ZERO {
                raycast::nearest(faces, at, from, limit)
            } else {
                raycast::ray(faces, at, from, direction, limit)
            };
            let Some(Pick { face, weights, distance }) = found else { continue };
            if best.as_ref().is_some_and(|hit| (distance, entity) >= (hit.distance, hit.entity)) {
                continue;
            }
            let corners = faces[face];
            let [a, b, c] = corners.map(at);
            let point = a * weights.x + b * weights.y + c * weights.z;
            best = Some(ClothHit {
                entity,
                triangle: face as u32,
                particles: corners,
                barycentric: weights,
                point: (shown.origin + point.as_dvec3()).as_vec3(),
                normal: (b - a).cross(c - a).normalize_or_zero(),
                distance,
            });
        }
        best
    }
}

/// Where the particles are drawn `[m]`, around the origin of the cloth. The mesh of a cloth that is not simulated goes with its
/// entity.
fn drawn<'a>(shown: &'a ClothShown, active: bool, affine: &Affine3A) -> Cow<'a, [Vec3]> {
    if active || shown.affine == *affine {
        return Cow::Borrowed(&shown.particles);
    }
    let motion = seen_from(affine, shown.origin) * seen_from(&shown.affine, shown.origin).inverse();
    shown.particles.iter().map(|&x| motion.transform_point3(x)).collect()
}

fn bounds(points: &[Vec3]) -> (Vec3, Vec3) {
    points.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)))
}
