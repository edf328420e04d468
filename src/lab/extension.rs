//! The extension tests (FAST-3): a strip under load, by how much its middle third lengthens.
//!
//! ```text
//! ε = T / 4 (1 / G + 1 / K_warp + 1 / K_weft)     at 45° to the threads      T: load per width [N/m]
//! ε = T / K                                       along them
//! ```

use core::f32::consts::{FRAC_PI_2, FRAC_PI_4};

use glam::{Vec2, Vec3Swizzles};

use super::cantilever::{Cut, strip};
use super::{FRAME_RATE, settle, specimen, vertex};
use crate::solver::settings::Fabric;

/// Load on a strip at 45° `[N/m]`.
pub const BIAS_LOAD: f32 = 4.9;
/// Load on a strip along the threads `[N/m]`.
pub const LOAD: f32 = 98.0;

/// Cells across a strip; it is three times as long as wide.
const ACROSS: u32 = 8;
/// Side of a cell `[m]`.
const EDGE: f32 = 0.05;
/// Substeps per second `[Hz]`. A load that is much heavier than the strip is felt through many cells only in many substeps.
const RATE: f32 = 6000.0;

/// What theory says of a strip at 45° (dimensionless).
#[must_use]
pub fn bias_theory(fabric: &Fabric) -> f32 {
    0.25 * BIAS_LOAD * (1.0 / fabric.shear_stiffness + theory(fabric).iter().sum::<f32>() / LOAD)
}

/// How the mesh of a strip lies to its threads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mesh {
    /// Its edges run along them.
    Aligned,
    /// Squares along the strip, whatever its threads do.
    Squares,
    /// The same with every vertex inside shaken by up to a quarter of an edge, from that seed: edges run in all directions.
    Shaken(u64),
}

/// Elongation of a strip at 45° (dimensionless).
#[must_use]
pub fn bias(fabric: &Fabric, mesh: Mesh) -> f32 {
    elongation(&Fabric { warp_angle: 0.0, ..fabric.clone() }, FRAC_PI_4, mesh, BIAS_LOAD)
}

/// What theory says of strips along warp and weft (dimensionless).
#[must_use]
pub fn theory(fabric: &Fabric) -> [f32; 2] {
    let weft = 2.0 * fabric.stretch_stiffness / (1.0 + fabric.stretch_ratio);
    [LOAD / (fabric.stretch_ratio * weft), LOAD / weft]
}

/// Elongation of strips along warp and weft (dimensionless).
#[must_use]
pub fn test(fabric: &Fabric, mesh: Mesh) -> [f32; 2] {
    [0.0, FRAC_PI_2].map(|warp_angle| elongation(&Fabric { warp_angle, ..fabric.clone() }, 0.0, mesh, LOAD))
}

/// Elongation of the middle third of a strip cut at an `angle` to the warp of its texture `[rad]` under `load` `[N/m]`.
fn elongation(fabric: &Fabric, angle: f32, kind: Mesh, load: f32) -> f32 {
    let cut = if kind == Mesh::Aligned && angle != 0.0 { Cut::Bias } else { Cut::Alternating };
    let columns = 3 * ACROSS;
    // As heavy as its load: one far heavier than the strip would need far more substeps.
    let free = Fabric {
        density: load / (9.81 * columns as f32 * EDGE),
        strain_limit: f32::INFINITY,
        tether_scale: f32::INFINITY,
        ..fabric.clone()
    };
    let mut mesh = strip(columns, ACROSS, EDGE, cut);
    // The loaded end near the origin, where a substep's fall is more than rounding.
    mesh.positions.iter_mut().for_each(|x| x.x -= columns as f32 * EDGE);
    if let Mesh::Shaken(seed) = kind {
        shake(&mut mesh.positions, columns, seed);
    }
    let way = Vec2::from_angle(angle);
    mesh.uvs = mesh.positions.iter().map(|x| Vec2::new(way.perp().dot(x.xz()), way.dot(x.xz()))).collect();
    let pins: Vec<u32> = (0..=ACROSS).collect();
    let mut scene = specimen(&mesh, &free, &pins, RATE);
    scene.gravity = glam::Vec3::X * 9.81;
    let row = |i: u32| i * (ACROSS + 1)..(i + 1) * (ACROSS + 1);
    // The load hangs on the last row, half as much on its ends; the middle of the strip bears half of itself, too.
    let load = load - 0.5 * free.density * 9.81 * columns as f32 * EDGE;
    let cloth = &mut scene.cloths[0];
    for v in row(columns) {
        let p = cloth.rest.particle_of_vertex[v as usize] as usize;
        let share = if v == row(columns).start || v + 1 == row(columns).end { 0.5 } else { 1.0 };
        cloth.sim.state.positions[p].w = 9.81 / (load * EDGE * share);
        cloth.sim.state.previous[p].w = cloth.sim.state.positions[p].w;
    }
    settle(&mut scene, FRAME_RATE, 20.0);
    let mean = |i: u32| row(i).map(|v| vertex(&scene, v).x).sum::<f32>() / (ACROSS + 1) as f32;
    (mean(2 * ACROSS) - mean(ACROSS)) / (ACROSS as f32 * EDGE) - 1.0
}

/// Shakes what is inside a strip, except for the rows that are held, measured and loaded.
fn shake(positions: &mut [glam::Vec3], columns: u32, seed: u64) {
    let mut rng = fastrand::Rng::with_seed(seed);
    for i in (1..columns).filter(|i| i % ACROSS != 0) {
        for j in 1..ACROSS {
            let mut by = || 0.25 * EDGE * (2.0 * rng.f32() - 1.0);
            let x = &mut positions[(i * (ACROSS + 1) + j) as usize];
            (x.x, x.z) = (x.x + by(), x.z + by());
        }
    }
}
