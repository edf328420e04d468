//! Weights of what hangs free of the body: skirts and capes.

use glam::Vec3;

use crate::field::step;
use crate::measures::HIP;
use crate::skeleton::{CHEST, COUNT, HIPS, SPINE, arm, leg};
use crate::weights::Shares;

/// Where a skirt begins to follow the thighs, and where it follows them most [m]: around the hip joints, as the body does. What
/// follows later is within the thighs of who sits down, and its maximum distance draws the cloth in after it.
const THIGHS: [f32; 2] = [HIP.y + 0.05, HIP.y - 0.20];
/// How much of it follows the thighs there.
const LEGS: f32 = 0.95;
/// Where a long skirt begins to follow the legs less, and where it does least [m]; by how much, and what of it follows the
/// shins there. Between the feet cloth hangs more by itself.
const BELOW: [f32; 2] = [0.50, 0.10];
const LESS: f32 = 0.30;
const SHINS: f32 = 0.20;
/// Half the width in which left goes over into right at the hip joints [m], and how much wider it is for each metre below.
const MIDDLE: f32 = 0.13;
const WIDENS: f32 = 0.10;

/// Shares of a skirt: waist and hips, and toward the hem both thighs, softly from left to right.
pub fn skirt(p: Vec3) -> Shares {
    let mut shares = [0.0; COUNT];
    let below = step(BELOW[0], BELOW[1], p.y);
    let legs = LEGS * step(THIGHS[0], THIGHS[1], p.y) * (1.0 - LESS * below);
    let shins = SHINS * below;
    let middle = MIDDLE + WIDENS * (HIP.y - p.y).max(0.0);
    let left = step(-middle, middle, p.x);
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
