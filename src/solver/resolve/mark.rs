//! Which particles belong to a tangle.

use glam::Vec4;

use super::Resolver;
use super::view::View;
use crate::solver::detect::{Crossing, Surface};
use crate::solver::topology::NONE;

impl Resolver {
    /// Weighs every particle by how much it belongs to a tangle. The weight is 1 in the regions and around the contours
    /// analysed last, and falls to 0 over `rings` rings of neighbours.
    pub(crate) fn mark(
        &mut self,
        surface: &Surface,
        crossings: &[Crossing],
        positions: &[Vec4],
        rings: usize,
        weights: &mut Vec<f32>,
    ) {
        let view = View { surface, crossings, positions };
        weights.clear();
        weights.resize(view.surface.len(), 0.0);
        // All of them together: what is near one of them is found once, however many there are.
        const ALL: usize = 0;
        self.patch.begin(surface);
        for c in crossings {
            let (edge, face) = (surface.topology.edges[c.edge as usize], surface.topology.faces[c.face as usize]);
            edge.into_iter().chain(face).for_each(|v| self.patch.put(ALL, v));
        }
        for k in 0..self.graph.contours.len() {
            for side in 0..2 {
                self.count_visits();
                let may_ask = self.graph.contours[k].kind.separates() && !self.effort.is_spent();
                if may_ask && self.region(view, k, side, NONE).is_some() {
                    self.flood.region().iter().for_each(|&v| self.patch.put(ALL, v));
                }
            }
        }
        self.patch.grow(surface, rings);
        for (v, ring) in self.patch.by_ring(ALL) {
            weights[v as usize] = 1.0 - ring as f32 / (rings + 1) as f32;
        }
    }
}
