//! A laboratory for fabrics: tests of textile standards on simulated cloth, each against a solution that is known. Free of the
//! engine.
//!
//! The `fabric_lab` example prints them for every preset; tests hold the presets to them.

pub mod cantilever;
pub mod curtain;
pub mod drape;
pub mod extension;
pub mod heart;

use std::sync::Arc;

use glam::Vec3;

use crate::solver::rest::{RestShape, SourceMesh};
use crate::solver::scene::{Scene, SceneCloth};
use crate::solver::settings::Fabric;

/// Frames per second of the tests `[Hz]`, unless they say otherwise.
pub const FRAME_RATE: f32 = 60.0;

/// Speed below which a specimen lies still `[m/s]`.
pub const STILL: f32 = 1.0e-3;

/// What is measured of the fabric that a preset is named after.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Name of the preset.
    pub name: &'static str,
    /// Drape coefficient that it is to show `[%]`.
    pub drape: f32,
    /// How far fabrics of that name differ from it `[%]`.
    pub within: f32,
    /// Thickness of the fabric itself `[m]`, where it is known.
    pub thickness: Option<f32>,
    /// Where that is from.
    pub source: &'static str,
}

/// Every preset. No measurement that may be cited was found of jersey, velvet, fleece, tulle and chiffon, so no preset has
/// their names.
pub const SAMPLES: [Sample; 11] = [
    sample("cotton", 65.0, 6.0, Some(3.0e-4), "between two cottons of 0.114 and 0.192 kg/m², 62 and 70: Gong, Mao, Wang 2024"),
    sample("silk", 35.0, 8.0, None, "a band of 20 to 40, quoted without its source"),
    sample(
        "wool",
        52.0,
        8.0,
        Some(5.7e-4),
        "a band of 40 to 70, quoted without its source; one of 0.274 kg/m² shows 77: Gong, Mao, Wang 2024",
    ),
    sample(
        "denim",
        82.0,
        6.0,
        Some(8.0e-4),
        "a band of 70 to 90, quoted without its source; thickness, shear, friction: J. Textiles 2016, 4614168",
    ),
    sample("washed_denim", 70.0, 8.0, Some(8.0e-4), "the lower end of the band of denims"),
    sample("leather", 65.0, 8.0, Some(9.0e-4), "sheep garment leather, 47 to 70: Memon et al. 2021"),
    sample(
        "rubber",
        46.0,
        5.0,
        Some(5.0e-4),
        "theory: an elastic sheet without friction of a Young's modulus of 1.5 MPa; the preset has 1.8",
    ),
    sample("satin", 56.0, 13.0, None, "satins of 0.19 to 0.30 kg/m², 43 to 70: Fibres and Textiles 1/2018"),
    sample("canvas", 80.0, 6.0, Some(4.8e-4), "plain weave of polyester and cotton, 0.22 kg/m²: Fibres and Textiles 1/2018"),
    sample("faille", 28.0, 5.0, None, "one fabric: Matsudaira et al. 2015"),
    sample("viscose", 15.0, 3.0, None, "one fabric, laid many times: Gong, Mao, Wang 2024"),
];

const fn sample(name: &'static str, drape: f32, within: f32, thickness: Option<f32>, source: &'static str) -> Sample {
    Sample { name, drape, within, thickness, source }
}

/// Least drag of a specimen `[1/s]`.
const DRAG: f32 = 2.0;

/// Bending length `c = (B / (ρ g))^(1/3)` `[m]`.
#[must_use]
pub fn bending_length(fabric: &Fabric) -> f32 {
    (fabric.bend_stiffness / (fabric.density * 9.81)).cbrt()
}

/// Speed at which the tests carry tension along the mesh `[m/s]`, so that what they show is the fabric and not the number of
/// steps.
const SPEED: f32 = 14.0;

/// Substeps per second `[Hz]` of the tests of a mesh with edges of `edge` `[m]`: more than it needs to drape as its fabric
/// does.
#[must_use]
pub fn rate(edge: f32) -> f32 {
    (SPEED / edge).max(360.0)
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

/// Holds the pins of a cloth where its particles are now, and all of it without speed.
fn hold(cloth: &mut SceneCloth) {
    cloth.sim.state.previous.clone_from(&cloth.sim.state.positions);
    cloth.anchors.to = cloth.anchors.particles.iter().map(|&p| cloth.sim.state.positions[p as usize].truncate()).collect();
    cloth.anchors.from.clone_from(&cloth.anchors.to);
}

/// Whether a specimen has come to rest: nothing in it was faster than [`STILL`] for [`LULL`].
#[derive(Debug, Default)]
pub(crate) struct Settling {
    before: Vec<Vec3>,
    still_for: f32,
}

/// How long a specimen lies still before it is judged `[s]`.
const LULL: f32 = 0.25;

impl Settling {
    /// Steps a scene by a frame of `dt` `[s]`; whether it lies still.
    pub(crate) fn step(&mut self, scene: &mut Scene, dt: f32) -> bool {
        self.before.clear();
        self.before.extend(scene.cloths[0].sim.state.positions.iter().map(|x| x.truncate()));
        scene.step(dt);
        let ways = scene.cloths[0].sim.state.positions.iter().zip(&self.before).map(|(x, old)| x.truncate().distance(*old));
        let slow = ways.fold(0.0, f32::max) < STILL * dt;
        self.still_for = if slow { self.still_for + dt } else { 0.0 };
        self.still_for >= LULL
    }
}

/// Steps until a specimen lies still, for `longest` `[s]` at most.
fn settle(scene: &mut Scene, frame_rate: f32, longest: f32) {
    let mut settling = Settling::default();
    let frame_rate = frame_rate.clamp(1.0, 1.0e4);
    for _ in 0..(longest * frame_rate) as u32 {
        if settling.step(scene, 1.0 / frame_rate) {
            return;
        }
    }
}

/// Position `[m]` of a vertex of the mesh.
fn vertex(scene: &Scene, vertex: u32) -> Vec3 {
    let cloth = &scene.cloths[0];
    cloth.sim.state.positions[cloth.rest.particle_of_vertex[vertex as usize] as usize].truncate()
}
