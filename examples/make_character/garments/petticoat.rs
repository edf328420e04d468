//! The petticoat: under the skirt, a bit shorter and narrower.

use serde_json::json;

use super::turned::{Cut, Turned, uvs};
use super::{Garment, MAX_DISTANCE, Making, skirt, weights};
use crate::anatomy::Anatomy;

/// Its waist is below the hem of a tucked shirt.
const CUT: Cut = Cut { top: 0.962, hem: 0.560, gap: 0.0105, flare_top: 0.950, flare: 0.045, folds: skirt::FOLDS, depth: 0.007 };
const EDGE: f32 = 0.0225;

/// The petticoat.
pub fn make(anatomy: &Anatomy) -> Garment {
    let mesh = Turned::around(anatomy, CUT).mesh(EDGE);
    let making = Making {
        name: "Petticoat",
        color: [0.78, 0.74, 0.66],
        extras: json!({
            "cloth": { "material": "cotton", "layer": 0, "thickness": 0.004 },
            "cloth.max_distance": [0.0, 0.25],
            "collision_filters": 0,
        }),
        maps: vec![(MAX_DISTANCE, skirt::hang(&mesh, CUT.top, CUT.hem))],
        uvs: uvs(&mesh, 0.2),
        shares: mesh.positions.iter().map(|&p| weights::skirt(p)).collect(),
    };
    making.garment(mesh)
}
