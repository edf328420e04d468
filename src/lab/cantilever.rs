//! The cantilever test (ASTM D1388 A): a strip that hangs over an edge under its own weight.
//!
//! ```text
//!   clamp ======----.__          the chord from the clamp to the tip falls to 41.5° where the overhang
//!                      '-.       is 2 c; other overhangs by the elastica, solved once
//! ```

use glam::{Vec2, Vec3, Vec3Swizzles, vec2, vec3};

use super::{FRAME_RATE, bending_length, settle, specimen};
use crate::solver::rest::SourceMesh;
use crate::solver::settings::Fabric;

/// Width of a strip `[m]`.
const WIDTH: f32 = 0.025;

/// Overhang over bending length, and the angle of the chord that it has `[degrees]`.
const ELASTICA: [(f32, f32); 7] = [(0.0, 0.0), (1.0, 7.1), (1.5, 22.2), (2.0, 41.5), (2.5, 56.9), (3.0, 67.0), (4.0, 77.2)];

/// How a strip is cut from the weave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cut {
    /// Along the threads, diagonals all one way.
    Straight,
    /// Along the threads, diagonals turn about.
    Alternating,
    /// Across them at 45°.
    Bias,
}

/// Bending length `[m]` that a strip of the fabric shows with `cells` edges along an overhang of twice the bending length asked
/// for.
#[must_use]
pub fn test(fabric: &Fabric, cells: u32, cut: Cut, substep_rate: f32) -> f32 {
    let edge = 2.0 * bending_length(fabric) / cells as f32;
    let rows = (WIDTH / edge).round().max(2.0) as u32;
    // Two cells are clamped.
    let mesh = strip(cells + 2, rows, edge, cut);
    let clamped = |v: &u32| mesh.positions[*v as usize].x < 2.01 * edge;
    let pins: Vec<u32> = (0..mesh.positions.len() as u32).filter(clamped).collect();
    let mut scene = specimen(&mesh, fabric, &pins, substep_rate);
    settle(&mut scene, FRAME_RATE, 10.0);
    let positions = |v: u32| super::vertex(&scene, v);
    let end = (cells + 2) as f32 * edge;
    let tip: Vec<Vec3> =
        (0..mesh.positions.len() as u32).filter(|v| mesh.positions[*v as usize].x > end - 0.01 * edge).map(positions).collect();
    let tip = tip.iter().sum::<Vec3>() / tip.len() as f32;
    // The hinge at the last clamped row bends for half of what lies between it and the next.
    let clamp = if cut == Cut::Bias { 1.75 } else { 1.5 } * edge;
    let angle = (-tip.y).atan2(tip.x - clamp).to_degrees();
    let beyond = ELASTICA.windows(2).find(|pair| angle < pair[1].1).unwrap_or(&ELASTICA[5..]);
    let [(l0, a0), (l1, a1)] = [beyond[0], beyond[1]];
    (end - clamp) / (l0 + (l1 - l0) * (angle - a0) / (a1 - a0))
}

/// A strip along x of `columns` by `rows` squares of side `edge` `[m]`. Its warp runs along x, or at 45° to it, by its `cut`.
pub(super) fn strip(columns: u32, rows: u32, edge: f32, cut: Cut) -> SourceMesh {
    let mut mesh = SourceMesh::default();
    let at = |i: f32, j: f32| vec3(i * edge, 0.0, (j - 0.5 * rows as f32) * edge);
    for i in 0..=columns {
        mesh.positions.extend((0..=rows).map(|j| at(i as f32, j as f32)));
    }
    for (i, j) in (0..columns).flat_map(|i| (0..rows).map(move |j| (i, j))) {
        let a = i * (rows + 1) + j;
        let (b, c, d) = (a + 1, a + rows + 1, a + rows + 2);
        match cut {
            Cut::Bias => {
                let m = mesh.positions.len() as u32;
                mesh.positions.push(at(i as f32 + 0.5, j as f32 + 0.5));
                mesh.triangles.extend([[a, b, m], [b, d, m], [d, c, m], [c, a, m]]);
            }
            Cut::Alternating if (i + j) % 2 == 1 => mesh.triangles.extend([[a, b, d], [a, d, c]]),
            _ => mesh.triangles.extend([[a, b, c], [b, d, c]]),
        }
    }
    let way = Vec2::from_angle(if cut == Cut::Bias { core::f32::consts::FRAC_PI_4 } else { 0.0 });
    mesh.uvs = mesh.positions.iter().map(|x| vec2(way.perp().dot(x.xz()), way.dot(x.xz()))).collect();
    mesh
}
