//! Triangles of even size and shape: edges are split, collapsed and flipped, and vertices relaxed, in turns
//! (Botsch and Kobbelt 2004). Rims stay rims, and their corners stay where they are.

use std::collections::BTreeSet;

use glam::Vec3;

use crate::mesh::Mesh;

/// What a mesh should become.
pub struct Remesh<'a> {
    /// Wanted length of edges at a place [m].
    pub size: &'a dyn Fn(Vec3) -> f32,
    /// The point of the surface near a point.
    pub surface: &'a dyn Fn(Vec3) -> Vec3,
    /// The point of the rim near a point.
    pub rim: &'a dyn Fn(Vec3) -> Vec3,
    /// Turns.
    pub rounds: usize,
}

/// Edges longer than this share of the wanted length are split.
const LONG: f32 = 4.0 / 3.0;
/// Edges shorter than this share of it are collapsed.
const SHORT: f32 = 4.0 / 5.0;
/// A rim that turns by more than this has a corner: cosine of the angle.
const CORNER: f32 = 0.77;

impl Remesh<'_> {
    /// Remeshes.
    pub fn run(&self, mesh: &mut Mesh) {
        for _ in 0..self.rounds {
            for _ in 0..3 {
                if self.split(mesh) == 0 {
                    break;
                }
            }
            for _ in 0..4 {
                if self.collapse(mesh) == 0 {
                    break;
                }
            }
            for _ in 0..3 {
                if flip(mesh) == 0 {
                    break;
                }
            }
            for _ in 0..3 {
                self.relax(mesh);
            }
        }
        flip(mesh);
        self.relax(mesh);
    }

    fn wanted(&self, a: Vec3, b: Vec3) -> f32 {
        (self.size)((a + b) / 2.0)
    }

    fn split(&self, mesh: &mut Mesh) -> usize {
        let mut long: Vec<_> = mesh
            .edges()
            .into_iter()
            .filter_map(|edge| {
                let [a, b] = edge.ends.map(|v| mesh.positions[v as usize]);
                let share = a.distance(b) / self.wanted(a, b);
                (share > LONG && edge.count <= 2).then_some((share, edge))
            })
            .collect();
        long.sort_by(|x, y| y.0.total_cmp(&x.0));
        let mut locked = vec![false; mesh.triangles.len()];
        let mut done = 0;
        for (_, edge) in long {
            let beside = &edge.beside[..edge.count as usize];
            if beside.iter().any(|&t| locked[t as usize]) {
                continue;
            }
            let [a, b] = edge.ends;
            let middle = (mesh.positions[a as usize] + mesh.positions[b as usize]) / 2.0;
            let new = mesh.positions.len() as u32;
            mesh.positions.push(if edge.count == 1 { (self.rim)(middle) } else { (self.surface)(middle) });
            for &t in beside {
                let old = mesh.triangles[t as usize];
                mesh.triangles[t as usize] = old.map(|v| if v == b { new } else { v });
                mesh.triangles.push(old.map(|v| if v == a { new } else { v }));
                locked[t as usize] = true;
            }
            done += 1;
        }
        done
    }

    fn collapse(&self, mesh: &mut Mesh) -> usize {
        let edges = mesh.edges();
        let (around, neighbors) = (mesh.around(), mesh.neighbors());
        let rim = mesh.rim();
        let corner = corners(mesh);
        let mut short: Vec<_> = edges
            .into_iter()
            .filter_map(|edge| {
                let [a, b] = edge.ends.map(|v| mesh.positions[v as usize]);
                let share = a.distance(b) / self.wanted(a, b);
                (share < SHORT && edge.count <= 2).then_some((share, edge))
            })
            .collect();
        short.sort_by(|x, y| x.0.total_cmp(&y.0));
        let mut locked = vec![false; mesh.positions.len()];
        let mut gone = vec![false; mesh.triangles.len()];
        let mut done = 0;
        for (_, edge) in short {
            let [mut a, mut b] = edge.ends;
            if locked[a as usize] || locked[b as usize] {
                continue;
            }
            let rims = [rim[a as usize], rim[b as usize]];
            if rims == [true, true] && edge.count != 1 {
                continue;
            }
            if (rims[1] && !rims[0]) || corner[b as usize] {
                std::mem::swap(&mut a, &mut b);
            }
            if corner[b as usize] {
                continue;
            }
            let shared = neighbors.of(a).iter().filter(|n| neighbors.of(b).contains(n));
            // A vertex with three neighbours would be left with two, and its triangles on one another.
            let thin = shared.clone().any(|&n| neighbors.of(n).len() <= 3);
            if thin || shared.count() != edge.count as usize {
                continue;
            }
            let middle = (mesh.positions[a as usize] + mesh.positions[b as usize]) / 2.0;
            let to = if corner[a as usize] || (rim[a as usize] && !rim[b as usize]) {
                mesh.positions[a as usize]
            } else if rim[a as usize] {
                (self.rim)(middle)
            } else {
                (self.surface)(middle)
            };
            let ring = around.of(a).iter().chain(around.of(b));
            let fits = ring.clone().all(|&t| {
                let triangle = mesh.triangles[t as usize];
                if triangle.contains(&a) && triangle.contains(&b) {
                    return true;
                }
                let moved = triangle.map(|v| if v == a || v == b { to } else { mesh.positions[v as usize] });
                let [p, q, r] = moved;
                let normal = (q - p).cross(r - p);
                let longest = p.distance(q).max(q.distance(r)).max(r.distance(p));
                longest < LONG * 1.1 * self.wanted(a_place(mesh, a), to)
                    && normal.length() > 0.2 * longest * longest
                    && normal.normalize_or_zero().dot(mesh.normal(triangle).normalize_or_zero()) > 0.5
            });
            if !fits {
                continue;
            }
            for &t in around.of(b) {
                let triangle = &mut mesh.triangles[t as usize];
                if triangle.contains(&a) {
                    gone[t as usize] = true;
                } else {
                    *triangle = triangle.map(|v| if v == b { a } else { v });
                }
            }
            mesh.positions[a as usize] = to;
            for v in [a, b] {
                locked[v as usize] = true;
                neighbors.of(v).iter().for_each(|&n| locked[n as usize] = true);
            }
            done += 1;
        }
        let kept: Vec<[u32; 3]> = mesh.triangles.iter().zip(&gone).filter(|(_, gone)| !**gone).map(|(t, _)| *t).collect();
        mesh.triangles = kept;
        mesh.retain(|_, _| true);
        done
    }

    fn relax(&self, mesh: &mut Mesh) {
        let neighbors = mesh.neighbors();
        let normals = mesh.normals();
        let (rim, corner) = (mesh.rim(), corners(mesh));
        let beside = rim_neighbors(mesh);
        let old = mesh.positions.clone();
        for v in 0..old.len() {
            if corner[v] {
                continue;
            }
            let at = old[v];
            if rim[v] {
                let [p, q] = beside[v].map(|n| old[n as usize]);
                let along = (q - p).normalize_or_zero();
                let to = at + along * along.dot((p + q) / 2.0 - at) * 0.5;
                mesh.positions[v] = (self.rim)(to);
            } else {
                let near = neighbors.of(v as u32);
                let (mut sum, mut total) = (Vec3::ZERO, 0.0);
                for &n in near {
                    let p = old[n as usize];
                    let weight = p.distance(at) / self.wanted(p, at);
                    sum += p * weight;
                    total += weight;
                }
                let shift = (sum / total - at).reject_from(normals[v]);
                mesh.positions[v] = (self.surface)(at + shift * 0.6);
            }
        }
    }
}

