//! Surfaces turned around the vertical axis: they follow the body down to its widest place, then fall and flare.
//!
//! ```text
//!   waist  │ │      radius(θ, y) = the widest of the body above y, plus a gap,
//!   hip   ╱   ╲                    plus flare(y), plus folds(y) cos nθ
//!   hem  ╱     ╲
//! ```

use std::f32::consts::{PI, TAU};

use glam::{Vec3, vec3};

use crate::anatomy::Anatomy;
use crate::field::melt;
use crate::mesh::Mesh;
use crate::remesh::Remesh;

/// Directions and heights of the table of radii.
const DIRECTIONS: usize = 96;
const HEIGHTS: usize = 80;
/// The axis passes here: z [m].
const AXIS: f32 = -0.004;

/// How a surface is turned.
#[derive(Clone, Copy)]
pub struct Cut {
    /// Heights of waist and hem [m].
    pub top: f32,
    pub hem: f32,
    /// Gap to the body [m].
    pub gap: f32,
    /// Where the flare begins [m], and how wide it is at the hem [m].
    pub flare_top: f32,
    pub flare: f32,
    /// Folds around, and their depth at the hem [m].
    pub folds: f32,
    pub depth: f32,
}

/// A turned surface.
pub struct Turned {
    cut: Cut,
    radii: Vec<f32>,
}

impl Turned {
    /// Around the body without arms.
    pub fn around(anatomy: &Anatomy, cut: Cut) -> Self {
        let mut radii = vec![0.0; DIRECTIONS * HEIGHTS];
        for direction in 0..DIRECTIONS {
            let angle = TAU * direction as f32 / DIRECTIONS as f32;
            let mut widest = 0.0f32;
            for row in 0..HEIGHTS {
                let y = cut.top + (cut.hem - cut.top) * row as f32 / (HEIGHTS - 1) as f32;
                // Above the widest place the surface follows the body: a waist stays a waist.
                widest = if y > WIDEST {
                    outline(anatomy, angle, y, cut.gap)
                } else {
                    widest.max(outline(anatomy, angle, y, cut.gap))
                };
                radii[row * DIRECTIONS + direction] = widest;
            }
        }
        for _ in 0..ROUNDS {
            radii = smoothed(&radii);
        }
        Self { cut, radii }
    }

    /// The radius in a direction from the front at a height [m].
    pub fn radius(&self, angle: f32, y: f32) -> f32 {
        let row = ((self.cut.top - y) / (self.cut.top - self.cut.hem)).clamp(0.0, 1.0) * (HEIGHTS - 1) as f32;
        let column = (angle / TAU).rem_euclid(1.0) * DIRECTIONS as f32;
        let (r, c) = ((row as usize).min(HEIGHTS - 2), column as usize % DIRECTIONS);
        let (s, t) = (row - r as f32, column - column.floor());
        let at = |r: usize, c: usize| self.radii[r * DIRECTIONS + c % DIRECTIONS];
        let upper = at(r, c) + (at(r, c + 1) - at(r, c)) * t;
        let lower = at(r + 1, c) + (at(r + 1, c + 1) - at(r + 1, c)) * t;
        let below = ((self.cut.flare_top - y) / (self.cut.flare_top - self.cut.hem)).max(0.0);
        let flare = self.cut.flare * below.powf(1.15);
        let folds = self.cut.depth * below.powf(1.3) * (self.cut.folds * angle).cos();
        upper + (lower - upper) * s + flare + folds
    }

    /// Signed distance to the solid inside, below its top.
    pub fn distance(&self, p: Vec3) -> f32 {
        const SLOPE: f32 = 0.90;
        let (angle, radius) = polar(p);
        SLOPE * (radius - self.radius(angle, p.y))
    }

    /// The point of the surface in the same direction at the same height.
    pub fn onto(&self, p: Vec3) -> Vec3 {
        let (angle, _) = polar(p);
        let y = p.y.clamp(self.cut.hem, self.cut.top);
        at(angle, self.radius(angle, y), y)
    }

