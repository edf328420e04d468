//! Colours of the skin from place to place, as factors of its material: lips, cheeks and brows.

use glam::{Vec3, vec3};

use crate::anatomy::folded;
use crate::field::{bone, ellipsoid, step};
use crate::head::MOUTH;

/// Linear factors at a point of the body.
pub fn of(p: Vec3) -> [f32; 4] {
    if p.y < 1.5 || p.z < 0.02 {
        return [1.0; 4];
    }
    let q = folded(p);
    let mut color = Vec3::ONE;
    let lips = step(0.002, -0.002, ellipsoid(q, MOUTH - vec3(0.0, 0.0008, 0.004), vec3(0.0250, 0.0115, 0.020)));
    color *= Vec3::ONE.lerp(vec3(0.72, 0.34, 0.36), lips);
    let cheek = step(0.028, 0.004, q.distance(vec3(0.043, 1.588, 0.070)));
    color *= Vec3::ONE.lerp(vec3(1.0, 0.80, 0.76), cheek);
    let brow = bone(q, vec3(0.014, 1.6555, 0.092), vec3(0.034, 1.6620, 0.083), 0.0036, 0.0034).min(bone(
        q,
        vec3(0.034, 1.6620, 0.083),
        vec3(0.050, 1.6560, 0.064),
        0.0034,
        0.0020,
    ));
    color *= Vec3::ONE.lerp(vec3(0.16, 0.13, 0.12), step(0.0035, -0.0010, brow));
    [color.x, color.y, color.z, 1.0]
}
