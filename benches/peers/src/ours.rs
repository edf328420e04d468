//! `bevy_drape`: the solver alone, as its own tests and benchmarks call it.

use drape_scenes::{self as scenes, SceneCloth};
use bevy_drape::solver::evaluate::EvaluateSettings;
use bevy_drape::solver::island::UntangleSettings;

use crate::peer::{FRAME, Peer, Scene, Solved};

/// Tethers of a free particle: one to each island of touching pins, and no more than this.
const TETHERS: u64 = 2;

/// A frame that starts with an edge beyond this many strain limits sweeps the springs [`TAUT_SWEEPS`] times in each substep.
const TAUT: f32 = 2.0;
const TAUT_SWEEPS: u64 = 3;

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
        let sweeps: Vec<u64> = self.scene.cloths.iter().map(sweeps).collect();
        self.scene.step(FRAME);
        let mut solved = Solved::default();
        for (cloth, sweeps) in self.scene.cloths.iter().zip(sweeps) {
            let substeps = u64::from(cloth.report.substeps);
            let springs = cloth.rest.springs.count as u64 * sweeps * substeps;
            let bending = cloth.rest.bends.count as u64 * substeps;
            solved.springs += springs;
            solved.all += springs + bending + tethers(cloth) * substeps;
        }
        solved
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

/// Sweeps over the springs in each substep of the next frame.
fn sweeps(cloth: &SceneCloth) -> u64 {
    if cloth.report.worst_edge > 1.0 + TAUT * cloth.fabric.strain_limit { TAUT_SWEEPS } else { 1 }
}

/// Tethers to pins of which no two touch.
fn tethers(cloth: &SceneCloth) -> u64 {
    let pins = cloth.anchors.particles.len() as u64;
    (cloth.state.positions.len() as u64 - pins) * pins.min(TETHERS)
}
