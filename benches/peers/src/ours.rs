//! `bevy_drape`: the solver alone, as its own tests and benchmarks call it.

use bevy_drape::scenes;

use crate::peer::{FRAME, Peer, Scene};

/// One of the crate's scenes.
pub struct Ours {
    scene: scenes::Scene,
}

impl Ours {
    /// The crate's scene of that name, with its defaults.
    pub fn new(scene: Scene, size: u32) -> Self {
        let scene = match scene {
            Scene::Hang => scenes::hang(size),
            Scene::Ball => scenes::ball(size),
        };
        Self { scene }
    }
}

impl Peer for Ours {
    /// Springs only; bending elements and tethers come on top. A frame that starts overstretched sweeps the springs more than once
    /// per substep and is counted as if it did not.
    fn step(&mut self) -> u64 {
        self.scene.step(FRAME);
        self.scene.cloths.iter().map(|c| c.rest.springs.count as u64 * u64::from(c.report.substeps)).sum()
    }

    fn positions(&self) -> Vec<[f32; 3]> {
        let cloths = self.scene.cloths.iter();
        cloths
            .flat_map(|c| c.rest.particle_of_vertex.iter().map(|&p| c.state.positions[p as usize].truncate().to_array()))
            .collect()
    }

    fn springs(&self) -> Vec<[u32; 2]> {
        let Some(cloth) = self.scene.cloths.first() else { return Vec::new() };
        let mut vertex = vec![0; cloth.state.positions.len()];
        for (v, &particle) in cloth.rest.particle_of_vertex.iter().enumerate() {
            vertex[particle as usize] = v as u32;
        }
        cloth.rest.topology.edges.iter().map(|e| e.map(|p| vertex[p as usize])).collect()
    }
}
