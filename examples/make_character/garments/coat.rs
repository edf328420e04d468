//! The coat: over shirt and skirt, open in front, with a stand-up collar, to the knee.

use glam::{Vec3, vec3};
use serde_json::json;

use super::fitted::{Fitted, collar, cuff, upper, uvs};
use super::turned::{Cut, Turned};
use super::{BACKSTOP, DRIVE, Garment, MAX_DISTANCE, Making, skirt};
use crate::anatomy::Anatomy;
use crate::field::{melt, step};
use crate::mesh::Mesh;
use crate::weights::{self, Shares};

/// Gaps to the body [m].
const TORSO: f32 = 0.0235;
const SLEEVE: f32 = 0.0250;
/// Its lower part.
pub const LOWER: Cut =
    Cut { top: 1.100, hem: 0.455, gap: 0.031, flare_top: 1.010, flare: 0.135, folds: skirt::FOLDS, depth: 0.018 };
const COLLAR: f32 = 1.512;
/// Length of the sleeve below the elbow [m].
const CUFF: f32 = 0.232;
const EDGE: f32 = 0.0235;

/// Signed distance to the solid inside the coat.
pub fn solid(anatomy: &Anatomy, lower: &Turned, p: Vec3) -> f32 {
    let above = upper(anatomy, p, TORSO, SLEEVE);
    // The lower part begins within the upper one, where both agree.
    let below = lower.distance(p) + 0.5 * (p.y - LOWER.top + 0.03).max(0.0);
    melt(above, below, 0.03)
}

/// Half the width of the opening in front [m].
fn opening(y: f32) -> f32 {
    0.014 + 0.030 * step(1.05, LOWER.hem, y) + 0.045 * step(1.28, 1.50, y)
}

/// The coat.
pub fn make(anatomy: &Anatomy) -> Garment {
    let lower = Turned::around(anatomy, LOWER);
    let field = |p: Vec3| solid(anatomy, &lower, p);
    let hem = |p: Vec3| LOWER.hem - p.y;
    let neck = |p: Vec3| collar(p, COLLAR);
    let sleeve = |p: Vec3| cuff(anatomy, p, CUFF);
    let front = |p: Vec3| if p.z > 0.0 { opening(p.y) - p.x.abs() } else { -0.1 };
    let fitted = Fitted {
        field: &field,
        lines: &[&hem, &neck, &sleeve, &front],
        low: vec3(-0.64, 0.40, -0.42),
        high: vec3(0.64, 1.62, 0.42),
        edge: EDGE,
    };
    let mesh = fitted.mesh();
    let points = || mesh.positions.iter();
    let room = |&p: &Vec3| {
        let from_collar = step(0.012, 0.100, -neck(p));
        let arm = step(0.06, 0.24, anatomy.along_upper_arm(p)) * step(0.19, 0.28, p.x.abs()) * step(0.85, 0.95, p.y);
        let fall = ((1.02 - p.y) / (1.02 - LOWER.hem)).clamp(0.0, 1.0);
        from_collar * (0.08f32).max(fall).max(0.22 * arm)
    };
    let firm = |&p: &Vec3| step(0.62, 1.10, p.y) * (1.0 - 0.6 * step(0.22, 0.36, p.x.abs()));
    let making = Making {
        name: "Coat",
        color: [0.055, 0.085, 0.16],
        extras: json!({
            "cloth": { "material": "denim", "layer": 1, "thickness": 0.006 },
            "cloth.max_distance": [0.0, 0.25],
            "cloth.drive": [0.0, 4.0],
            "cloth.backstop": [0.0, 0.05],
        }),
        maps: vec![
            (MAX_DISTANCE, points().map(room).collect()),
            (DRIVE, points().map(firm).collect()),
            (BACKSTOP, points().map(|p| step(0.95, 0.60, p.y)).collect()),
        ],
        uvs: uvs(anatomy, &mesh),
        shares: shares(anatomy, &mesh),
    };
    making.garment(mesh)
}

/// As the body above, as a skirt below.
fn shares(anatomy: &Anatomy, mesh: &Mesh) -> Vec<Shares> {
    const SMOOTHING: usize = 18;
    let mixed = mesh.positions.iter().map(|&p| {
        let skirt = super::weights::skirt(p);
        let body = weights::shares(anatomy, p);
        let below = if p.x.abs() > 0.33 && p.y > 0.80 { 0.0 } else { step(1.12, 1.00, p.y) };
        std::array::from_fn(|k| body[k] + (skirt[k] - body[k]) * below)
    });
    mesh.smoothed(mixed.collect(), SMOOTHING)
}
