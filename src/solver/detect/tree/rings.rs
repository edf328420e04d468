//! Rings: the faces around each leaf, which may fold back over it.

use core::ops::Range;

use glam::Vec3A;

use super::{HUB, IS_LEAF, Leaf, Tree};
use crate::solver::detect::Surface;
use crate::solver::topology::NONE;

impl Tree {
    /// Finds the faces around each leaf; at the hub of a fan only those beside it.
    pub(super) fn find_rings(&mut self, surface: &Surface) {
        let topology = &surface.topology;
        let place = self.places();
        for (i, node) in (0..).zip(&self.nodes).filter(|(_, node)| node.right & IS_LEAF != 0) {
            let (run, first) = (node.run(), self.rings.len());
            for &f in &self.faces[run.clone()] {
                let corners =
                    topology.faces[f as usize].into_iter().map(|v| topology.around(v)).filter(|edges| edges.len() <= HUB);
                let around = corners.flatten().map(|&(_, e)| e);
                for e in topology.face_edges[f as usize].into_iter().chain(around) {
                    for &f in topology.edge_faces[e as usize].iter().filter(|&&f| f != NONE) {
                        let f = place[f as usize];
                        if !run.contains(&(f as usize)) && !self.rings[first..].contains(&f) {
                            self.rings.push(f);
                        }
                    }
                }
            }
            let cover = self.cover(run, &self.rings[first..]);
            self.leaves.push(Leaf { node: i, cover, ring: first as u32..self.rings.len() as u32, axis: Vec3A::ZERO });
        }
    }

    /// The smallest node that holds a run of `faces` and some others.
    fn cover(&self, run: Range<usize>, others: &[u32]) -> u32 {
        let first = others.iter().map(|&i| i as usize).fold(run.start, usize::min);
        let last = others.iter().map(|&i| i as usize).fold(run.end - 1, usize::max);
        let mut node = 0;
        while self.nodes[node].right & IS_LEAF == 0 {
            let right = self.nodes[node].right as usize;
            let border = self.faces_below(right).start;
            node = if last < border {
                node + 1
            } else if first >= border {
                right
            } else {
                break;
            };
        }
        node as u32
    }
}
