//! Meshes that cross themselves, and clothes.

use std::sync::Arc;

use bevy_drape::solver::rest::{RestShape, SourceMesh};
use drape_scenes::{SceneCloth, fabric, grid};
use glam::{DVec3, Vec3, vec3};

/// Positions [m] and faces.
pub type Mesh = (Vec<DVec3>, Vec<[u32; 3]>);

/// A mesh of data that the repository does not hold.
pub fn obj(name: &str) -> Option<Mesh> {
    let text = std::fs::read_to_string(drape_tests::data(name)?).expect("text");
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let c: Vec<f64> = words.map(|w| w.parse().expect("a number")).collect();
                vertices.push(DVec3::new(c[0], c[1], c[2]));
            }
            Some("f") => {
                let index = |w: &str| w.split('/').next().and_then(|i| i.parse::<u32>().ok()).expect("an index") - 1;
                let c: Vec<u32> = words.map(index).collect();
                faces.push([c[0], c[1], c[2]]);
            }
            _ => {}
        }
    }
    Some((vertices, faces))
}

/// Each of its faces as four.
pub fn subdivided((vertices, faces): &Mesh) -> Mesh {
    let (mut all, mut new) = (vertices.clone(), Vec::new());
    let mut middles = std::collections::BTreeMap::new();
    for t in faces {
        let m = [0, 1, 2].map(|k| {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                all.push((vertices[a as usize] + vertices[b as usize]) * 0.5);
                all.len() as u32 - 1
            })
        });
        new.extend([[t[0], m[0], m[2]], [m[0], t[1], m[1]], [m[2], m[1], t[2]], m]);
    }
    (all, new)
}

/// As the solver takes it.
pub fn source((positions, triangles): &Mesh) -> SourceMesh {
    SourceMesh {
        positions: positions.iter().map(|p| p.as_vec3()).collect(),
        triangles: triangles.clone(),
        ..SourceMesh::default()
    }
}

pub fn cloth(mesh: &SourceMesh) -> SceneCloth {
    let (rest, _) = RestShape::build(mesh).expect("a mesh");
    SceneCloth::new(Arc::new(rest), fabric(), Vec3::ZERO, &[])
}

/// A tube of 0.6 m that faces outwards, pinned along its upper rim.
#[derive(Clone, Copy, Default)]
pub struct Tube {
    /// Radius at the top and at the bottom, and by how much it is wider halfway [m].
    pub radii: [f32; 2],
    pub belly: f32,
    /// Share by which it is wider along x at the bottom.
    pub oval: f32,
    /// How far its bottom is off along x [m].
    pub off: f32,
}

impl Tube {
    pub fn mesh(self, n: u32) -> SourceMesh {
        let Self { radii: [top, bottom], belly, oval, off } = self;
        let mut mesh = grid(n, n, |u, v| {
            let (sin, cos) = (core::f32::consts::TAU * u).sin_cos();
            let r = top + (bottom - top) * v + belly * (core::f32::consts::PI * v).sin();
            r * vec3((1.0 + oval * v) * cos, 0.0, sin) + v * vec3(off, -0.6, 0.0)
        });
        let [a, b, c] = mesh.triangles[0].map(|v| mesh.positions[v as usize]);
        if (b - a).cross(c - a).dot((a + b + c).with_y(0.0)) < 0.0 {
            mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        mesh
    }

    pub fn cloth(self, n: u32, layer: i32) -> SceneCloth {
        SceneCloth { garment_layer: layer, ..pinned_above(&self.mesh(n)) }
    }
}

/// A cloth that is pinned where it is highest.
pub fn pinned_above(mesh: &SourceMesh) -> SceneCloth {
    let top = mesh.positions.iter().map(|x| x.y).fold(f32::NEG_INFINITY, f32::max);
    let pins: Vec<u32> = (0..).zip(&mesh.positions).filter(|(_, x)| x.y > top - 1.0e-3).map(|(i, _)| i).collect();
    let (rest, _) = RestShape::build(mesh).expect("a cloth");
    SceneCloth::new(Arc::new(rest), fabric(), Vec3::ZERO, &pins)
}
