//! Two ribbons that lie in a loose reef knot and are pulled tight: reef knot of Codimensional IPC (Li et al. 2021).
//!
//! ```text
//!   first   ════╗      ╔═══╗      each loop lies on what comes out of the other,
//!               ╚══════╝   ║      and what comes out goes under the other where they cross
//!               ╔══════╗   ║
//!           ════╝      ╚═══╝      second: the same turned round y
//! ```

use core::f32::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use glam::{Vec3, vec3};

use super::{Scene, SceneCloth, fabric, grid, smooth};
use bevy_drape::solver::rest::RestShape;

/// Width of a ribbon `[m]`.
const WIDTH: f32 = 0.03;
/// How far either half of a ribbon is from the middle line, where it comes out of the other and in its loop `[m]`.
const APART: (f32, f32) = (0.03, 0.08);
/// How high a ribbon goes up and down `[m]`.
const HEIGHT: f32 = 0.025;
/// Where both cross, where a loop begins to close, and where a ribbon ends `[m]`.
const CROSS: f32 = 0.25;
const LOOP: f32 = 0.3;
const END: f32 = 0.55;
/// How far either side is pulled `[m]`, how long that takes `[s]`.
const PULL: (f32, f32) = (0.38, 4.0);

/// The line along the middle of the first ribbon `[m]`, in points a millimetre or two apart, from end to end.
fn line() -> Vec<Vec3> {
    let (narrow, wide) = APART;
    let half = |x: f32| {
        let across = narrow + (wide - narrow) * smooth((x + CROSS) / (2.0 * CROSS));
        let below = if x.abs() < CROSS { (FRAC_PI_2 * x / CROSS).cos().powi(2) } else { 0.0 };
        vec3(x, across, HEIGHT * (1.0 - 2.0 * below))
    };
    let straight = || (0..=800u16).map(|i| half(-END + (END + LOOP) * f32::from(i) / 800.0));
    let round = (1..200u16).map(|i| {
        let (sin, cos) = (PI * f32::from(i) / 200.0).sin_cos();
        vec3(LOOP + wide * sin, wide * cos, HEIGHT)
    });
    let back = straight().rev().map(|p| vec3(p.x, -p.y, p.z));
    straight().chain(round).chain(back).collect()
}

/// The knot: `n` x `n` vertices in all.
#[must_use]
pub fn reef_knot(n: u32) -> Scene {
    let line = line();
    let lengths: Vec<f32> = core::iter::once(0.0)
        .chain(line.windows(2).scan(0.0, |sum, p| {
            *sum += p[0].distance(p[1]);
            Some(*sum)
        }))
        .collect();
    let length = lengths.last().copied().unwrap_or_default();
    let edge = (2.0 * length * WIDTH).sqrt() / n.max(4) as f32;
    let along = |side: f32| (side / edge).round().max(1.0) as u32 + 1;
    let mesh = grid(along(length), along(WIDTH), |u, v| vec3(length * u, 0.0, WIDTH * (v - 0.5)));
    // Where a point of the flat ribbon is in the knot.
    let tied = |flat: Vec3| {
        let next = lengths.partition_point(|l| *l < flat.x).clamp(1, line.len() - 1);
        let share = (flat.x - lengths[next - 1]) / (lengths[next] - lengths[next - 1]);
        let ahead = (line[next] - line[next - 1]).normalize_or_zero();
        let across = (Vec3::Z - ahead * ahead.z).normalize_or_zero();
        line[next - 1].lerp(line[next], share) + across * flat.z
    };
    let (rest, _) = RestShape::build(&mesh).unwrap_or_default();
    let rest = Arc::new(rest);
    let held: Vec<u32> =
        mesh.positions.iter().zip(0..).filter(|(p, _)| p.x < 0.5 * edge || p.x > length - 0.5 * edge).map(|(_, i)| i).collect();
    let ribbon = |side: Vec3| {
        let mut cloth = SceneCloth::new(rest.clone(), fabric(), Vec3::ZERO, &held);
        let at = |p: usize| tied(rest.positions[p]) * side;
        for p in 0..rest.positions.len() {
            cloth.sim.state.positions[p] = at(p).extend(cloth.sim.state.positions[p].w);
        }
        cloth.sim.state.previous.clone_from(&cloth.sim.state.positions);
        cloth.anchors.to = cloth.anchors.particles.iter().map(|&p| at(p as usize)).collect();
        cloth.anchors.from.clone_from(&cloth.anchors.to);
        cloth
    };
    let mut scene = Scene::new(vec![ribbon(Vec3::ONE), ribbon(vec3(-1.0, 1.0, -1.0))]);
    scene.gravity = Vec3::ZERO;
    scene.drive = Some(|scene, time| {
        for (cloth, side) in scene.cloths.iter_mut().zip([-1.0, 1.0]) {
            let (way, lasts) = PULL;
            let x = side * (END + way * smooth(time / lasts));
            cloth.anchors.to.iter_mut().for_each(|to| to.x = x);
        }
    });
    scene
}
