//! Pairs of faces of which one lies on one side of the plane of the other, farther off than any rounding error. Such faces do
//! not cross, and need no exact signs. Most faces of layers are such.

use glam::{BVec4A, Vec3A, Vec4};

use super::four::Four;

/// From this height over the plane of a face on, its sign is sure in `f32`. The height is a share of the product of the lengths
/// of edges and way (dimensionless), and five times the rounding error.
const BESIDE: f32 = 1.0e-5;

/// Whether all corners of face `g` lie on one side of the plane of face `f`, except those that they have in `common`.
#[inline]
pub(super) fn lies_beside_plane(positions: &[Vec4], f: [u32; 3], g: [u32; 3], common: [bool; 3]) -> bool {
    let at = |v: u32| Vec3A::from_vec4(positions[v as usize]);
    let origin = at(f[0]);
    let (u, v) = (at(f[1]) - origin, at(f[2]) - origin);
    let (normal, scale) = (u.cross(v), u.length_squared() * v.length_squared());
    let (mut low, mut high, mut squares) = (f32::INFINITY, f32::NEG_INFINITY, 0.0f32);
    for (&corner, _) in g.iter().zip(common).filter(|(_, common)| !common) {
        let w = at(corner) - origin;
        let height = normal.dot(w);
        (low, high, squares) = (low.min(height), high.max(height), squares + w.length_squared());
    }
    // Rounding of all this is some `2e-6 |u| |v| |w|`; squares keep their sign. What is not a number is in the sum, and passes
    // no comparison.
    let slack = BESIDE * BESIDE * scale * squares;
    low * low.abs() > slack || -high * high.abs() > slack
}

/// Of four pairs of faces, each by its corners `[m]`, those that lie beside each other, a bit for each: either beside the
/// other. With a corner in common none is.
#[inline]
pub(in crate::solver) fn are_beside(f: &[Four; 3], g: &[Four; 3]) -> u32 {
    let mut beside = lie_beside_plane(f, g);
    if !beside.all() {
        beside |= lie_beside_plane(g, f);
    }
    beside.bitmask()
}

/// As [`lies_beside_plane`], of four pairs; each comes to the same, except where rounding decides.
#[inline]
fn lie_beside_plane(f: &[Four; 3], g: &[Four; 3]) -> BVec4A {
    let (u, v) = (f[1] - f[0], f[2] - f[0]);
    let w = [g[0] - f[0], g[1] - f[0], g[2] - f[0]];
    let normal = u.cross(v);
    let height = [normal.dot(w[0]), normal.dot(w[1]), normal.dot(w[2])];
    let low = height[0].min(height[1]).min(height[2]);
    let high = height[0].max(height[1]).max(height[2]);
    let squares = w[0].length_squared() + w[1].length_squared() + w[2].length_squared();
    let slack = Vec4::splat(BESIDE * BESIDE) * (u.length_squared() * v.length_squared()) * squares;
    (low * low.abs()).cmpgt(slack) | (-high * high.abs()).cmpgt(slack)
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::solver::detect::four::{WIDE, each};

    /// Whether a segment passes through a triangle, by signed volumes in `f64`.
    fn crosses(x: &[Vec4], [u, v]: [usize; 2], [p, q, r]: [usize; 3]) -> bool {
        let at = |i: usize| x[i].truncate().as_dvec3();
        let volume = |[a, b, c, d]: [usize; 4]| (at(b) - at(a)).cross(at(c) - at(a)).dot(at(d) - at(a));
        let around = [volume([u, v, p, q]), volume([u, v, q, r]), volume([u, v, r, p])];
        let same = around.iter().all(|s| *s > 0.0) || around.iter().all(|s| *s < 0.0);
        volume([p, q, r, u]) * volume([p, q, r, v]) < 0.0 && same
    }

    #[test]
    fn what_lies_beside_does_not_cross_and_four_at_once_are_told_as_one() {
        let mut rng = fastrand::Rng::with_seed(8);
        let (mut beside, mut crossing) = (0, 0);
        for round in 0..4_000 {
            // Far from the origin, too, where coordinates round coarsely.
            let offset = [0.0, 100.0][round % 2];
            let mut point = |size: f32| (Vec3::from([(); 3].map(|()| size * rng.f32())) + offset).extend(1.0);
            let mut faces = [[Vec4::ZERO; 6]; WIDE];
            for (k, x) in faces.iter_mut().enumerate() {
                let size = [1.0, 0.3][k % 2];
                *x = core::array::from_fn(|i| point(size) + Vec4::Y * (0.2 * (i / 3) as f32));
            }
            let corners = |first: usize| [0, 1, 2].map(|c: usize| Four::of(each(|k| faces[k][first + c])));
            let together = are_beside(&corners(0), &corners(3));
            for (k, x) in faces.iter().enumerate() {
                let one = lies_beside_plane(x, [0, 1, 2], [3, 4, 5], [false; 3])
                    || lies_beside_plane(x, [3, 4, 5], [0, 1, 2], [false; 3]);
                assert_eq!(together & (1 << k) != 0, one, "{x:?}");
                let through =
                    |edges: usize, face: [usize; 3]| (0..3).any(|i| crosses(x, [edges + i, edges + (i + 1) % 3], face));
                let cross = through(0, [3, 4, 5]) || through(3, [0, 1, 2]);
                assert!(!(one && cross), "{x:?}");
                (beside, crossing) = (beside + u32::from(one), crossing + u32::from(cross));
            }
        }
        assert!(beside > 1_000 && crossing > 1_000, "{beside} {crossing}");
    }

    #[test]
    fn of_what_is_not_a_number_nothing_is_told() {
        let at = |y: f32| [Vec3A::new(0.0, y, 0.0), Vec3A::new(1.0, y, 0.0), Vec3A::new(0.0, y, 1.0)].map(Four::splat);
        let mut broken = at(1.0);
        assert_eq!(are_beside(&at(0.0), &broken), 0b1111);
        for bad in [f32::NAN, f32::INFINITY] {
            broken[2] = Four::splat(Vec3A::splat(bad));
            assert_eq!([are_beside(&at(0.0), &broken), are_beside(&broken, &at(0.0))], [0; 2], "{bad}");
            let x = [0.0, 1.0, 2.0, 3.0, 4.0, bad].map(|x| Vec4::new(x, x * x, 1.0, 1.0));
            assert!(!lies_beside_plane(&x, [0, 1, 2], [3, 4, 5], [false; 3]), "{bad}");
        }
    }

    #[test]
    fn faces_with_a_corner_in_common_are_not_told_apart() {
        let mut rng = fastrand::Rng::with_seed(3);
        for _ in 0..1_000 {
            let mut point = || Vec3::from([(); 3].map(|()| rng.f32())).extend(1.0);
            let x: [Vec4; 5] = core::array::from_fn(|_| point());
            let face = |corners: [usize; 3]| corners.map(|c| Four::splat(Vec3A::from_vec4(x[c])));
            for common in 0..3 {
                let mut other = [3, 4, 4];
                other[2] = common;
                assert_eq!(are_beside(&face([0, 1, 2]), &face(other)), 0);
            }
        }
    }
}
