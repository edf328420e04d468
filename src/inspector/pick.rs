//! Picking a cloth in the scene: a ray against what is shown.

use bevy::math::Vec3;
use bevy::prelude::*;

use crate::components::Cloth;
use crate::simulation::{ClothParticles, ClothRest, ClothShown};

/// The nearest cloth that a ray meets, and how far along it `[m]`; cloths that are hidden are passed.
#[must_use]
pub fn pick(world: &mut World, ray: Ray3d) -> Option<(Entity, f32)> {
    let mut cloths =
        world.query_filtered::<(Entity, &ClothRest, &ClothParticles, &ClothShown, Option<&InheritedVisibility>), With<Cloth>>();
    let visible = cloths.iter(world).filter(|(.., visible)| visible.is_none_or(|v| v.get()));
    let hits = visible.filter_map(|(entity, rest, particles, shown, _)| {
        let origin = (ray.origin.as_dvec3() - particles.origin).as_vec3();
        nearest(origin, *ray.direction, &rest.0.topology.faces, &shown.particles).map(|along| (entity, along))
    });
    hits.min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)))
}

/// How far along a ray the first face lies `[m]`.
fn nearest(origin: Vec3, direction: Vec3, faces: &[[u32; 3]], positions: &[Vec3]) -> Option<f32> {
    let corner = |i: u32| positions.get(i as usize).copied();
    let hits = faces.iter().filter_map(|&[a, b, c]| meets(origin, direction, [corner(a)?, corner(b)?, corner(c)?]));
    hits.min_by(f32::total_cmp)
}

/// Where a ray meets a triangle from either side (Möller and Trumbore 1997): `o + t d = a + u (b - a) + v (c - a)`.
fn meets(origin: Vec3, direction: Vec3, [a, b, c]: [Vec3; 3]) -> Option<f32> {
    let (ab, ac) = (b - a, c - a);
    let p = direction.cross(ac);
    let determinant = ab.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let s = origin - a;
    let u = s.dot(p) / determinant;
    let q = s.cross(ab);
    let v = direction.dot(q) / determinant;
    let t = ac.dot(q) / determinant;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0).then_some(t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_meets_the_nearer_of_two_faces_from_either_side() {
        let positions = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::NEG_Z, Vec3::X - Vec3::Z, Vec3::Y - Vec3::Z];
        let faces = [[3, 4, 5], [0, 1, 2]];
        let from = Vec3::new(0.2, 0.2, 2.0);
        assert_eq!(nearest(from, Vec3::NEG_Z, &faces, &positions), Some(2.0));
        assert_eq!(nearest(from - 5.0 * Vec3::Z, Vec3::Z, &faces, &positions), Some(2.0));
        assert_eq!(nearest(Vec3::new(0.9, 0.9, 2.0), Vec3::NEG_Z, &faces, &positions), None, "beside both");
        assert_eq!(nearest(from, Vec3::Z, &faces, &positions), None, "behind it");
    }
}
