//! The particles on the two sides of a contour, and the rings of neighbours around them.

use crate::solver::detect::Surface;

use super::contour::ContourGraph;
use super::view::View;

/// Most rings around a tangle that move.
pub(super) const MOST_RINGS: usize = 1000;

/// The particles of the two sides of a contour.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Patch {
    seen: Vec<[u32; 2]>,
    /// Ring in which a particle was added to each side.
    ring: Vec<[u16; 2]>,
    now: u16,
    stamp: u32,
    /// Edges and crossings looked at.
    pub visits: usize,
    pub sides: [Vec<u32>; 2],
    /// End of the contour's own particles, then of each ring around them.
    pub ring_end: [Vec<u32>; 2],
}

impl Patch {
    pub(super) fn gather(&mut self, view: View<'_>, graph: &ContourGraph, contour: usize) {
        self.begin(view.surface);
        for &i in graph.nodes_of(contour) {
            let c = &view.crossings[i as usize];
            let side = usize::from(graph.side[i as usize]);
            self.visits += 1;
            for v in view.surface.topology.edges[c.edge as usize] {
                self.put(side, v);
            }
            for v in view.surface.topology.faces[c.face as usize] {
                self.put(1 - side, v);
            }
        }
    }

    /// Forgets all particles and makes room for a surface.
    pub(super) fn begin(&mut self, surface: &Surface) {
        self.seen.resize(surface.len(), [0; 2]);
        self.ring.resize(surface.len(), [0; 2]);
        self.now = 0;
        self.stamp = self.stamp.wrapping_add(1);
        if self.stamp == 0 {
            self.seen.fill([0; 2]);
            self.stamp = 1;
        }
        for side in &mut self.sides {
            side.clear();
        }
    }

    /// Adds rings of neighbours around both sides at once; a particle falls to the side that is nearer.
    pub(super) fn grow(&mut self, surface: &Surface, rings: usize) {
        let mut first = [0; 2];
        for side in 0..2 {
            self.ring_end[side].clear();
            self.ring_end[side].push(self.sides[side].len() as u32);
        }
        for _ in 0..rings {
            self.now += 1;
            for (side, first) in first.iter_mut().enumerate() {
                let last = self.sides[side].len();
                for k in *first..last {
                    let v = self.sides[side][k];
                    let around = surface.topology.around(v);
                    self.visits += around.len();
                    for &(u, _) in around {
                        if self.seen[u as usize][1 - side] != self.stamp {
                            self.put(side, u);
                        }
                    }
                }
                *first = last;
                self.ring_end[side].push(self.sides[side].len() as u32);
            }
        }
    }

    pub(super) fn put(&mut self, side: usize, v: u32) {
        let seen = &mut self.seen[v as usize][side];
        if *seen != self.stamp {
            *seen = self.stamp;
            self.ring[v as usize][side] = self.now;
            self.sides[side].push(v);
        }
    }

    /// The particles of a side with their rings.
    pub(super) fn by_ring(&self, side: usize) -> impl Iterator<Item = (u32, usize)> + '_ {
        self.sides[side].iter().map(move |&v| (v, usize::from(self.ring[v as usize][side])))
    }

    /// The ring of a particle on a side: 0 at the contour itself.
    pub(super) fn order(&self, side: usize, v: u32) -> Option<usize> {
        (self.seen[v as usize][side] == self.stamp).then_some(usize::from(self.ring[v as usize][side]))
    }
}
