//! First touch of a face on its way, by conservative advancement.
//!
//! ```text
//!   T(s) = T0 + s (T1 - T0)      d(s): distance of T(s) and the part;  |d(s) - d(s')| <= |s - s'| max |x1 - x0|
//! ```
//!
//! As for particles ([`sweep`](super::sweep)), with the nearest point of the whole face in place of one point.

use super::nearest::{Face, Near, at};
use super::sweep::{GRAZE, STEPS};
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

/// Where a face that begins outside first comes closer than `keep` and is led deeper, and its nearest point there. `None`:
/// nowhere.
pub(super) fn first_touch(nearest: &impl Fn(&Face) -> Option<Near>, from: &Face, to: &Face, keep: f32) -> Option<(Face, Near)> {
    let length = longest_way(from, to);
    let moves = length > 1.0e-9;
    if !moves {
        return None;
    }
    let mut travelled = 0.0;
    let mut last = None;
    for _ in 0..STEPS {
        let face = between(from, to, travelled / length);
        let Some(near) = nearest(&face).filter(|near| near.sample.distance > 0.0) else { break };
        let gap = near.sample.distance - keep;
        let deeper = near.sample.normal.dot(at(to, &near.weights) - near.point);
        last = Some((face, near));
        if gap <= TOUCHING * keep && gap + deeper < -GRAZE * keep {
            break;
        }
        travelled += gap.max(0.5 * near.sample.distance).max(1.0e-6);
        if travelled >= length {
            return None;
        }
    }
    last
}
