//! Normals and tangents of the shown surface.

use glam::{Vec2, Vec3, Vec4};

/// Area-weighted normals of particles: `n_i = normalize(Σ (b - a) x (c - a))` over the faces around `i`. A particle without
/// area keeps the normal it has in `normals`.
pub(crate) fn normals(faces: &[[u32; 3]], positions: &[Vec3], sums: &mut Vec<Vec3>, normals: &mut Vec<Vec3>) {
    sums.clear();
    sums.resize(positions.len(), Vec3::ZERO);
    for face in faces {
        let [a, b, c] = face.map(|p| positions[p as usize]);
        let n = (b - a).cross(c - a);
        for &p in face {
            sums[p as usize] += n;
        }
    }
    normals.resize(positions.len(), Vec3::Y);
    for (n, sum) in normals.iter_mut().zip(sums) {
        if let Some(unit) = sum.try_normalize() {
            *n = unit;
        }
    }
}

/// How a triangle's texture lies on it: `tangent = (b - a) * along.x + (c - a) * along.y`, weighted by its area in the texture.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct TextureAxis {
    /// Render vertices of the triangle.
    pub corners: [u32; 3],
    /// Weights of the two edges from the first corner.
    pub along: Vec2,
}

impl TextureAxis {
    /// None when the texture has no direction there.
    ///
    /// With texture edges `(u1, v1)`, `(u2, v2)` and `d = u1 v2 - u2 v1`: `T = (e1 v2 - e2 v1) / d`; only the sign of `d` is
    /// kept.
    #[must_use]
    pub(crate) fn new(corners: [u32; 3], uv: [Vec2; 3]) -> Option<Self> {
        let (e1, e2) = (uv[1] - uv[0], uv[2] - uv[0]);
        let d = e1.perp_dot(e2);
        (d != 0.0 && d.is_finite()).then(|| Self { corners, along: Vec2::new(e2.y, -e1.y) * d.signum() })
    }
}

/// Tangents of render vertices: the texture axes of the triangles around each, orthogonal to its normal. Handedness (`w`)
/// stays; a vertex whose texture has no direction keeps any orthogonal one.
pub(crate) fn tangents(
    axes: &[TextureAxis],
    position: impl Fn(usize) -> Vec3,
    normal: impl Fn(usize) -> Vec3,
    tangents: &mut [Vec4],
) {
    for t in tangents.iter_mut() {
        *t = Vec4::new(0.0, 0.0, 0.0, t.w);
    }
    for axis in axes {
        let [a, b, c] = axis.corners.map(|v| position(v as usize));
        let t = ((b - a) * axis.along.x + (c - a) * axis.along.y).extend(0.0);
        for &v in &axis.corners {
            tangents[v as usize] += t;
        }
    }
    for (v, t) in tangents.iter_mut().enumerate() {
        let n = normal(v);
        let across = t.truncate() - n * n.dot(t.truncate());
        *t = across.try_normalize().unwrap_or_else(|| n.any_orthonormal_vector()).extend(t.w);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tangents_follow_the_texture_and_are_orthogonal_to_the_normal() {
        let positions = [Vec3::ZERO, Vec3::X, Vec3::new(0.0, 0.0, -1.0)];
        let axis = TextureAxis::new([0, 1, 2], [Vec2::ZERO, Vec2::X, Vec2::Y]).expect("a texture with area");
        let mut t = [Vec4::new(0.0, 0.0, 0.0, -1.0); 3];
        tangents(&[axis], |v| positions[v], |_| Vec3::Y, &mut t);
        assert_eq!(t, [Vec4::new(1.0, 0.0, 0.0, -1.0); 3]);
    }

    #[test]
    fn a_particle_without_area_keeps_its_normal() {
        let mut n = vec![Vec3::X; 4];
        normals(&[[0, 1, 2]], &[Vec3::ZERO, Vec3::X, Vec3::NEG_Z, Vec3::ONE], &mut Vec::new(), &mut n);
        assert_eq!(n, [Vec3::Y, Vec3::Y, Vec3::Y, Vec3::X]);
    }
}
