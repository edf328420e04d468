//! Legs by two bones: the angle of the knee follows from the distance between hip and ankle.
//!
//! ```text
//!   hip ●
//!       │ ╲ a        cos of the angle at the hip = (a² + d² − b²) / 2ad
//!     d │   ● knee
//!       │ ╱ b
//! ankle ●
//! ```

use glam::{Mat3, Quat, Vec3};

use crate::skeleton::{self, HIPS, Pose, bind};

/// The last part of the reach, which a leg approaches but never gets to [m]: a knee that snaps straight looks wrong.
const SOFT: f32 = 0.006;

/// Turns the joints of a leg so that the ankle comes to a target, or near it, and the foot is turned as told.
/// The knee points outward by an angle [rad].
pub fn leg(pose: &mut Pose, side: usize, ankle: Vec3, foot: Quat, outward: f32) {
    let bind = bind();
    let first = skeleton::leg(side);
    let [hip, knee, rest] = [bind[first], bind[first + 1], bind[first + 2]];
    let (a, b) = (hip.distance(knee), knee.distance(rest));
    let places = pose.places();
    let hips = places[HIPS].1;
    let from = places[first].0;
    let line = ankle - from;
    let d = softened(line.length(), a + b).max((a - b).abs() + 0.02);
    let along = line.normalize_or(Vec3::NEG_Y);
    let pole = pole(hips * Quat::from_rotation_y(outward), foot, along);
    let cos = ((a * a + d * d - b * b) / (2.0 * a * d)).clamp(-1.0, 1.0);
    let sin = (1.0 - cos * cos).sqrt();
    let bent = from + along * (a * cos) + pole * (a * sin);
    let end = from + along * d;
    let upper = frame(bent - from, pole) * frame(knee - hip, Vec3::Z).inverse();
    let lower = frame(end - bent, pole) * frame(rest - knee, Vec3::Z).inverse();
    pose.rotations[first] = (hips.inverse() * upper).normalize();
    pose.rotations[first + 1] = (upper.inverse() * lower).normalize();
    pose.rotations[first + 2] = (lower.inverse() * foot).normalize();
}

/// A distance that grows ever more slowly near the reach.
fn softened(distance: f32, reach: f32) -> f32 {
    let start = reach - SOFT;
    if distance > start { start + SOFT * (1.0 - ((start - distance) / SOFT).exp()) } else { distance }
}

/// Where the knee points, at right angles to the line from hip to ankle: as the hips face, and a little as the foot does.
fn pole(hips: Quat, foot: Quat, along: Vec3) -> Vec3 {
    let swung = Quat::from_rotation_arc(hips * Vec3::NEG_Y, along) * hips * Vec3::Z;
    let toes = (foot * Vec3::Z).reject_from(along);
    let toes = if toes.dot(swung) > 0.0 { toes } else { Vec3::ZERO };
    (swung + toes * toes.dot(swung)).reject_from(along).normalize_or(swung)
}

/// A rotation whose −Y lies along a bone, with Z near a direction.
fn frame(bone: Vec3, front: Vec3) -> Quat {
    let y = -bone.normalize();
    let z = front.reject_from(y).normalize();
    Quat::from_mat3(&Mat3::from_cols(y.cross(z), y, z))
}
