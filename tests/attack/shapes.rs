//! Random meshes: sheets, soups, fans, strips, bands with one side, and what is hardly a mesh.

use std::f32::consts::TAU;

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use fastrand::Rng;

use super::wild::{once_in, signed, size, span, vector};

/// Points and triangles, before they are a mesh.
pub struct Parts {
    /// `[m]`
    pub points: Vec<Vec3>,
    /// Coordinates of a texture; none, or one for each point.
    pub uvs: Vec<[f32; 2]>,
    /// Three for each triangle, or a strip; none where points follow each other.
    pub indices: Vec<u32>,
    /// How indices are read.
    pub topology: PrimitiveTopology,
}

impl Parts {
    fn list(points: Vec<Vec3>, indices: Vec<u32>) -> Self {
        Self { points, uvs: Vec::new(), indices, topology: PrimitiveTopology::TriangleList }
    }

    /// As Bevy has it.
    pub fn mesh(&self, wide: bool) -> Mesh {
        let mut mesh = Mesh::new(self.topology, RenderAssetUsages::default());
        let points: Vec<[f32; 3]> = self.points.iter().map(Vec3::to_array).collect();
        mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, points);
        if !self.uvs.is_empty() {
            mesh.insert_attribute(Mesh::ATTRIBUTE_UV_0, self.uvs.clone());
        }
        if !self.indices.is_empty() {
            mesh.insert_indices(if wide {
                Indices::U32(self.indices.clone())
            } else {
                Indices::U16(self.indices.iter().map(|&i| u16::try_from(i).unwrap_or(u16::MAX)).collect())
            });
        }
        mesh
    }
}

/// A sheet in xz with `n` by `m` vertices, `size` wide `[m]`.
pub fn sheet(n: u32, m: u32, size: f32) -> Parts {
    let at = |i: u32, n: u32| i as f32 / (n - 1) as f32;
    let places = (0..n).flat_map(|i| (0..m).map(move |k| (at(i, n), at(k, m))));
    let points = places.clone().map(|(u, v)| Vec3::new(u - 0.5, 0.0, v - 0.5) * size).collect();
    let mut parts = Parts::list(points, quads(n, m));
    parts.uvs = places.map(|(u, v)| [u, v]).collect();
    parts
}

/// Two triangles in each gap of `n` rows of `m` points.
fn quads(n: u32, m: u32) -> Vec<u32> {
    let corner = |i: u32, k: u32| i * m + k;
    let gaps = (0..n - 1).flat_map(|i| (0..m - 1).map(move |k| (i, k)));
    gaps.flat_map(|(i, k)| {
        let [a, b, c, d] = [corner(i, k), corner(i, k + 1), corner(i + 1, k), corner(i + 1, k + 1)];
        [a, b, c, c, b, d]
    })
    .collect()
}

/// A sheet that nothing is wrong with.
pub fn tame(rng: &mut Rng) -> Parts {
    let size = size(rng);
    sheet(rng.u32(3..11), rng.u32(3..11), size)
}

