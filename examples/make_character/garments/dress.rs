//! The dress: a fitted bodice without sleeves and a full long skirt.

use glam::{Vec3, vec3};
use serde_json::json;

use super::fitted::{Fitted, lay_shoulders};
use super::turned::{Cut, Turned, uvs};
use super::{Garment, MAX_DISTANCE, Making};
use crate::anatomy::Anatomy;
use crate::body::scoop;
use crate::field::{melt, step};
use crate::measures::SHOULDER;
use crate::weights::Skin;

/// Gap of the bodice to the body [m].
const GAP: f32 = 0.0105;
/// Its skirt.
pub const SKIRT: Cut = Cut { top: 1.120, hem: 0.075, gap: 0.0105, flare_top: 1.055, flare: 0.235, folds: 12.0, depth: 0.026 };
const EDGE: f32 = 0.0167;
/// How far the armhole is from the arm [m].
const ARMHOLE: f32 = 0.034;
/// Where straps end: distance from the middle [m].
const STRAP: f32 = 0.128;
/// Where bodice and skirt meet: the waist [m].
const WAIST: f32 = 1.075;

/// Signed distance to the solid inside the dress.
pub fn solid(anatomy: &Anatomy, skirt: &Turned, p: Vec3) -> f32 {
    let below = skirt.distance(p) + 0.5 * (p.y - SKIRT.top + 0.03).max(0.0);
    melt(anatomy.trunk(p) - GAP, below, 0.02)
}

/// The dress.
pub fn make(anatomy: &Anatomy, skin: &Skin) -> Garment {
    const SMOOTHING: usize = 4;
    let skirt = Turned::around(anatomy, SKIRT);
    let field = |p: Vec3| solid(anatomy, &skirt, p);
    let hem = |p: Vec3| SKIRT.hem - p.y;
    let neck = |p: Vec3| -scoop(p, vec3(0.0, 1.465, 0.020), vec3(0.079, 0.125, 0.138));
    let armhole = |p: Vec3| {
        // Away from the arm, and on the shoulder no wider than a strap.
        let strap = p.x.abs() - STRAP - 0.5 * (SHOULDER.y - p.y).max(0.0);
        if p.y < 1.15 { -0.1 } else { -melt(anatomy.arm(p) - ARMHOLE, -strap, 0.03) }
    };
    let fitted = Fitted {
        field: &field,
        lines: &[&hem, &neck, &armhole],
        low: vec3(-0.52, 0.02, -0.52),
        high: vec3(0.52, 1.56, 0.52),
        edge: EDGE,
    };
    let mut mesh = fitted.mesh();
    lay_shoulders(anatomy, &mut mesh, GAP);
    let room = |p: &Vec3| ((WAIST - p.y) / (WAIST - SKIRT.hem)).clamp(0.0, 1.0).powf(0.8);
    let mixed = mesh.positions.iter().map(|&p| {
        let (body, free) = (skin.copied(p), super::weights::skirt(p));
        let below = step(1.12, 1.00, p.y);
        std::array::from_fn(|k| body[k] + (free[k] - body[k]) * below)
    });
    let making = Making {
        name: "Dress",
        color: [0.035, 0.16, 0.17],
        extras: json!({
            "cloth": { "material": "satin", "layer": 1, "thickness": 0.004 },
            "cloth.max_distance": [0.0, 1.2],
            "collision_filters": 0,
        }),
        maps: vec![(MAX_DISTANCE, mesh.positions.iter().map(room).collect())],
        uvs: uvs(&mesh, 0.2),
        shares: mesh.smoothed(mixed.collect(), SMOOTHING),
    };
    making.garment(mesh)
}