fn a_place(mesh: &Mesh, vertex: u32) -> Vec3 {
    mesh.positions[vertex as usize]
}

/// The two neighbours along the rim of each vertex on it.
fn rim_neighbors(mesh: &Mesh) -> Vec<[u32; 2]> {
    let mut beside = vec![[u32::MAX; 2]; mesh.positions.len()];
    for edge in mesh.edges().iter().filter(|edge| edge.count == 1) {
        for (v, n) in [(edge.ends[0], edge.ends[1]), (edge.ends[1], edge.ends[0])] {
            let slots = &mut beside[v as usize];
            let free = usize::from(slots[0] != u32::MAX);
            slots[free] = n;
        }
    }
    for (v, slots) in beside.iter_mut().enumerate() {
        slots.iter_mut().filter(|slot| **slot == u32::MAX).for_each(|slot| *slot = v as u32);
    }
    beside
}

/// Vertices where the rim turns sharply, or where the mesh is no surface.
fn corners(mesh: &Mesh) -> Vec<bool> {
    let mut corner = vec![false; mesh.positions.len()];
    let rim = mesh.rim();
    for (v, [p, q]) in rim_neighbors(mesh).into_iter().enumerate() {
        if rim[v] {
            let at = mesh.positions[v];
            let [a, b] = [p, q].map(|n| (mesh.positions[n as usize] - at).normalize_or_zero());
            corner[v] = -a.dot(b) < CORNER;
        }
    }
    for edge in mesh.edges().iter().filter(|edge| edge.count > 2) {
        edge.ends.iter().for_each(|&v| corner[v as usize] = true);
    }
    corner
}