/// Any of the shapes, and its name.
pub fn any(rng: &mut Rng) -> (Parts, &'static str) {
    let size = size(rng);
    let n = rng.u32(3..40);
    let random = |rng: &mut Rng, count: u32, below: u32| (0..count).map(|_| rng.u32(0..below)).collect::<Vec<u32>>();
    match rng.u32(0..15) {
        0 => {
            let points = (0..n).map(|_| vector(rng, size)).collect();
            (Parts::list(points, random(rng, 3 * n, n)), "soup")
        }
        1 => (Parts::list((0..3 * n).map(|_| vector(rng, size)).collect(), Vec::new()), "soup without indices"),
        2 => {
            let rim = (0..n).map(|i| Quat::from_rotation_y(TAU * i as f32 / n as f32) * Vec3::X * size);
            let points = [Vec3::ZERO].into_iter().chain(rim).collect();
            (Parts::list(points, (0..n).flat_map(|i| [0, 1 + i, 1 + (i + 1) % n]).collect()), "fan")
        }
        3 | 4 => {
            let zigzag = |i: u32| Vec3::new(i as f32 / n as f32, 0.0, (i % 2) as f32 * 0.3) * size;
            let mut parts = Parts::list((0..n).map(zigzag).collect(), Vec::new());
            parts.topology = PrimitiveTopology::TriangleStrip;
            if rng.bool() {
                parts.indices = (0..n).map(|i| if once_in(rng, 9) { u32::MAX } else { i }).collect();
            }
            (parts, "strip")
        }
        5 => {
            // A band that is turned by half a turn before its ends are joined.
            let point = |i: u32, side: f32| {
                let turn = TAU * i as f32 / n as f32;
                let across = Quat::from_rotation_z(0.5 * turn) * Vec3::X * side;
                Quat::from_rotation_y(turn) * (Vec3::X + across) * size
            };
            let points = (0..n).flat_map(|i| [point(i, -0.3), point(i, 0.3)]).collect();
            let next = |i: u32| if i + 1 == n { [1, 0] } else { [2 * i + 2, 2 * i + 3] };
            let faces = (0..n).flat_map(|i| {
                let [a, b] = next(i);
                [2 * i, 2 * i + 1, a, a, 2 * i + 1, b]
            });
            (Parts::list(points, faces.collect()), "Moebius band")
        }
        6 => {
            let m = rng.u32(3..9);
            let point = |i: u32, k: u32| {
                Quat::from_rotation_y(TAU * k as f32 / m as f32) * Vec3::new(0.3, i as f32 / n as f32, 0.0) * size
            };
            let points = (0..n).flat_map(|i| (0..m).map(move |k| (i, k))).map(|(i, k)| point(i, k)).collect();
            let faces = (0..n - 1).flat_map(|i| (0..m).map(move |k| (i, k, (k + 1) % m)));
            let faces =
                faces.flat_map(|(i, k, l)| [i * m + k, i * m + l, i * m + m + k, i * m + m + k, i * m + l, i * m + m + l]);
            (Parts::list(points, faces.collect()), "tube")
        }
        7 => {
            // Pages of a book: all faces share one edge.
            let page = |i: u32| Quat::from_rotation_y(TAU * i as f32 / n as f32) * Vec3::new(1.0, 0.5, 0.0) * size;
            let points = [Vec3::ZERO, Vec3::Y * size].into_iter().chain((0..n).map(page)).collect();
            (Parts::list(points, (0..n).flat_map(|i| [0, 1, 2 + i]).collect()), "book")
        }
        8 => {
            let mut parts = sheet(5, 5, size);
            parts.indices.iter_mut().for_each(|i| *i = if once_in(rng, 6) { rng.u32(..) } else { *i });
            (parts, "indices out of range")
        }
        9 => {
            // From a millionth to a million of its size.
            let points = (0..n).map(|_| vector(rng, 1.0) * span(rng, 1.0e-6, 1.0e6) * size).collect();
            (Parts::list(points, random(rng, 3 * n, n)), "all sizes at once")
        }
        10 => {
            let direction = vector(rng, size);
            let points = (0..n).map(|_| direction * rng.u32(0..4) as f32).collect();
            (Parts::list(points, random(rng, 3 * n, n)), "on one line")
        }
        11 => {
            let mut parts = sheet(rng.u32(2..5), rng.u32(2..5), size);
            let twice = parts.indices.clone();
            parts.indices.extend(twice.chunks_exact(3).flat_map(|t| [t[0], t[2], t[1]]));
            (parts, "both sides of each face")
        }
        12 => {
            let count = rng.u32(0..5);
            let points: Vec<Vec3> = (0..count).map(|_| vector(rng, size)).collect();
            let indices = if count == 0 || rng.bool() { Vec::new() } else { random(rng, 3, count) };
            (Parts::list(points, indices), "hardly anything")
        }
        13 => {
            let mut parts = sheet(4, 4, size);
            parts.topology = if rng.bool() { PrimitiveTopology::LineList } else { PrimitiveTopology::PointList };
            (parts, "lines or points")
        }
        _ => {
            let mut parts = sheet(rng.u32(2..12), rng.u32(2..12), size);
            let crumple = size * span(rng, 1.0e-6, 1.0);
            parts.points.iter_mut().for_each(|p| *p += Vec3::new(0.0, signed(rng, crumple), signed(rng, 0.3 * crumple)));
            (parts, "crumpled sheet")
        }
    }
}
