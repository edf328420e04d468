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
    let lips = step(0.002, -0.002, ellipsoid(q, MOUTH - vec3(0.0, 0.0008, 0.004), vec3(0.0225, 0.0095, 0.020)));
    color *= Vec3::ONE.lerp(vec3(0.82, 0.50, 0.50), lips);
    let cheek = step(0.028, 0.004, q.distance(vec3(0.043, 1.588, 0.070)));
    color *= Vec3::ONE.lerp(vec3(1.0, 0.80, 0.76), cheek);
    let inner = bone(q, vec3(0.015, 1.6565, 0.092), vec3(0.034, 1.6605, 0.083), 0.0030, 0.0028);
    let outer = bone(q, vec3(0.034, 1.6605, 0.083), vec3(0.050, 1.6555, 0.064), 0.0028, 0.0018);
    color *= Vec3::ONE.lerp(vec3(0.24, 0.19, 0.17), step(0.0042, -0.0015, inner.min(outer)));
    [color.x, color.y, color.z, 1.0]
}
