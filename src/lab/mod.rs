//! A laboratory for fabrics: tests of textile standards on simulated cloth, each against a solution that is known. Free of the engine.
//!
//! The `fabric_lab` example prints them for every preset; tests hold the presets to them.

pub mod cantilever;
pub mod drape;
pub mod extension;
pub mod heart;

use std::sync::Arc;

use glam::Vec3;

use crate::scenes::{Scene, SceneCloth};
use crate::solver::rest::{RestShape, SourceMesh};
use crate::solver::settings::Fabric;

/// Frames per second of the tests [Hz], unless they say otherwise.
pub const FRAME_RATE: f32 = 60.0;

/// Speed below which a specimen lies still [m/s].
pub const STILL: f32 = 1.0e-3;

/// Drape coefficient that each preset is to show [%], within 5: of measured fabrics of that name; that of rubber is theory, and shows less on coarse meshes.
pub const DRAPES: [(&str, f32); 7] = [
    ("cotton", 65.0),
    ("silk", 35.0),
    ("wool", 52.0),
    ("denim", 82.0),
    ("washed_denim", 70.0),
    ("leather", 65.0),
    ("rubber", 46.0),
];

/// Least drag of a specimen [1/s].
const DRAG: f32 = 2.0;

/// Bending length `c = (B / (ρ g))^(1/3)` [m].
#[must_use]
pub fn bending_length(fabric: &Fabric) -> f32 {
    (fabric.bend_stiffness / (fabric.density * 9.81)).cbrt()
}

/// Substeps per second [Hz] with which the tests of a mesh with edges of `edge` [m] run: twice as many as it needs to drape as its fabric does.
#[must_use]
pub fn rate(edge: f32) -> f32 {
    (2.0 * crate::solver::settings::drape_rate(edge)).max(360.0)
}

/// A cloth held at the vertices `pins`, alone in still air.
fn specimen(mesh: &SourceMesh, fabric: &Fabric, pins: &[u32], substep_rate: f32) -> Scene {
    let rest = RestShape::build(mesh).map(|(rest, _)| rest).unwrap_or_default();
    // So that it comes to rest soon.
    let fabric = Fabric { drag: fabric.drag.max(DRAG), ..fabric.clone() };
    let mut cloth = SceneCloth::new(Arc::new(rest), fabric, Vec3::ZERO, pins);
    cloth.stepping.substep_rate = substep_rate;
    Scene::new(vec![cloth])
}

/// Steps until nothing was faster than [`STILL`] for a quarter of a second, for `longest` [s] at most.
fn settle(scene: &mut Scene, frame_rate: f32, longest: f32) {
    let mut before: Vec<Vec3> = Vec::new();
    let mut still_for = 0.0;
    while scene.time < longest && still_for < 0.25 {
        before.clear();
        before.extend(scene.cloths[0].state.positions.iter().map(|x| x.truncate()));
        scene.step(1.0 / frame_rate);
        let ways = scene.cloths[0].state.positions.iter().zip(&before).map(|(x, old)| x.truncate().distance(*old));
        let slow = ways.fold(0.0, f32::max) * frame_rate < STILL;
        still_for = if slow { still_for + 1.0 / frame_rate } else { 0.0 };
    }
}

/// Position [m] of a vertex of the mesh.
fn vertex(scene: &Scene, vertex: u32) -> Vec3 {
    let cloth = &scene.cloths[0];
    cloth.state.positions[cloth.rest.particle_of_vertex[vertex as usize] as usize].truncate()
}
