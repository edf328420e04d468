//! Rings: the faces around each leaf, which may fold back over it.

use super::shared::{Shared, lowest_above};
use super::{HUB, TreeTopology};
use crate::solver::detect::Surface;
use crate::solver::topology::NONE;

impl TreeTopology {
    /// Finds the faces around each leaf; at the hub of a fan only those beside it.
    pub(super) fn find_rings(&mut self, surface: &Surface, shared: &Shared) {
        let topology = &surface.topology;
        for leaf in &mut self.leaves {
            let (run, first) = (self.branches[leaf.node as usize].run(), self.rings.len());
            for &f in &self.faces[run.clone()] {
                let corners =
                    topology.faces[f as usize].into_iter().map(|v| topology.around(v)).filter(|edges| edges.len() <= HUB);
                let around = corners.flatten().map(|&(_, e)| e);
                for e in topology.face_edges[f as usize].into_iter().chain(around) {
                    for &f in topology.edge_faces[e as usize].iter().filter(|&&f| f != NONE) {
                        let f = shared.place[f as usize];
                        if !run.contains(&(f as usize)) && !self.rings[first..].contains(&f) {
                            self.rings.push(f);
                        }
                    }
                }
            }
            let own = [run.start as u32, run.end.saturating_sub(1) as u32];
            let places = || own.into_iter().chain(self.rings[first..].iter().copied());
            let ends = [places().fold(own[0], u32::min), places().fold(own[1], u32::max)];
            leaf.cover = lowest_above(&self.branches, &shared.ranges, ends);
            leaf.ring = first as u32..self.rings.len() as u32;
        }
    }
}
