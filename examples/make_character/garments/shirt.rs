//! The shirt: torso and sleeves to the wrist, with a small collar; its hem is tucked into the skirt.

use glam::{Vec3, vec3};
use serde_json::json;

use super::fitted::{Fitted, collar, cuff, upper, uvs};
use super::{BACKSTOP, DRIVE, Garment, MAX_DISTANCE, Making};
use crate::anatomy::Anatomy;
use crate::field::step;
use crate::weights;

/// Gaps to the body [m].
const TORSO: f32 = 0.011;
const SLEEVE: f32 = 0.013;
/// Heights of hem and collar, and length of the sleeve below the elbow [m].
const HEM: f32 = 0.982;
const COLLAR: f32 = 1.492;
const CUFF: f32 = 0.222;
const EDGE: f32 = 0.0183;

/// The shirt.
pub fn make(anatomy: &Anatomy) -> Garment {
    const SMOOTHING: usize = 14;
    let field = |p: Vec3| upper(anatomy, p, TORSO, SLEEVE);
    let hem = |p: Vec3| if p.x.abs() < 0.3 { HEM - p.y } else { -0.1 };
    let neck = |p: Vec3| collar(p, COLLAR);
    let sleeve = |p: Vec3| cuff(anatomy, p, CUFF);
    let fitted = Fitted {
        field: &field,
        lines: &[&hem, &neck, &sleeve],
        low: vec3(-0.62, 0.90, -0.22),
        high: vec3(0.62, 1.60, 0.22),
        edge: EDGE,
    };
    let mesh = fitted.mesh();
    let points = || mesh.positions.iter();
    let room = |&p: &Vec3| {
        let from_collar = step(0.010, 0.070, -neck(p));
        let from_hem = if p.x.abs() < 0.3 { step(0.008, 0.080, -hem(p)) } else { 1.0 };
        let along = anatomy.along_upper_arm(p);
        let arm = step(0.0, 0.03, anatomy.torso(p) - anatomy.arm(p));
        let armhole = 0.25 + 0.75 * step(0.06, 0.22, along) * arm + 0.25 * (1.0 - arm);
        from_collar.min(from_hem) * armhole.min(1.0)
    };
    let making = Making {
        name: "Shirt",
        color: [0.70, 0.72, 0.74],
        extras: json!({
            "cloth": { "material": "cotton", "layer": 0, "thickness": 0.004 },
            "cloth.max_distance": [0.0, 0.06],
            "cloth.drive": [0.0, 4.0],
            "cloth.backstop": [0.0, 0.01],
        }),
        maps: vec![
            (MAX_DISTANCE, points().map(room).collect()),
            (
                DRIVE,
                points()
                    .map(|&p| 1.0 - 0.8 * step(0.05, 0.25, anatomy.along_upper_arm(p)) * step(0.2, 0.3, p.x.abs()))
                    .collect(),
            ),
            (BACKSTOP, points().map(|p| step(0.20, 0.35, p.x.abs())).collect()),
        ],
        uvs: uvs(anatomy, &mesh),
        shares: weights::over(anatomy, &mesh, SMOOTHING),
    };
    making.garment(mesh)
}
