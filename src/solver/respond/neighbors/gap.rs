//! How far faces are apart, now and at the next look, as far as that is quickly told.

use glam::{Vec3A, Vec4};

use super::patch::Lanes;
use crate::solver::detect::beside::are_beside;
use crate::solver::detect::four::{Four, WIDE};
use crate::solver::detect::tree::{Bounds, LEAF};

/// Box of where particle `v` is and is foreseen to be `[m]`.
#[inline]
pub(super) fn way(positions: &[Vec4], ahead: &[Vec3A], v: u32) -> Bounds {
    let (now, ahead) = (Vec3A::from_vec4(positions[v as usize]), ahead[v as usize]);
    Bounds { min: now.min(ahead), max: now.max(ahead) }
}

/// Of the `faces` of a leaf, a bit each, those that may come within `reach` `[m]` of a face. Then, of these, those that are
/// within `close` `[m]`. The face is where it is `now` and is foreseen to be `ahead` `[m]`.
///
/// Faces are farther apart where they are along the line between their centres, now and ahead.
#[inline]
pub(super) fn near(now: [Vec4; 3], ahead: [Vec3A; 3], others: &Lanes, faces: u8, reach: f32, close: f32) -> [u8; 2] {
    let splat = |of: [Vec3A; 3]| [Four::splat(of[0]), Four::splat(of[1]), Four::splat(of[2])];
    let now = splat([Vec3A::from_vec4(now[0]), Vec3A::from_vec4(now[1]), Vec3A::from_vec4(now[2])]);
    let ahead = splat(ahead);
    let centre = now[0] + now[1] + now[2];
    let (mut may, mut do_now) = (0, 0);
    for half in (0..LEAF / WIDE).filter(|half| faces >> (WIDE * half) & 0xf != 0) {
        let of = |corners: &[[Four; LEAF / WIDE]; 3]| [corners[0][half], corners[1][half], corners[2][half]];
        let (g, there) = (of(&others.now), of(&others.ahead));
        let axis = centre - (g[0] + g[1] + g[2]);
        let square = axis.length_squared();
        let exceeds = |gap: Vec4, reach: f32| gap.cmpgt(Vec4::ZERO) & (gap * gap).cmpgt(Vec4::splat(reach * reach) * square);
        let apart = gap(&now, &g, axis);
        let (mut far, far_now) = (exceeds(apart, reach), exceeds(apart, close));
        // What is not far now need not be asked about.
        if far.any() {
            far &= exceeds(gap(&ahead, &there, axis), reach);
        }
        may |= ((!far).bitmask() << (WIDE * half)) as u8;
        do_now |= ((!far_now).bitmask() << (WIDE * half)) as u8;
    }
    [may & faces, may & do_now & faces]
}

/// Of the `faces` of a leaf, a bit each, those that may cross a face that is where it is `now`. The others surely lie beside
/// it.
#[inline]
pub(super) fn may_cross(now: [Vec4; 3], others: &Lanes, faces: u8) -> u8 {
    let f =
        [Four::splat(Vec3A::from_vec4(now[0])), Four::splat(Vec3A::from_vec4(now[1])), Four::splat(Vec3A::from_vec4(now[2]))];
    let mut may = 0;
    for half in (0..LEAF / WIDE).filter(|half| faces >> (WIDE * half) & 0xf != 0) {
        let g = [others.now[0][half], others.now[1][half], others.now[2][half]];
        may |= (!are_beside(&f, &g) & 0xf) << (WIDE * half);
    }
    may as u8 & faces
}

/// How far faces `f` are beyond faces `g` along an axis, times its length `[m²]`.
#[inline]
fn gap(f: &[Four; 3], g: &[Four; 3], axis: Four) -> Vec4 {
    let along = |p: Four| (p - g[0]).dot(axis);
    along(f[0]).min(along(f[1])).min(along(f[2])) - along(g[1]).max(along(g[2])).max(Vec4::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::detect::four::each;

    /// The gap of two faces, as [`gap`].
    fn one(f: &[Vec3A; 3], g: &[Vec3A; 3], axis: Vec3A) -> f32 {
        let along = |p: Vec3A| (p - g[0]).dot(axis);
        f.map(along).into_iter().fold(f32::INFINITY, f32::min) - g.map(along).into_iter().fold(0.0, f32::max)
    }

    #[test]
    fn four_faces_at_once_are_as_far_as_one_after_the_other() {
        let mut rng = fastrand::Rng::with_seed(5);
        let mut face = |size: f32| {
            let centre = Vec3A::from([(); 3].map(|()| 0.1 * rng.f32()));
            [(); 3].map(|()| centre + Vec3A::from([(); 3].map(|()| size * rng.f32())))
        };
        let (reach, close) = (0.01, 0.006);
        let mut met = [0; 3];
        for _ in 0..2_000 {
            let (now, ahead) = (face(0.05), face(0.05));
            let others: [[[Vec3A; 3]; 2]; LEAF] = [(); LEAF].map(|()| [face(0.05), face(0.05)]);
            let lanes = |moment: usize| {
                let corner = |c: usize, half: usize| Four::of(each(|k: usize| others[WIDE * half + k][moment][c].extend(0.0)));
                [0, 1, 2].map(|c: usize| [corner(c, 0), corner(c, 1)])
            };
            let lanes = Lanes { now: lanes(0), ahead: lanes(1) };
            let [may, within] = near(now.map(|x| x.extend(1.0)), ahead, &lanes, 0b0111_1111, reach, close);
            for (k, [g, there]) in others.iter().enumerate() {
                let axis = (now[0] + now[1] + now[2]) - (g[0] + g[1] + g[2]);
                let gaps = [one(&now, g, axis), one(&ahead, there, axis)];
                let exceeds = |gap: f32, reach: f32| gap > 0.0 && gap * gap > reach * reach * axis.length_squared();
                let expected = k < 7 && !exceeds(gaps[0].min(gaps[1]), reach);
                assert_eq!(may >> k & 1 != 0, expected, "{gaps:?}");
                assert_eq!(within >> k & 1 != 0, expected && !exceeds(gaps[0], close), "{gaps:?}");
                met[usize::from(may >> k & 1) + usize::from(within >> k & 1)] += 1;
            }
        }
        assert!(met.iter().all(|&count| count > 500), "{met:?}");
    }
}
