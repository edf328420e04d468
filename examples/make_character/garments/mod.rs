//! The garments: each a surface around the body, with weights, maps and what a cloth needs to know.

mod cape;
mod coat;
mod dress;
mod fitted;
mod petticoat;
mod shirt;
mod skirt;
mod turned;
mod weights;

use serde_json::Value;

use crate::anatomy::Anatomy;
use crate::glb::skinned::SkinnedSurface;
use crate::mesh::Mesh;
use crate::weights::{Shares, Skin, strongest};

/// A garment, ready to write.
pub struct Garment {
    pub name: &'static str,
    /// Linear colour.
    pub color: [f32; 3],
    pub surface: SkinnedSurface,
    pub triangles: Vec<[u32; 3]>,
    pub extras: Value,
}

/// What of a garment is not its shape.
struct Making {
    name: &'static str,
    color: [f32; 3],
    extras: Value,
    maps: Vec<(&'static str, Vec<f32>)>,
    uvs: Vec<[f32; 2]>,
    shares: Vec<Shares>,
}

/// The map of how far cloth may be from its skin.
const MAX_DISTANCE: &str = "_CLOTH_MAXDIST";
/// The map of the springs to the skin.
const DRIVE: &str = "_CLOTH_DRIVE";
/// The map of how far cloth may sink behind its skin.
const BACKSTOP: &str = "_CLOTH_BACKSTOP";

impl Making {
    fn garment(self, mesh: Mesh) -> Garment {
        let normals = mesh.normals();
        let (joints, weights) = strongest(&self.shares);
        let surface = SkinnedSurface {
            normals,
            joints,
            weights,
            uvs: self.uvs,
            maps: self.maps,
            positions: mesh.positions,
            ..SkinnedSurface::default()
        };
        Garment { name: self.name, color: self.color, surface, triangles: mesh.triangles, extras: self.extras }
    }
}

/// All garments, from the inner to the outer.
pub fn all(anatomy: &Anatomy, skin: &Skin) -> Vec<Garment> {
    vec![
        petticoat::make(anatomy),
        skirt::make(anatomy),
        shirt::make(anatomy),
        coat::make(anatomy),
        dress::make(anatomy, skin),
        cape::make(anatomy),
    ]
}
