//! The skirt: from the waist to the knee, flared, with soft folds.

use serde_json::json;

use super::turned::{Cut, Turned, uvs};
use super::{Garment, MAX_DISTANCE, Making, weights};
use crate::anatomy::Anatomy;
use crate::mesh::Mesh;

/// Folds around; petticoat, skirt and coat have the same, so that they fit into one another.
pub const FOLDS: f32 = 9.0;

const CUT: Cut = Cut { top: 1.060, hem: 0.515, gap: 0.0215, flare_top: 0.990, flare: 0.090, folds: FOLDS, depth: 0.014 };
const EDGE: f32 = 0.0245;
/// Width of the waistband [m].
const BAND: f32 = 0.030;

/// The skirt.
pub fn make(anatomy: &Anatomy) -> Garment {
    let mesh = Turned::around(anatomy, CUT).mesh(EDGE);
    let making = Making {
        name: "Skirt",
        color: [0.30, 0.045, 0.060],
        extras: json!({
            "cloth": { "material": "wool", "layer": 1, "thickness": 0.005 },
            "cloth.max_distance": [0.0, 0.3],
            "collision_filters": 0,
        }),
        maps: vec![(MAX_DISTANCE, hang(&mesh, CUT.top, CUT.hem))],
        uvs: uvs(&mesh, 0.2),
        shares: mesh.positions.iter().map(|&p| weights::skirt(p)).collect(),
    };
    making.garment(mesh)
}

/// 0 in the waistband, 1 at the hem.
pub fn hang(mesh: &Mesh, top: f32, hem: f32) -> Vec<f32> {
    mesh.positions.iter().map(|p| ((top - BAND - p.y) / (top - BAND - hem)).clamp(0.0, 1.0)).collect()
}
