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

use super::{NONE, Topology};

/// Distance [m] to the nearest of some sources, and which it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Length of the shortest path found [m]; infinite where no path leads.
    pub distance: f32,
    /// The source at its end; [`NONE`] where no path leads.
    pub source: u32,
}

/// Geodesic distance of every particle from the nearest of `sources`, on the surface at `positions` [m].
#[must_use]
pub fn distances(topology: &Topology, positions: &[Vec3], sources: &[u32]) -> Vec<Nearest> {
    let n = topology.particles as usize;
    let mut best = vec![Nearest { distance: f32::INFINITY, source: NONE }; n];
    let mut settled = vec![false; n];
    let mut heap: BinaryHeap<Reverse<(u32, u32)>> = BinaryHeap::new();
    for &s in sources {
        best[s as usize] = Nearest { distance: 0.0, source: s };
        heap.push(Reverse((0, s)));
    }
    while let Some(Reverse((bits, v))) = heap.pop() {
        if settled[v as usize] || f32::from_bits(bits) > best[v as usize].distance {
            continue;
        }
        settled[v as usize] = true;
        let at = best[v as usize];
        let mut relax = |w: u32, distance: f32, best: &mut [Nearest]| {
            if distance < best[w as usize].distance {
                best[w as usize] = Nearest { distance, source: at.source };
                heap.push(Reverse((distance.to_bits(), w)));
            }
        };
        for &(u, edge) in topology.around(v) {
            if !settled[u as usize] {
                let step = positions[v as usize].distance(positions[u as usize]);
                relax(u, at.distance + step, &mut best);
                continue;
            }
            for face in topology.edge_faces[edge as usize].into_iter().filter(|&f| f != NONE) {
                let w = topology.opposite(edge, face);
                if !settled[w as usize] {
                    let corners = [u, v, w].map(|p| positions[p as usize]);
                    if let Some(d) = across(corners, best[u as usize].distance, at.distance) {
                        relax(w, d, &mut best);
                    }
                }
            }
        }
    }
    // Two fronts that merge can report less than the way to either source.
    for (i, nearest) in best.iter_mut().enumerate() {
        if nearest.source != NONE {
            nearest.distance = nearest.distance.max(positions[i].distance(positions[nearest.source as usize]));
        }
    }
    best
}

/// Distance of `w` [m] when the front comes straight across edge `u v`; `None` when it does not.
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
}
