//! Tangles on purpose: a cloth folded through itself, or pushed through another. Geometry only; nothing is given speed.
//!
//! ```text
//!        v ──►                 the half beyond the middle is turned over onto the other one,
//!   ┌─────────┬─────────┐      and tilted about v, so that it lies above on one side of the
//!   │  stays  │  folds  │      line u = 0 and below on the other: it crosses along that line
//!   └─────────┴─────────┘
//! ```

use bevy::math::{Mat3, Quat, Vec3, Vec4};

/// Slope at which the folded half is tilted (dimensionless).
const TILT: f32 = 0.5;
/// Depth of the dent with which a cloth is pushed through another, as a fraction of its size.
const DEPTH: f32 = 0.2;
/// Width of the dent that is pushed, over its depth: steeper would overstretch edges.
const WIDTH: f32 = 1.6;
/// Distance from what holds a cloth at which it begins to turn as a whole, as a fraction of its size.
const HINGE: f32 = 0.2;
/// Particles of each cloth that are looked at to find where they are nearest.
const LOOKED_AT: usize = 400;

/// Centre and axes of a cloth, longest first.
struct Frame {
    center: Vec3,
    axes: [Vec3; 3],
}

/// Axes of inertia, by iteration of the covariance.
fn frame(positions: &[Vec4]) -> Frame {
    let n = positions.len().max(1) as f32;
    let center = positions.iter().map(|x| x.truncate()).sum::<Vec3>() / n;
    let outer = |d: Vec3| Mat3::from_cols(d * d.x, d * d.y, d * d.z);
    let spread = positions.iter().map(|x| outer(x.truncate() - center)).fold(Mat3::ZERO, |sum, m| sum + m);
    let strongest = |m: Mat3, start: Vec3| (0..48).fold(start, |v, _| (m * v).normalize_or(start));
    let first = strongest(spread, Vec3::new(0.8, 0.5, 0.33).normalize());
    let rest = spread - outer(first) * first.dot(spread * first);
    // Not along one of the others: what is flat has no extent along its normal, and would leave it there.
    let aside = first.any_orthonormal_vector();
    let second = strongest(rest, (aside + 0.618 * first.cross(aside)).normalize());
    let second = (second - first * second.dot(first)).normalize_or(aside);
    Frame { center, axes: [first, second, first.cross(second)] }
}

/// Positions of the particles that are held.
fn held(positions: &[Vec4]) -> Vec<Vec3> {
    positions.iter().filter(|x| x.w == 0.0).map(|x| x.truncate()).collect()
}

/// How far a particle may follow: 0 where it is held, 1 beyond `reach` `[m]` from anything held.
fn freedom(x: Vec3, held: &[Vec3], reach: f32) -> f32 {
    let nearest = held.iter().map(|h| h.distance_squared(x)).fold(f32::INFINITY, f32::min).sqrt();
    if reach > 0.0 { (nearest / reach).min(1.0) } else { 1.0 }
}

/// Folds the half that is held least over the other and through it. `w` is the inverse mass: 0 stays. False when there is
/// nothing to fold.
pub(super) fn fold(positions: &mut [Vec4]) -> bool {
    let Frame { center, axes } = frame(positions);
    let held = held(positions);
    let across = |v: Vec3| positions.iter().map(|x| (x.truncate() - center).dot(v).abs()).fold(0.0, f32::max);
    let on_side = |v: Vec3| held.iter().filter(|h| (**h - center).dot(v) > 0.0).count();
    // Along the axis and to the side where least is held; ties go to the longer axis.
    let ways = [(axes[0], axes[1]), (-axes[0], axes[1]), (axes[1], axes[0]), (-axes[1], axes[0])];
    let Some((v, u)) = ways.into_iter().min_by_key(|(v, _)| on_side(*v)) else { return false };
    let (n, far) = (v.cross(u), across(v));
    if !(far > 0.0 && center.is_finite()) {
        return false;
    }
    for x in positions.iter_mut() {
        let from = x.truncate();
        let offset = from - center;
        let (along, d, z) = (offset.dot(u), offset.dot(v), offset.dot(n));
        if d > 0.0 && x.w > 0.0 {
            let to = center + u * along - v * d + n * (along * TILT * d / far - z);
            *x = from.lerp(to, freedom(from, &held, 0.8 * far)).extend(x.w);
        }
    }
    true
}

/// Pushes a cloth through the particles of another, all in one frame, where they are nearest. A free cloth is brought near and
/// gets a dent; a held one turns about what holds it. False when one of them is empty.
pub(super) fn push(positions: &mut [Vec4], other: &[Vec3]) -> bool {
    let every = |n: usize| n.div_ceil(LOOKED_AT).max(1);
    let center = frame(positions).center;
    let size = positions.iter().map(|x| x.truncate().distance(center)).fold(0.0, f32::max);
    let held = held(positions);
    let mut nearest: Option<(f32, Vec3, Vec3)> = None;
    for x in positions.iter().filter(|x| x.w > 0.0).step_by(every(positions.len())).map(|x| x.truncate()) {
        // Near, and free to go there.
        let bonus = size * freedom(x, &held, size);
        for &y in other.iter().step_by(every(other.len())) {
            let cost = x.distance(y) - bonus;
            if nearest.is_none_or(|(least, ..)| cost < least) {
                nearest = Some((cost, x, y));
            }
        }
    }
    let Some((_, from, to)) = nearest else { return false };
    let middle = other.iter().sum::<Vec3>() / other.len().max(1) as f32;
    let ahead = (to - from).normalize_or((middle - center).normalize_or(Vec3::Y));
    let depth = ahead * DEPTH * size;
    // Half of the dent is on this side of the other cloth, half is beyond.
    let shift = if held.is_empty() { to - from - 0.5 * depth } else { Vec3::ZERO };
    let way = to - (from + shift) + if held.is_empty() { 0.5 * depth } else { depth };
    if !((shift + way).is_finite() && size > 0.0) {
        return false;
    }
    let reach = WIDTH * way.length();
    let hinge = held.iter().sum::<Vec3>() / held.len().max(1) as f32;
    let arm = from - hinge;
    let turn = Quat::from_rotation_arc(arm.normalize_or(Vec3::Y), (arm + way).normalize_or(Vec3::Y));
    for x in positions.iter_mut().filter(|x| x.w > 0.0) {
        let at = x.truncate();
        let to = if held.is_empty() {
            let near = (1.0 - at.distance(from) / reach).max(0.0);
            at + shift + way * (near * near * (3.0 - 2.0 * near))
        } else {
            // It turns about what holds it, which stretches it least.
            at.lerp(hinge + turn * (at - hinge), freedom(at, &held, HINGE * size))
        };
        *x = to.extend(x.w);
    }
    true
}
