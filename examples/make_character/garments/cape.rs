//! The cape: a grid that hangs from the shoulders behind arms, coat and dress, as a sheet drawn taut over them.

use std::f32::consts::PI;

use glam::{Vec3, vec3};
use serde_json::json;

use super::turned::Turned;
use super::{Garment, MAX_DISTANCE, Making, coat, dress, weights};
use crate::anatomy::Anatomy;
use crate::field::{hermite, step};
use crate::mesh::Mesh;
use crate::remesh::Remesh;

/// Places across and down at which the sheet is known.
const COLUMNS: usize = 41;
const SAMPLES: usize = 150;
/// Rows of the grid from which its mesh is made.
const ROWS: usize = 60;
/// Length of edges [m].
const EDGE: f32 = 0.0300;
/// Heights of collar and hem [m].
const TOP: f32 = 1.492;
const HEM: f32 = 0.330;
/// Gap to what is below [m].
const GAP: f32 = 0.013;
/// Where the sheet is where nothing is below it [m].
const FREE: f32 = -0.015;
/// How much the sheet comes forward beside the body, for each metre to the side.
const CURL: f32 = 1.2;
/// Depth of the folds at the hem [m].
const FLUTES: f32 = 0.020;

/// The cape.
pub fn make(anatomy: &Anatomy) -> Garment {
    let mesh = Sheet::over(anatomy).mesh();
    let down = |p: &Vec3| (TOP - p.y) / (TOP - HEM);
    let making = Making {
        name: "Cape",
        color: [0.19, 0.030, 0.022],
        extras: json!({
            "cloth": { "material": "wool", "layer": 2, "thickness": 0.006 },
            "cloth.max_distance": [0.0, 1.0],
        }),
        maps: vec![(MAX_DISTANCE, mesh.positions.iter().map(|p| room(down(p))).collect())],
        uvs: mesh.positions.iter().map(|p| [p.x, TOP - p.y]).collect(),
        shares: mesh.positions.iter().map(|&p| weights::cape(p)).collect(),
    };
    making.garment(mesh)
}

/// 0 in the collar, little on the shoulder blades, 1 at the hem.
fn room(down: f32) -> f32 {
    const COLLAR: f32 = 0.035;
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

/// The sheet as a height behind the figure, over width and height.
struct Sheet {
    depth: Vec<f32>,
}

impl Sheet {
    fn over(anatomy: &Anatomy) -> Self {
        let (lower, skirt) = (Turned::around(anatomy, coat::LOWER), Turned::around(anatomy, dress::SKIRT));
        let below = |p: Vec3| {
            let coat = coat::solid(anatomy, &lower, p);
            if p.y < 1.1 { coat.min(skirt.distance(p)) } else { coat }
        };
        let mut depth = vec![0.0; COLUMNS * SAMPLES];
        for sample in 0..SAMPLES {
            let down = sample as f32 / (SAMPLES - 1) as f32;
            let y = TOP + (HEM - TOP) * down;
            let step = 2.0 * half_width(down) / (COLUMNS - 1) as f32;
            // From the middle out, so that what has nothing below goes on from its neighbour.
            for out in 0..=COLUMNS / 2 {
                for column in [COLUMNS / 2 + out, COLUMNS / 2 - out] {
                    let inner = if column > COLUMNS / 2 { column - 1 } else { column + 1 };
                    let x = step * (column as f32 - (COLUMNS / 2) as f32);
                    let free = if out == 0 { FREE } else { depth[inner * SAMPLES + sample] + CURL * step };
                    depth[column * SAMPLES + sample] = behind(&below, x, y).unwrap_or(free).min(free);
                }
            }
        }
        drawn_taut(&mut depth);
        Self { depth }
    }

    /// The point at shares across, -1 to 1, and down, 0 to 1.
    fn point(&self, across: f32, down: f32) -> Vec3 {
        let (across, down) = (across.clamp(-1.0, 1.0), down.clamp(0.0, 1.0));
        let column = (across + 1.0) / 2.0 * (COLUMNS - 1) as f32;
        let sample = down * (SAMPLES - 1) as f32;
        let (c, r) = ((column as usize).min(COLUMNS - 2), (sample as usize).min(SAMPLES - 2));
        let (s, t) = (column - c as f32, sample - r as f32);
        let at = |c: usize, r: usize| self.depth[c * SAMPLES + r];
        let z = (at(c, r) * (1.0 - s) + at(c + 1, r) * s) * (1.0 - t) + (at(c, r + 1) * (1.0 - s) + at(c + 1, r + 1) * s) * t;
        let flutes = FLUTES * step(0.15, 1.0, down) * (1.0 - (4.0 * PI * across).cos());
        vec3(across * half_width(down), TOP + (HEM - TOP) * down, z - flutes)
    }

    /// The point of the sheet before or behind a point.
    fn onto(&self, p: Vec3) -> Vec3 {
        let down = (TOP - p.y) / (TOP - HEM);
        self.point(p.x / half_width(down.clamp(0.0, 1.0)), down)
    }

    /// The nearest point of its outline.
    fn rim(&self, p: Vec3) -> Vec3 {
        let down = ((TOP - p.y) / (TOP - HEM)).clamp(0.0, 1.0);
        let across = (p.x / half_width(down)).clamp(-1.0, 1.0);
        let side = (1.0 - across.abs()) * half_width(down);
        let (above, below) = (down * (TOP - HEM), (1.0 - down) * (TOP - HEM));
        if side < above.min(below) {
            self.point(across.signum(), down)
        } else {
            self.point(across, if above < below { 0.0 } else { 1.0 })
        }
    }

    /// The sheet with edges of a length [m].
    fn mesh(&self) -> Mesh {
        let mut mesh = Mesh::default();
        for column in 0..COLUMNS {
            let across = 2.0 * column as f32 / (COLUMNS - 1) as f32 - 1.0;
            mesh.positions.extend((0..ROWS).map(|row| self.point(across, row as f32 / (ROWS - 1) as f32)));
        }
        for column in 0..COLUMNS - 1 {
            for row in 0..ROWS - 1 {
                let at = |c: usize, r: usize| (c * ROWS + r) as u32;
                let [a, b, c, d] = [at(column, row), at(column, row + 1), at(column + 1, row + 1), at(column + 1, row)];
                // Fronts face backward, away from the body; diagonals alternate.
                mesh.triangles.extend(if (column + row) % 2 == 0 { [[a, c, b], [a, d, c]] } else { [[a, d, b], [b, d, c]] });
            }
        }
        let remesh = Remesh { size: &|_| EDGE, surface: &|p| self.onto(p), rim: &|p| self.rim(p), rounds: 12 };
        remesh.run(&mut mesh);
        mesh
    }
}

/// Where something is first met on the way from behind [m].
fn behind(below: &dyn Fn(Vec3) -> f32, x: f32, y: f32) -> Option<f32> {
    const FARTHEST: f32 = -0.60;
    let mut z = FARTHEST;
    while z < FREE {
        let gap = below(vec3(x, y, z)) - GAP;
        if gap < 0.0005 {
            return Some(z);
        }
        z += (gap * 0.7).max(0.001);
    }
    None
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
