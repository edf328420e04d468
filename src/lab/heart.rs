//! The heart loop test (ASTM D1388 B), for limp fabrics: both ends of a strip clamped together, pointing up.
//!
//! ```text
//!     .-.   .-.
//!    (   \ /   )      l: from the clamp down to the lowest point, over the length of the strip
//!     \   |   /          by the elastica (Peirce 1930; Plaut 2015)
//!      '-.|.-'
//! ```

use core::f32::consts::PI;

use glam::vec3;

use super::cantilever::{Cut, strip};
use super::{FRAME_RATE, bending_length, hold, settle, specimen};
use crate::solver::settings::Fabric;

/// Length of the strip over the bending length, and `l` over that length.
const ELASTICA: [(f32, f32); 8] =
    [(2.71, 0.145), (3.42, 0.156), (4.31, 0.175), (5.31, 0.205), (6.69, 0.252), (8.43, 0.309), (10.0, 0.349), (12.6, 0.391)];

/// What theory says of `l` over the length of a strip `length` times as long as the bending length.
#[must_use]
pub fn theory(length: f32) -> f32 {
    let pair = ELASTICA.windows(2).find(|pair| length < pair[1].0).unwrap_or(&ELASTICA[6..]);
    pair[0].1 + (pair[1].1 - pair[0].1) * (length - pair[0].0) / (pair[1].0 - pair[0].0)
}

/// `l` over the length of a strip of `cells` edges, of which `length` times the bending length is free.
#[must_use]
pub fn test(fabric: &Fabric, length: f32, cells: u32, substep_rate: f32) -> f32 {
    // The hinges at the last held rows bend for half a cell more.
    let free = length * bending_length(fabric);
    let edge = free / (cells - 1) as f32;
    let long = free + edge;
    let mesh = strip(cells, (0.025 / edge).round().max(2.0) as u32, edge, Cut::Alternating);
    // Held by its last edges.
    let held = |v: &u32| !(1.01 * edge..long - 1.01 * edge).contains(&mesh.positions[*v as usize].x);
    let pins: Vec<u32> = (0..mesh.positions.len() as u32).filter(held).collect();
    let mut scene = specimen(&mesh, fabric, &pins, substep_rate);
    let cloth = &mut scene.cloths[0];
    // Up, over on an arc of 270°, and straight to the middle below; the other half mirrored.
    let clamp = edge;
    let radius = (0.5 * long - clamp) / (1.5 * PI + 1.0);
    let place = |s: f32| {
        let t = s.min(long - s) - clamp;
        let turn = (t / radius).clamp(0.0, 1.5 * PI);
        let straight = (t - 1.5 * PI * radius).max(0.0);
        let x = radius * (1.0 - turn.cos()) - straight;
        let y = radius * turn.sin() + t.min(0.0);
        (if s > 0.5 * long { -x } else { x }, y)
    };
    for (x, rest) in cloth.sim.state.positions.iter_mut().zip(&cloth.rest.positions) {
        let (across, up) = place(rest.x);
        *x = vec3(across, up, rest.z).extend(x.w);
    }
    hold(cloth);
    settle(&mut scene, FRAME_RATE, 10.0);
    (-scene.cloths[0].lowest() - 0.5 * edge) / free
}
