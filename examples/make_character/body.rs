//! The body as one mesh, in the colours of skin, hair, boots and thin clothes.

use glam::{Vec3, vec3};

use crate::anatomy::{Anatomy, folded};
use crate::cut;
use crate::field::{ellipsoid, onto, step};
use crate::head;
use crate::mesh::Mesh;
use crate::nets;
use crate::remesh::Remesh;

/// What a triangle of the body shows.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Region {
    Skin,
    Hair,
    Boots,
    Leggings,
    Top,
}

/// All regions.
pub const REGIONS: [Region; 5] = [Region::Skin, Region::Hair, Region::Boots, Region::Leggings, Region::Top];

/// Size of the cells from which the mesh is made [m].
const CELL: f32 = 0.0058;

/// The mesh of the body and the region of each triangle.
pub fn mesh(anatomy: &Anatomy) -> (Mesh, Vec<Region>) {
    let field = |p: Vec3| anatomy.figure(p);
    let mut mesh = nets::surface(&field, [vec3(-0.75, -0.02, -0.20), vec3(0.75, 1.80, 0.20)], CELL, 2);
    let surface = |p: Vec3| onto(&field, 0.0, p);
    let remesh = Remesh { size: &size, surface: &surface, rim: &surface, rounds: 5 };
    remesh.run(&mut mesh);
    cut::split(&mut mesh, &|p| hair_line(anatomy, p), &surface);
    for line in [boot_line, top_line, armhole, neckline] {
        cut::split(&mut mesh, &|p| line(anatomy, p), &surface);
    }
    let regions = mesh
        .triangles
        .iter()
        .map(|t| region(anatomy, t.iter().map(|&v| mesh.positions[v as usize]).sum::<Vec3>() / 3.0))
        .collect();
    (mesh, regions)
}

/// Wanted length of edges: fine in the face and at the hands [m].
fn size(p: Vec3) -> f32 {
    let body = 0.023;
    let q = folded(p);
    let hand = step(0.50, 0.56, q.x);
    let head = step(1.49, 1.54, q.y);
    let face = head * step(0.02, 0.055, q.z) * step(1.70, 1.66, q.y);
    let foot = step(0.13, 0.07, q.y) * 0.35;
    let fine = body + (0.0075 - body) * hand;
    let fine = fine + (0.0125 - fine) * head;
    let fine = fine + (0.0048 - fine) * face;
    fine + (0.015 - fine) * foot
}

fn hair_line(anatomy: &Anatomy, p: Vec3) -> f32 {
    if p.y < 1.48 { 1.0 } else { head::hair(folded(p)) - anatomy.flesh(p) }
}

fn boot_line(anatomy: &Anatomy, p: Vec3) -> f32 {
    if p.y > 0.25 { 1.0 } else { anatomy.shoe(p) - anatomy.leg(p) }
}

/// Where leggings meet the top: at the waist.
fn top_line(_: &Anatomy, p: Vec3) -> f32 {
    if p.x.abs() > 0.3 { 1.0 } else { p.y - 1.0 }
}

/// Above zero on the arm.
fn armhole(anatomy: &Anatomy, p: Vec3) -> f32 {
    if p.y < 1.1 && p.x.abs() < 0.3 { -1.0 } else { anatomy.torso(p) - anatomy.arm(p).min(anatomy.hand(p)) + 0.026 }
}

/// Below zero within the opening of the neck.
fn neckline(_: &Anatomy, p: Vec3) -> f32 {
    scoop(p, vec3(0.0, 1.465, 0.020), vec3(0.100, 0.142, 0.150))
}

/// The opening of a neck: half an ellipsoid that goes on upward.
pub fn scoop(p: Vec3, centre: Vec3, radii: Vec3) -> f32 {
    ellipsoid(vec3(p.x, p.y.min(centre.y), p.z), centre, radii)
}

fn region(anatomy: &Anatomy, p: Vec3) -> Region {
    if p.y > 1.5 {
        return if hair_line(anatomy, p) < 0.0 { Region::Hair } else { Region::Skin };
    }
    if p.y < 0.25 && boot_line(anatomy, p) < 0.0 {
        return Region::Boots;
    }
    if armhole(anatomy, p) > 0.0 || neckline(anatomy, p) < 0.0 {
        return Region::Skin;
    }
    if p.y < 1.0 { Region::Leggings } else { Region::Top }
}
