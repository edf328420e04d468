//! The cape: a grid that hangs from the shoulders behind arms, coat and dress, as a sheet drawn taut over them.

use std::f32::consts::PI;

use glam::{Vec3, vec3};
use serde_json::json;

use super::turned::Turned;
use super::{Garment, MAX_DISTANCE, Making, coat, dress, weights};
use crate::anatomy::Anatomy;
use crate::field::{hermite, step};
use crate::mesh::Mesh;

/// Vertices across and down.
const COLUMNS: usize = 29;
const ROWS: usize = 38;
/// Heights from which the columns are resampled.
const SAMPLES: usize = 150;
/// Heights of collar and hem [m].
const TOP: f32 = 1.492;
const HEM: f32 = 0.330;
/// Gap to what is below [m].
const GAP: f32 = 0.013;
/// Where the sheet is where nothing is below it [m].
const FREE: f32 = -0.015;

/// The cape.
pub fn make(anatomy: &Anatomy) -> Garment {
    let mesh = grid(anatomy);
    let place = |i: usize| (i % ROWS) as f32 / (ROWS - 1) as f32;
    let count = mesh.positions.len();
    let making = Making {
        name: "Cape",
        color: [0.19, 0.030, 0.022],
        extras: json!({
            "cloth": { "material": "wool", "layer": 2, "thickness": 0.006 },
            "cloth.max_distance": [0.0, 1.0],
        }),
        maps: vec![(MAX_DISTANCE, (0..count).map(|i| room(place(i))).collect())],
        uvs: (0..count).map(|i| [mesh.positions[i].x, place(i) * (TOP - HEM)]).collect(),
        shares: mesh.positions.iter().map(|&p| weights::cape(p)).collect(),
    };
    making.garment(mesh)
}

/// 0 in the collar, little on the shoulder blades, 1 at the hem.
fn room(down: f32) -> f32 {
    const COLLAR: f32 = 1.5 / (ROWS - 1) as f32;
    ((down - COLLAR) / (1.0 - COLLAR)).max(0.0).powf(1.2)
}

/// Half the width at a share of the height [m].
fn half_width(down: f32) -> f32 {
    const NECK: f32 = 0.090;
    const SHOULDERS: f32 = 0.195;
    const BOTTOM: f32 = 0.420;
    const YOKE: f32 = 0.085;
    if down < YOKE {
        hermite(NECK, SHOULDERS, 0.16, 0.035, down / YOKE)
    } else {
        SHOULDERS + (BOTTOM - SHOULDERS) * ((down - YOKE) / (1.0 - YOKE)).powf(0.95)
    }
}

fn grid(anatomy: &Anatomy) -> Mesh {
    let (lower, skirt) = (Turned::around(anatomy, coat::LOWER), Turned::around(anatomy, dress::SKIRT));
    let below = |p: Vec3| {
        let coat = coat::solid(anatomy, &lower, p);
        if p.y < 1.1 { coat.min(skirt.distance(p)) } else { coat }
    };
    let at =
        |column: usize, sample: usize| (2.0 * column as f32 / (COLUMNS - 1) as f32 - 1.0, sample as f32 / (SAMPLES - 1) as f32);
    let mut depth = vec![0.0; COLUMNS * SAMPLES];
    for column in 0..COLUMNS {
        for sample in 0..SAMPLES {
            let (across, down) = at(column, sample);
            let y = TOP + (HEM - TOP) * down;
            depth[column * SAMPLES + sample] = behind(&below, across * half_width(down), y);
        }
    }
    drawn_taut(&mut depth);
    let mut mesh = Mesh::default();
    for column in 0..COLUMNS {
        let line: Vec<Vec3> = (0..SAMPLES)
            .map(|sample| {
                let (across, down) = at(column, sample);
                let flutes = 0.020 * step(0.15, 1.0, down) * (1.0 - (4.0 * PI * across).cos());
                vec3(across * half_width(down), TOP + (HEM - TOP) * down, depth[column * SAMPLES + sample] - flutes)
            })
            .collect();
        mesh.positions.extend(resampled(&line));
    }
    for column in 0..COLUMNS - 1 {
        for row in 0..ROWS - 1 {
            let at = |c: usize, r: usize| (c * ROWS + r) as u32;
            let [a, b, c, d] = [at(column, row), at(column, row + 1), at(column + 1, row + 1), at(column + 1, row)];
            // Fronts face backward, away from the body; diagonals alternate.
            mesh.triangles.extend(if (column + row) % 2 == 0 { [[a, c, b], [a, d, c]] } else { [[a, d, b], [b, d, c]] });
        }
    }
    mesh
}

/// Where something is first met on the way from behind [m].
fn behind(below: &dyn Fn(Vec3) -> f32, x: f32, y: f32) -> f32 {
    const FARTHEST: f32 = -0.60;
    let mut z = FARTHEST;
    while z < FREE {
        let gap = below(vec3(x, y, z)) - GAP;
        if gap < 0.0005 {
            return z;
        }
        z += (gap * 0.7).max(0.001);
    }
    FREE
}

/// Pulls a sheet straight wherever that moves it away from the body.
fn drawn_taut(depth: &mut [f32]) {
    const ROUNDS: usize = 600;
    for _ in 0..ROUNDS {
        for column in 0..COLUMNS {
            for sample in 1..SAMPLES - 1 {
                let i = column * SAMPLES + sample;
                let down = (depth[i - 1] + depth[i + 1]) / 2.0;
                let mean = if column == 0 || column + 1 == COLUMNS {
                    down
                } else {
                    0.7 * down + 0.15 * (depth[i - SAMPLES] + depth[i + SAMPLES])
                };
                depth[i] = depth[i].min(mean);
            }
        }
    }
}

/// Points at equal distances along a line.
fn resampled(line: &[Vec3]) -> Vec<Vec3> {
    let mut lengths = vec![0.0];
    for pair in line.windows(2) {
        lengths.push(lengths[lengths.len() - 1] + pair[0].distance(pair[1]));
    }
    let whole = lengths[lengths.len() - 1];
    (0..ROWS)
        .map(|row| {
            let want = whole * row as f32 / (ROWS - 1) as f32;
            let i = lengths.partition_point(|&l| l <= want).clamp(1, line.len() - 1) - 1;
            line[i].lerp(line[i + 1], ((want - lengths[i]) / (lengths[i + 1] - lengths[i])).clamp(0.0, 1.0))
        })
        .collect()
}