/// Turns edges so that vertices have six neighbours, four on a rim.
fn flip(mesh: &mut Mesh) -> usize {
    let rim = mesh.rim();
    let neighbors = mesh.neighbors();
    let mut valence: Vec<i32> = (0..mesh.positions.len()).map(|v| neighbors.of(v as u32).len() as i32).collect();
    let mut locked = vec![false; mesh.triangles.len()];
    let mut made: BTreeSet<[u32; 2]> = BTreeSet::new();
    let mut done = 0;
    for edge in mesh.edges().into_iter().filter(|edge| edge.count == 2) {
        let [s, t] = edge.beside.map(|t| t as usize);
        if locked[s] || locked[t] {
            continue;
        }
        let [a, b] = edge.ends;
        let other = |t: usize| mesh.triangles[t].into_iter().find(|v| ![a, b].contains(v));
        let (Some(c), Some(d)) = (other(s), other(t)) else { continue };
        if c == d || neighbors.of(c).contains(&d) || made.contains(&[c.min(d), c.max(d)]) {
            continue;
        }
        if valence[a as usize] <= 3 || valence[b as usize] <= 3 {
            continue;
        }
        let off = |v: u32, change: i32| (valence[v as usize] + change - if rim[v as usize] { 4 } else { 6 }).pow(2);
        let before = off(a, 0) + off(b, 0) + off(c, 0) + off(d, 0);
        let after = off(a, -1) + off(b, -1) + off(c, 1) + off(d, 1);
        if after >= before {
            continue;
        }
        let flipped = {
            let first = mesh.triangles[s];
            let k = first.iter().position(|&v| v == c).unwrap_or(0);
            let (p, q) = (first[(k + 1) % 3], first[(k + 2) % 3]);
            [[c, p, d], [c, d, q]]
        };
        let normals = [mesh.normal(mesh.triangles[s]).normalize_or_zero(), mesh.normal(mesh.triangles[t]).normalize_or_zero()];
        let new = flipped.map(|f| mesh.normal(f));
        let width = mesh.positions[c as usize].distance_squared(mesh.positions[d as usize]);
        let fits = new.iter().all(|n| {
            let unit = n.normalize_or_zero();
            n.length() > 0.25 * width && unit.dot(normals[0]) > 0.7 && unit.dot(normals[1]) > 0.7
        });
        if !fits {
            continue;
        }
        mesh.triangles[s] = flipped[0];
        mesh.triangles[t] = flipped[1];
        locked[s] = true;
        locked[t] = true;
        made.insert([c.min(d), c.max(d)]);
        for (v, change) in [(a, -1), (b, -1), (c, 1), (d, 1)] {
            valence[v as usize] += change;
        }
        done += 1;
    }
    done
}
