//! `bevy_drape`: the solver alone, as its own tests and benchmarks call it.

use drape_scenes::{self as scenes, SceneCloth};
use bevy_drape::solver::evaluate::EvaluateSettings;
use bevy_drape::solver::island::UntangleSettings;

use crate::peer::{FRAME, Peer, Scene, Solved};

/// Tethers of a free particle: one to each island of touching pins, and no more than this.
const TETHERS: u64 = 2;

/// One of the crate's scenes.
pub struct Ours {
    scene: scenes::Scene,
}

impl Ours {
    /// The crate's scene of that name, with its defaults.
    pub fn new(scene: Scene, size: u32) -> Option<Self> {
        let sheet = if scene.has_ball() { scenes::ball(size) } else { scenes::hang(size) };
        let scene = if scene.meets_itself() {
            sheet.untangled(UntangleSettings::default(), EvaluateSettings::default(), true).ok()?
        } else {
            sheet
        };
        Some(Self { scene })
    }
}

impl Peer for Ours {
    fn step(&mut self) -> Solved {
        self.scene.step(FRAME);
        let mut solved = Solved::default();
        for cloth in &self.scene.cloths {
            let substeps = u64::from(cloth.report.substeps);
            let steps = substeps * u64::from(cloth.report.inner_steps);
            let springs = cloth.rest.springs.count as u64 * steps;
            let bending = cloth.rest.bends.count as u64 * steps;
            solved.springs += springs;
            // Tethers hold in every second substep.
            solved.all += springs + bending + tethers(cloth) * substeps / 2;
        }
        solved
    }

    fn positions(&self) -> Vec<[f32; 3]> {
        let cloths = self.scene.cloths.iter();
        cloths
            .flat_map(|c| c.rest.particle_of_vertex.iter().map(|&p| c.sim.state.positions[p as usize].truncate().to_array()))
            .collect()
    }

    fn springs(&self) -> Vec<[u32; 2]> {
        let Some(cloth) = self.scene.cloths.first() else { return Vec::new() };
        let mut vertex = vec![0; cloth.sim.state.positions.len()];
        for (v, &particle) in cloth.rest.particle_of_vertex.iter().enumerate() {
            vertex[particle as usize] = v as u32;
        }
        cloth.rest.topology.edges.iter().map(|e| e.map(|p| vertex[p as usize])).collect()
    }
}

/// Tethers to pins of which no two touch.
fn tethers(cloth: &SceneCloth) -> u64 {
    let pins = cloth.anchors.particles.len() as u64;
    (cloth.sim.state.positions.len() as u64 - pins) * pins.min(TETHERS)
}
