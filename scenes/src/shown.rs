//! What a scene shows, and how often that crosses: every cloth with every other and with itself, pinned cloth included.

use glam::Vec3;

use crate::{Scene, checker};

/// The positions that a frame shows of all cloths `[m]`.
#[derive(Clone, Debug, Default)]
pub struct Picture {
    /// Of every cloth, one after another `[m]`.
    pub positions: Vec<Vec3>,
    /// Particles of each triangle.
    pub faces: Vec<[u32; 3]>,
}

impl Picture {
    /// What a scene shows now.
    #[must_use]
    pub fn of(scene: &Scene) -> Self {
        let mut picture = Self::default();
        for cloth in &scene.cloths {
            let first = picture.positions.len() as u32;
            match cloth.sim.display.held() {
                Some(held) => picture.positions.extend_from_slice(held),
                None => picture.positions.extend(cloth.sim.state.positions.iter().map(|x| x.truncate())),
            }
            picture.faces.extend(cloth.rest.topology.faces.iter().map(|t| t.map(|v| v + first)));
        }
        picture
    }

    /// Edges that cross faces.
    #[must_use]
    pub fn crossings(&self) -> usize {
        checker::crossings(&self.positions, &self.faces).len()
    }
}
