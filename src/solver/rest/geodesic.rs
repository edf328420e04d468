//! Distances along the surface at rest: Dijkstra with the exact update across an unfolded triangle (Kimmel and Sethian 1998).
//!
//! ```text
//!            w            u and v are settled at distances du, dv. Unfold the triangle into the plane, put the source s where
//!           /|\           it has these distances, and the front reaches w straight across the edge: |w - s|.
//!          / | \
//!         u--+--v
//!            |
//!            s
//! ```

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::Vec3;

use crate::solver::topology::{NONE, Topology};

/// Distance `[m]` to the nearest of some sources, and which it is.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Nearest {
    /// Length of the shortest path found `[m]`; infinite where no path leads.
    pub distance: f32,
    /// The source at its end; [`NONE`] where no path leads.
    pub source: u32,
}

/// Geodesic distance of every particle from the nearest of `sources`, on the surface at `positions` `[m]`.
#[must_use]
pub fn distances(topology: &Topology, positions: &[Vec3], sources: &[u32]) -> Vec<Nearest> {
    let mut front = Front::new(topology.particles as usize);
    front.run(topology, positions, sources, f32::INFINITY);
    front.best
}

/// A front that spreads from some sources; its buffers serve many runs.
#[derive(Clone, Debug)]
pub struct Front {
    best: Vec<Nearest>,
    settled: Vec<bool>,
    reached: Vec<(u32, f32)>,
    heap: BinaryHeap<Reverse<(u32, u32)>>,
}

impl Front {
    /// Buffers for a mesh of `particles` particles.
    #[must_use]
    pub fn new(particles: usize) -> Self {
        Self {
            best: vec![Nearest { distance: f32::INFINITY, source: NONE }; particles],
            settled: vec![false; particles],
            reached: Vec::new(),
            heap: BinaryHeap::new(),
        }
    }

    /// The particles within `limit` `[m]` of a run from `sources`, nearest first, with their distances.
    pub fn run(&mut self, topology: &Topology, positions: &[Vec3], sources: &[u32], limit: f32) -> &[(u32, f32)] {
        for &(p, _) in &self.reached {
            self.best[p as usize] = Nearest { distance: f32::INFINITY, source: NONE };
            self.settled[p as usize] = false;
        }
        self.reached.clear();
        self.heap.clear();
        let Self { best, settled, reached, heap } = self;
        for &s in sources {
            best[s as usize] = Nearest { distance: 0.0, source: s };
            heap.push(Reverse((0, s)));
        }
        while let Some(Reverse((bits, v))) = heap.pop() {
            if settled[v as usize] || f32::from_bits(bits) > best[v as usize].distance {
                continue;
            }
            settled[v as usize] = true;
            reached.push((v, 0.0));
            let at = best[v as usize];
            let mut relax = |w: u32, distance: f32, source: u32, best: &mut [Nearest]| {
                if distance < best[w as usize].distance && distance <= limit {
                    best[w as usize] = Nearest { distance, source };
                    heap.push(Reverse((distance.to_bits(), w)));
                }
            };
            for &(u, edge) in topology.around(v) {
                if !settled[u as usize] {
                    let step = positions[v as usize].distance(positions[u as usize]);
                    relax(u, at.distance + step, at.source, best);
                    continue;
                }
                for face in topology.edge_faces[edge as usize].into_iter().filter(|&f| f != NONE) {
                    let w = topology.opposite(edge, face);
                    if !settled[w as usize] {
                        let corners = [u, v, w].map(|p| positions[p as usize]);
                        if let Some(d) = across(corners, best[u as usize].distance, at.distance) {
                            // Where the fronts of two sources merge, the nearer is the source, and no nearer than it is.
                            let straight = |source: u32| positions[w as usize].distance(positions[source as usize]);
                            let sources = [at.source, best[u as usize].source];
                            let [near, far] = sources.map(straight);
                            let (source, least) = if near <= far { (sources[0], near) } else { (sources[1], far) };
                            relax(w, d.max(least), source, best);
                        }
                    }
                }
            }
        }
        for (p, distance) in reached.iter_mut() {
            *distance = best[*p as usize].distance;
        }
        reached
    }
}

/// Distance of `w` `[m]` when the front comes straight across edge `u v`; `None` when it does not.
fn across([u, v, w]: [Vec3; 3], du: f32, dv: f32) -> Option<f32> {
    let edge = v - u;
    let length = edge.length();
    let axis = edge / length;
    let (wx, wy) = ((w - u).dot(axis), (w - u).reject_from_normalized(axis).length());
    let sx = (du * du - dv * dv + length * length) / (2.0 * length);
    let below = du * du - sx * sx;
    if !(below >= 0.0) {
        return None;
    }
    let sy = -below.sqrt();
    let crossing = sx + (wx - sx) * (-sy) / (wy - sy);
    (0.0..=length).contains(&crossing).then(|| ((wx - sx).powi(2) + (wy - sy).powi(2)).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn on_a_flat_grid_the_distance_is_the_straight_line() {
        let n = 20u32;
        let positions: Vec<Vec3> = (0..=n).flat_map(|i| (0..=n).map(move |j| Vec3::new(i as f32, j as f32, 0.0))).collect();
        let faces = (0..n)
            .flat_map(|i| (0..n).map(move |j| i * (n + 1) + j))
            .flat_map(|a| [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]])
            .collect();
        let topology = Topology::new((n + 1) * (n + 1), faces);
        let found = distances(&topology, &positions, &[0]);
        for (p, nearest) in positions.iter().zip(&found) {
            let error = (nearest.distance - p.length()).abs();
            assert!(error <= 1.0e-3 * p.length(), "{p}: {} for {}", nearest.distance, p.length());
        }
    }

    #[test]
    fn below_a_row_of_sources_each_particle_has_the_one_above_it() {
        for n in [9u32, 40, 50, 64] {
            let at = |i: u32, j: u32| Vec3::new(i as f32 / (n - 1) as f32 - 0.5, -(j as f32) / (n - 1) as f32, 0.0);
            let positions: Vec<Vec3> = (0..n).flat_map(|j| (0..n).map(move |i| at(i, j))).collect();
            let quads = (0..n - 1).flat_map(|j| (0..n - 1).map(move |i| j * n + i));
            let faces = quads.flat_map(|a| [[a, a + 1, a + n], [a + 1, a + n + 1, a + n]]).collect();
            let topology = Topology::new(n * n, faces);
            let sources: Vec<u32> = (0..n).collect();
            for (p, nearest) in positions.iter().zip(distances(&topology, &positions, &sources)) {
                assert!((nearest.distance + p.y).abs() <= 1.0e-3, "{n}: {} at {p}", nearest.distance);
                let aside = (positions[nearest.source as usize].x - p.x).abs();
                assert!(aside <= 0.05 - 0.1 * p.y, "{n}: {aside} m aside at {p}");
            }
        }
    }
}
