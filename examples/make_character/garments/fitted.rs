//! Surfaces at a distance from the body, cut along lines.

use glam::{Vec3, vec3};

use crate::anatomy::{Anatomy, folded};
use crate::cut;
use crate::field::{gradient, melt, onto, step};
use crate::measures::SHOULDER;
use crate::mesh::Mesh;
use crate::nets;
use crate::remesh::Remesh;

use super::turned::polar;

/// Cells from which fitted surfaces are made [m].
const CELL: f32 = 0.010;

/// A surface and the lines at which it ends; a line is above zero where cloth is cut away.
pub struct Fitted<'a> {
    pub field: &'a dyn Fn(Vec3) -> f32,
    pub lines: &'a [&'a dyn Fn(Vec3) -> f32],
    /// Lowest and highest corner of what is looked at [m].
    pub low: Vec3,
    pub high: Vec3,
    /// Length of edges [m].
    pub edge: f32,
}

impl Fitted<'_> {
    /// The mesh.
    pub fn mesh(&self) -> Mesh {
        let surface = |p: Vec3| onto(self.field, 0.0, p);
        let mut mesh = nets::surface(self.field, [self.low, self.high], CELL, usize::MAX);
        mesh.positions = mesh.positions.iter().map(|&p| surface(p)).collect();
        for line in self.lines {
            cut::keep_below(&mut mesh, line, &surface);
        }
        mesh.keep_largest();
        let rim = |p: Vec3| {
            let nearest = self.lines.iter().min_by(|a, b| a(p).abs().total_cmp(&b(p).abs()));
            nearest.map_or(p, |line| cut::both(line, &surface, p))
        };
        let remesh = Remesh { size: &|_| self.edge, surface: &surface, rim: &rim, rounds: 9 };
        remesh.run(&mut mesh);
        mesh
    }
}

/// Lays the shoulders of a garment onto the body at a gap [m]: in the dip between neck and shoulder the field grows too
/// slowly, and cloth at a value of it would float.
pub fn lay_shoulders(anatomy: &Anatomy, mesh: &mut Mesh, gap: f32) {
    let body = |q: Vec3| anatomy.trunk(q);
    for p in &mut mesh.positions {
        let share = step(1.36, 1.41, p.y) * step(0.24, 0.18, p.x.abs());
        if share > 0.0 {
            let below = onto(&body, 0.0, *p);
            *p = p.lerp(below + gradient(&body, below).normalize_or(Vec3::Y) * gap, share);
        }
    }
}

/// Torso, neck and sleeves with gaps to the body, with soft hollows [m].
pub fn upper(anatomy: &Anatomy, p: Vec3, torso: f32, sleeve: f32) -> f32 {
    const ARMPIT: f32 = 0.100;
    const SHOULDER_TOP: f32 = 0.034;
    // Close at the shoulder, looser down the arm.
    let along = anatomy.along_upper_arm(p);
    let sleeve = torso + (sleeve - torso) * step(0.02, 0.14, along) - 0.001 * step(0.10, 0.0, along);
    // A wide fillet below the arm, where cloth folds when arms hang; a narrow one above.
    let above = (folded(p) - SHOULDER).dot(vec3(0.7, 0.7, 0.0));
    let fillet = ARMPIT + (SHOULDER_TOP - ARMPIT) * step(-0.07, 0.02, above);
    melt(melt(anatomy.torso(p), anatomy.neck(p), 0.040) - torso, anatomy.arm(p) - sleeve, fillet)
}

/// How far down the forearm cloth goes beyond a length [m]; below zero far from the forearm.
pub fn cuff(anatomy: &Anatomy, p: Vec3, length: f32) -> f32 {
    if folded(p).x < 0.30 || p.y < 0.85 { -0.1 } else { anatomy.along_lower_arm(p) - length }
}

/// How far a point is above a collar that is higher in the back [m].
pub fn collar(p: Vec3, height: f32) -> f32 {
    if p.x.abs() > 0.2 { -0.1 } else { p.y - height + 0.30 * (p.z + 0.02) }
}

/// Texture coordinates: around trunk or arm, and down [m].
pub fn uvs(anatomy: &Anatomy, mesh: &Mesh) -> Vec<[f32; 2]> {
    mesh.positions
        .iter()
        .map(|&p| {
            if anatomy.arm(p) < anatomy.torso(p) {
                let q = folded(p) - SHOULDER;
                let down = vec3(0.70, -0.72, 0.0);
                let across = q - down * q.dot(down);
                [across.z.atan2(across.x).abs() * 0.05, q.dot(down)]
            } else {
                [polar(p).0.abs() * 0.14, -p.y]
            }
        })
        .collect()
}