    /// The point of the waist or the hem.
    pub fn rim(&self, p: Vec3) -> Vec3 {
        let y = if p.y > (self.cut.top + self.cut.hem) / 2.0 { self.cut.top } else { self.cut.hem };
        self.onto(vec3(p.x, y, p.z))
    }

    /// The surface with edges of a length [m].
    pub fn mesh(&self, edge: f32) -> Mesh {
        let length = self.cut.top - self.cut.hem;
        let rows = (length / (edge * 0.9)).round() as usize;
        let columns = (TAU * self.radius(0.7, self.cut.top) / edge).round() as usize;
        let mut mesh = Mesh::default();
        for row in 0..=rows {
            let y = self.cut.top - length * row as f32 / rows as f32;
            for column in 0..columns {
                let angle = TAU * (column as f32 + 0.5 * (row % 2) as f32) / columns as f32;
                mesh.positions.push(at(angle, self.radius(angle, y), y));
            }
        }
        for row in 0..rows {
            for column in 0..columns {
                let at = |r: usize, c: usize| (r * columns + c % columns) as u32;
                let odd = row % 2;
                let [a, b] = [at(row, column), at(row, column + 1)];
                let [c, d] = [at(row + 1, column), at(row + 1, column + 1)];
                mesh.triangles.extend(if odd == 0 { [[a, c, b], [b, c, d]] } else { [[a, c, d], [a, d, b]] });
            }
        }
        let remesh = Remesh { size: &|_| edge, surface: &|p| self.onto(p), rim: &|p| self.rim(p), rounds: 10 };
        remesh.run(&mut mesh);
        mesh
    }
}

/// Where the hips are widest [m].
const WIDEST: f32 = 0.93;
/// Rounds in which the table is smoothed.
const ROUNDS: usize = 3;

/// Direction from the front and radius of a point.
pub fn polar(p: Vec3) -> (f32, f32) {
    let z = p.z - AXIS;
    (p.x.atan2(z), p.x.hypot(z))
}

fn at(angle: f32, radius: f32, y: f32) -> Vec3 {
    vec3(radius * angle.sin(), y, radius * angle.cos() + AXIS)
}

/// How far out the body is, with a gap [m].
fn outline(anatomy: &Anatomy, angle: f32, y: f32, gap: f32) -> f32 {
    const STEP: f32 = 0.002;
    const FARTHEST: f32 = 0.30;
    let outside = |radius: f32| {
        let p = at(angle, radius, y);
        melt(anatomy.torso(p), anatomy.leg(p), 0.06) - gap
    };
    let mut radius = FARTHEST;
    while radius > 0.0 && outside(radius) > 0.0 {
        radius -= STEP;
    }
    let (mut low, mut high) = (radius.max(0.0), radius + STEP);
    for _ in 0..8 {
        let middle = (low + high) / 2.0;
        if outside(middle) > 0.0 { high = middle } else { low = middle }
    }
    high
}

fn smoothed(radii: &[f32]) -> Vec<f32> {
    (0..radii.len())
        .map(|i| {
            let (r, c) = (i / DIRECTIONS, i % DIRECTIONS);
            let at = |r: usize, c: usize| radii[r * DIRECTIONS + c % DIRECTIONS];
            let around = (at(r, c + 1) + at(r, c + DIRECTIONS - 1)) / 2.0;
            let along = (at(r.saturating_sub(1), c) + at((r + 1).min(HEIGHTS - 1), c)) / 2.0;
            // Never nearer to the body than before.
            radii[i].max(0.5 * radii[i] + 0.25 * around + 0.25 * along)
        })
        .collect()
}

/// Texture coordinates: around the figure from the front, the same on both sides, and down [m].
pub fn uvs(mesh: &Mesh, radius: f32) -> Vec<[f32; 2]> {
    mesh.positions.iter().map(|&p| [polar(p).0.abs().min(PI) * radius, -p.y]).collect()
}
