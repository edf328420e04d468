//! The bias extension test (FAST-3): a strip at 45° to the threads under load, by how much its middle third lengthens.
//!
//! ```text
//! ε = T / 4 (1 / G + 2 / K)        T: load per width [N/m]
//! ```

use super::cantilever::{Cut, strip};
use super::{FRAME_RATE, settle, specimen, vertex};
use crate::solver::settings::Fabric;

/// Load of the test [N/m].
pub const LOAD: f32 = 4.9;

/// Cells across a strip; it is three times as long as wide.
const ACROSS: u32 = 8;
/// Side of a cell [m], and substeps per second [Hz]: a load that is much heavier than the strip is felt through many cells only in many substeps.
const EDGE: f32 = 0.05;
const RATE: f32 = 6000.0;

/// What theory says of the elongation (dimensionless).
#[must_use]
pub fn theory(fabric: &Fabric) -> f32 {
    0.25 * LOAD * (1.0 / fabric.shear_stiffness + 2.0 / fabric.stretch_stiffness)
}

/// Elongation of the middle third of a strip (dimensionless).
#[must_use]
pub fn test(fabric: &Fabric) -> f32 {
    let columns = 3 * ACROSS;
    // Its own weight is not in the formula.
    let heaviest = LOAD / (9.81 * columns as f32 * EDGE);
    let free = Fabric {
        density: fabric.density.min(heaviest),
        strain_limit: f32::INFINITY,
        tether_scale: f32::INFINITY,
        ..fabric.clone()
    };
    let mut mesh = strip(columns, ACROSS, EDGE, Cut::Bias);
    // The loaded end near the origin, where a substep's fall is more than rounding.
    mesh.positions.iter_mut().for_each(|x| x.x -= columns as f32 * EDGE);
    let pins: Vec<u32> = (0..=ACROSS).collect();
    let mut scene = specimen(&mesh, &free, &pins, RATE);
    scene.gravity = glam::Vec3::X * 9.81;
    let row = |i: u32| i * (ACROSS + 1)..(i + 1) * (ACROSS + 1);
    // The load hangs on the last row, half as much on its ends; the strip bears half of itself, too.
    let load = LOAD - 0.5 * free.density * 9.81 * columns as f32 * EDGE;
    let cloth = &mut scene.cloths[0];
    for v in row(columns) {
        let p = cloth.rest.particle_of_vertex[v as usize] as usize;
        let share = if v == row(columns).start || v + 1 == row(columns).end { 0.5 } else { 1.0 };
        cloth.state.positions[p].w = 9.81 / (load * EDGE * share);
        cloth.state.previous[p].w = cloth.state.positions[p].w;
    }
    settle(&mut scene, FRAME_RATE, 20.0);
    let mean = |i: u32| row(i).map(|v| vertex(&scene, v).x).sum::<f32>() / (ACROSS + 1) as f32;
    (mean(2 * ACROSS) - mean(ACROSS)) / (ACROSS as f32 * EDGE) - 1.0
}
