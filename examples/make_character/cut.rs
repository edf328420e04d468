//! Cuts a mesh along the line where a function is zero.

use std::collections::BTreeMap;

use glam::Vec3;

use crate::field::gradient;
use crate::mesh::Mesh;

/// Vertices nearer to the line than this share of their shortest edge move onto it.
const SNAP: f32 = 0.34;

/// Splits triangles where a function changes its sign, so that no triangle has both signs.
pub fn split(mesh: &mut Mesh, line: &dyn Fn(Vec3) -> f32, surface: &dyn Fn(Vec3) -> Vec3) {
    let neighbors = mesh.neighbors();
    let mut values: Vec<f32> = mesh.positions.iter().map(|&p| line(p)).collect();
    for v in 0..mesh.positions.len() {
        let at = mesh.positions[v];
        let near = neighbors.of(v as u32);
        if near.iter().all(|&n| (values[n as usize] > 0.0) == (values[v] > 0.0)) {
            continue;
        }
        let shortest = near.iter().map(|&n| mesh.positions[n as usize].distance(at)).fold(f32::INFINITY, f32::min);
        let to = both(line, surface, at);
        if to.distance(at) < SNAP * shortest {
            mesh.positions[v] = to;
            values[v] = 0.0;
        }
    }
    let mut made: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    let old = std::mem::take(&mut mesh.triangles);
    for t in old {
        let crossed = |k: usize| values[t[k] as usize] * values[t[(k + 1) % 3] as usize] < 0.0;
        let Some(first) = (0..3).find(|&k| crossed(k)) else {
            mesh.triangles.push(t);
            continue;
        };
        let mut between = |a: u32, b: u32| {
            *made.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                let [p, q] = [a, b].map(|v| mesh.positions[v as usize]);
                let (s, r) = (values[a as usize], values[b as usize]);
                mesh.positions.push(both(line, surface, p.lerp(q, s / (s - r))));
                (mesh.positions.len() - 1) as u32
            })
        };
        // Crossed edges are a-b, and where the third vertex is not on the line one of the others.
        let (a, b, c) = (t[first], t[(first + 1) % 3], t[(first + 2) % 3]);
        let m = between(a, b);
        let (vb, vc) = (values[b as usize], values[c as usize]);
        let va = values[a as usize];
        if vb * vc < 0.0 {
            let n = between(b, c);
            mesh.triangles.extend([[m, b, n], [a, m, n], [a, n, c]]);
        } else if va * vc < 0.0 {
            let n = between(c, a);
            mesh.triangles.extend([[a, m, n], [m, b, c], [m, c, n]]);
        } else {
            mesh.triangles.extend([[a, m, c], [m, b, c]]);
        }
    }
}

/// Cuts away what is above zero.
pub fn keep_below(mesh: &mut Mesh, line: &dyn Fn(Vec3) -> f32, surface: &dyn Fn(Vec3) -> Vec3) {
    split(mesh, line, surface);
    mesh.retain(|mesh, t| line(t.iter().map(|&v| mesh.positions[v as usize]).sum::<Vec3>() / 3.0) < 0.0);
}

/// A point on the line and on the surface.
pub fn both(line: &dyn Fn(Vec3) -> f32, surface: &dyn Fn(Vec3) -> Vec3, mut p: Vec3) -> Vec3 {
    const STEPS: usize = 4;
    const FARTHEST: f32 = 0.01;
    for _ in 0..STEPS {
        let slope = gradient(line, p);
        let step = slope * (line(p) / slope.length_squared().max(0.01));
        p = surface(p - step.clamp_length_max(FARTHEST));
    }
    p
}
