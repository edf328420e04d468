//! Triangle meshes while they are made.

use glam::Vec3;

/// A triangle mesh.
#[derive(Default, Clone)]
pub struct Mesh {
    /// Positions [m].
    pub positions: Vec<Vec3>,
    /// Triangles; fronts are counter-clockwise.
    pub triangles: Vec<[u32; 3]>,
}

/// An edge and the triangles beside it: the first two, and how many there are.
#[derive(Clone, Copy)]
pub struct Edge {
    pub ends: [u32; 2],
    pub beside: [u32; 2],
    pub count: u32,
}

/// For each vertex a list: triangles or neighbours.
pub struct Lists {
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl Lists {
    /// The list of a vertex.
    pub fn of(&self, vertex: u32) -> &[u32] {
        &self.items[self.starts[vertex as usize] as usize..self.starts[vertex as usize + 1] as usize]
    }

    fn new(count: usize, pairs: impl Iterator<Item = (u32, u32)>) -> Self {
        let mut pairs: Vec<(u32, u32)> = pairs.collect();
        pairs.sort_unstable();
        pairs.dedup();
        let mut starts = vec![0; count + 1];
        for &(vertex, _) in &pairs {
            starts[vertex as usize + 1] += 1;
        }
        for i in 0..count {
            starts[i + 1] += starts[i];
        }
        Self { starts, items: pairs.into_iter().map(|(_, item)| item).collect() }
    }
}

impl Mesh {
    /// All edges, in the order of their ends.
    pub fn edges(&self) -> Vec<Edge> {
        let mut sides: Vec<(u32, u32, u32)> = Vec::with_capacity(self.triangles.len() * 3);
        for (t, &[a, b, c]) in self.triangles.iter().enumerate() {
            for (p, q) in [(a, b), (b, c), (c, a)] {
                sides.push((p.min(q), p.max(q), t as u32));
            }
        }
        sides.sort_unstable();
        let mut edges: Vec<Edge> = Vec::with_capacity(sides.len() / 2);
        for (a, b, t) in sides {
            match edges.last_mut() {
                Some(edge) if edge.ends == [a, b] => {
                    if edge.count == 1 {
                        edge.beside[1] = t;
                    }
                    edge.count += 1;
                }
                _ => edges.push(Edge { ends: [a, b], beside: [t, t], count: 1 }),
            }
        }
        edges
    }

    /// Triangles around each vertex.
    pub fn around(&self) -> Lists {
        let corners = self.triangles.iter().enumerate().flat_map(|(t, triangle)| triangle.map(|v| (v, t as u32)));
        Lists::new(self.positions.len(), corners)
    }

    /// Neighbours of each vertex.
    pub fn neighbors(&self) -> Lists {
        let sides = self.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, a), (b, c), (c, b), (c, a), (a, c)]);
        Lists::new(self.positions.len(), sides)
    }

    /// Area-weighted normal of a triangle, twice its area long.
    pub fn normal(&self, triangle: [u32; 3]) -> Vec3 {
        let [a, b, c] = triangle.map(|v| self.positions[v as usize]);
        (b - a).cross(c - a)
    }

    /// Unit normals of the vertices, weighted by angles.
    pub fn normals(&self) -> Vec<Vec3> {
        let mut normals = vec![Vec3::ZERO; self.positions.len()];
        for &t in &self.triangles {
            let n = self.normal(t).normalize_or_zero();
            for k in 0..3 {
                let [a, b, c] = [t[k], t[(k + 1) % 3], t[(k + 2) % 3]].map(|v| self.positions[v as usize]);
                let angle = (b - a).normalize_or_zero().dot((c - a).normalize_or_zero()).clamp(-1.0, 1.0).acos();
                normals[t[k] as usize] += n * angle;
            }
        }
        normals.into_iter().map(|n| n.normalize_or(Vec3::Y)).collect()
    }

    /// Which vertices lie on a rim.
    pub fn rim(&self) -> Vec<bool> {
        let mut rim = vec![false; self.positions.len()];
        for edge in self.edges().iter().filter(|edge| edge.count != 2) {
            edge.ends.iter().for_each(|&v| rim[v as usize] = true);
        }
        rim
    }

    /// Drops triangles, then vertices that no triangle uses.
    pub fn retain(&mut self, keep: impl Fn(&Self, [u32; 3]) -> bool) {
        let kept: Vec<[u32; 3]> = self.triangles.iter().copied().filter(|&t| keep(self, t)).collect();
        self.triangles = kept;
        let mut place = vec![u32::MAX; self.positions.len()];
        let mut positions = Vec::new();
        for v in self.triangles.iter_mut().flatten() {
            let slot = &mut place[*v as usize];
            if *slot == u32::MAX {
                *slot = positions.len() as u32;
                positions.push(self.positions[*v as usize]);
            }
            *v = *slot;
        }
        self.positions = positions;
    }

    /// Keeps the largest connected part.
    pub fn keep_largest(&mut self) {
        let neighbors = self.neighbors();
        let mut part = vec![u32::MAX; self.positions.len()];
        let mut sizes: Vec<usize> = Vec::new();
        for first in 0..self.positions.len() as u32 {
            if part[first as usize] != u32::MAX {
                continue;
            }
            let label = sizes.len() as u32;
            let (mut open, mut size) = (vec![first], 0);
            part[first as usize] = label;
            while let Some(v) = open.pop() {
                size += 1;
                for &n in neighbors.of(v) {
                    if part[n as usize] == u32::MAX {
                        part[n as usize] = label;
                        open.push(n);
                    }
                }
            }
            sizes.push(size);
        }
        let largest = (0..sizes.len()).max_by_key(|&label| sizes[label]).unwrap_or(0) as u32;
        self.retain(|_, t| part[t[0] as usize] == largest);
    }

    /// Values averaged with those of neighbours, a number of rounds.
    pub fn smoothed<const N: usize>(&self, mut values: Vec<[f32; N]>, rounds: usize) -> Vec<[f32; N]> {
        let neighbors = self.neighbors();
        for _ in 0..rounds {
            values = (0..values.len())
                .map(|v| {
                    let near = neighbors.of(v as u32);
                    std::array::from_fn(|k| {
                        let sum: f32 = near.iter().map(|&n| values[n as usize][k]).sum();
                        0.5 * values[v][k] + 0.5 * sum / near.len().max(1) as f32
                    })
                })
                .collect();
        }
        values
    }
}
