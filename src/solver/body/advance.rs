//! First touch of a face on its way, by conservative advancement.
//!
//! ```text
//!   T(s) = T0 + s (T1 - T0)      d(s): distance of T(s) and the part;  |d(s) - d(s')| <= |s - s'| max |x1 - x0|
//! ```
//!
//! As for particles ([`sweep`](super::sweep)), with the nearest point of the whole face in place of one point. All shapes that
//! faces meet are convex, hence lie behind their tangent plane at the nearest point. A face gets no nearer than its lowest
//! corner over that plane. So a face on its way along a surface takes most of that way in one step (the bound on directed
//! motion of Mirtich 1996).

use glam::Vec3A;

use super::nearest::{Face, Near, at};
use super::sweep::{GRAZE, LEAST_STEP, SHORTEST_WAY, STEPS};
use crate::solver::scales::TOUCHING;

/// The face at the share `s` of its way.
#[inline]
fn between(from: &Face, to: &Face, s: f32) -> Face {
    [0, 1, 2].map(|i| from[i] + (to[i] - from[i]) * s)
}

/// Longest way of a corner `[m]`.
#[inline]
pub(super) fn longest_way(from: &Face, to: &Face) -> f32 {
    let square = |i: usize| (to[i] - from[i]).length_squared();
    square(0).max(square(1)).max(square(2)).sqrt()
}

/// Share of the way of a face on which no corner gets lower than `level` `[m]`. Heights are over the tangent plane of a part at
/// its nearest point.
#[inline]
fn share_above(level: f32, near: &Near, from: &Face, to: &Face) -> f32 {
    let floor = near.sample.normal.dot(near.point) - near.sample.distance + level;
    let height = |x: Vec3A| near.sample.normal.dot(x) - floor;
    from.iter().zip(to).fold(1.0, |share, (from, to)| {
        let (before, after) = (height(*from), height(*to));
        if after < 0.0 { share.min(before.max(0.0) / (before.max(0.0) - after)) } else { share }
    })
}

/// Where a face that begins outside first comes closer than `keep` and is led deeper, and its nearest point there. `None`:
/// nowhere.
pub(super) fn first_touch(nearest: &impl Fn(&Face) -> Option<Near>, from: &Face, to: &Face, keep: f32) -> Option<(Face, Near)> {
    let length = longest_way(from, to);
    let moves = length > SHORTEST_WAY;
    if !moves {
        return None;
    }
    let mut travelled = 0.0;
    let mut last = None;
    for _ in 0..STEPS {
        let face = between(from, to, travelled / length);
        let Some(near) = nearest(&face).filter(Near::is_outside) else { break };
        let gap = near.sample.distance - keep;
        let deeper = near.sample.normal.dot(at(to, &near.weights) - near.point);
        last = Some((face, near));
        if gap <= TOUCHING * keep && gap + deeper < -GRAZE * keep {
            break;
        }
        let level = near.sample.distance.min(keep) - GRAZE * keep;
        let ahead = (length - travelled) * share_above(level, &near, &face, to);
        travelled += gap.max(0.5 * near.sample.distance).max(LEAST_STEP).max(ahead);
        if travelled >= length {
            return None;
        }
    }
    last
}

#[cfg(test)]
mod tests {
    use core::cell::Cell;

    use super::*;
    use crate::solver::body::geometry::Geometry;
    use crate::solver::body::nearest::Convex;

    /// Along Z, of 1 mm.
    fn needle() -> Convex<'static> {
        let ab = Vec3A::Z * 2.0;
        let geometry = Geometry::Capsule { a: Vec3A::NEG_Z, ab, inverse_length2: 1.0 / ab.length_squared(), radius: 1.0e-3 };
        Convex { geometry, support: None }
    }

    /// Where a face touches the needle, and how often its nearest point is asked for on the way.
    fn touch(from: Face, by: Vec3A, keep: f32) -> (Option<(Face, Near)>, u32) {
        let asked = Cell::new(0);
        let nearest = |face: &Face| {
            asked.set(asked.get() + 1);
            needle().nearest(face, Vec3A::Y)
        };
        (first_touch(&nearest, &from, &from.map(|x| x + by), keep), asked.get())
    }

    const FACE: Face = [Vec3A::new(-0.1, 0.0, -0.1), Vec3A::new(0.1, 0.0, -0.1), Vec3A::new(0.0, 0.0, 0.1)];

    #[test]
    fn face_that_slides_along_a_body_is_sampled_a_few_times_however_long_its_way() {
        let keep = 2.0e-3;
        let over = FACE.map(|x| x + Vec3A::Y * 3.0e-3);
        for way in [0.01, 0.1, 1.0, 10.0] {
            let (touched, asked) = touch(over, Vec3A::Z * way, keep);
            assert!(touched.is_none() && asked <= 2, "{way} m: {asked} samples, {touched:?}");
        }
    }

    #[test]
    fn face_stops_at_the_distance_kept_from_wherever_it_comes() {
        let keep = 2.0e-3;
        let mut random = fastrand::Rng::with_seed(5);
        for n in 0..2000 {
            let mut number = || 2.0 * random.f32() - 1.0;
            // It begins over the needle and ends beneath it, turned and tilted.
            let from = FACE.map(|x| x + Vec3A::new(0.02 * number(), 0.3 + 0.1 * number(), 0.02 * number()));
            let by = Vec3A::new(0.05 * number(), -0.6, 2.0 * number());
            let (touched, asked) = touch(from, by, keep);
            let (mut least, mut first) = (f32::INFINITY, None);
            for k in 0..=2000 {
                let share = k as f32 / 2000.0;
                let distance = needle().nearest(&between(&from, &from.map(|x| x + by), share), Vec3A::Y);
                let distance = distance.map_or(0.0, |near| near.sample.distance);
                least = least.min(distance);
                if distance < keep && first.is_none() {
                    first = Some(share);
                }
            }
            let Some((_, near)) = touched else {
                assert!(least > keep * 0.9, "{n}: passed at {least} m");
                continue;
            };
            let distance = near.sample.distance;
            assert!(first.is_some(), "{n}: touched at {distance} m, and never came nearer than {least} m");
            assert!(distance > 0.5 * keep && distance < 1.03 * keep, "{n}: stopped at {distance} m after {asked} samples");
            assert!(asked <= 12, "{n}: {asked} samples");
        }
    }
}
