//! Weights of what hangs free of the body: skirts and capes.

use glam::Vec3;

use crate::field::step;
use crate::skeleton::{CHEST, COUNT, HIPS, SPINE, arm, leg};
use crate::weights::Shares;

/// Where a skirt begins to follow the thighs, and where it follows them most [m].
const THIGHS: [f32; 2] = [0.93, 0.52];
/// How much of the hem follows the thighs.
const LEGS: f32 = 0.80;
/// Half the width in which left goes over into right [m].
const MIDDLE: f32 = 0.13;

/// Shares of a skirt: waist and hips, and toward the hem both thighs, softly from left to right.
pub fn skirt(p: Vec3) -> Shares {
    let mut shares = [0.0; COUNT];
    let legs = LEGS * step(THIGHS[0], THIGHS[1], p.y);
    let shins = 0.35 * step(0.55, 0.15, p.y);
    let left = step(-MIDDLE, MIDDLE, p.x);
    for (side, part) in [(0, left), (1, 1.0 - left)] {
        shares[leg(side)] += legs * part * (1.0 - shins);
        shares[leg(side) + 1] += legs * part * shins;
    }
    let spine = step(0.985, 1.095, p.y);
    let chest = step(1.115, 1.245, p.y);
    shares[HIPS] += (1.0 - legs) * (1.0 - spine);
    shares[SPINE] += (1.0 - legs) * spine * (1.0 - chest);
    shares[CHEST] += (1.0 - legs) * spine * chest;
    shares
}

/// Shares of a cape: chest and a little of the shoulders above, spine and hips below.
pub fn cape(p: Vec3) -> Shares {
    let mut shares = [0.0; COUNT];
    let chest = step(0.85, 1.25, p.y);
    let hips = (1.0 - chest) * step(1.10, 0.70, p.y) * 0.7;
    let shoulders = 0.30 * step(1.28, 1.42, p.y) * step(0.05, 0.17, p.x.abs());
    shares[CHEST] = chest * (1.0 - shoulders);
    shares[arm(usize::from(p.x < 0.0))] = chest * shoulders;
    shares[HIPS] = hips;
    shares[SPINE] = 1.0 - chest - hips;
    shares
}
