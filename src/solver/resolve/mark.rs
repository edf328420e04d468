//! Which particles belong to a tangle.

use glam::Vec4;

use super::{Resolver, View};
use crate::solver::detect::{Crossing, Surface};
use crate::solver::rest::NONE;

impl Resolver {
    /// Weighs every particle by how much it belongs to a tangle: 1 in the regions and around the contours analysed last, falling to 0
    /// over `rings` rings of neighbours.
    pub fn mark(
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
        for k in 0..self.graph.contours.len() {
            self.patch.gather(view, &self.graph, k);
            for side in 0..2 {
                if self.graph.contours[k].kind.separates() && self.region(view, k, side as u8, NONE).is_some() {
                    for &v in self.flood.region() {
                        self.patch.put(side, v);
                    }
                }
            }
            self.patch.grow(view.surface, rings);
            for side in 0..2 {
                let (particles, ends) = (&self.patch.sides[side], &self.patch.ring_end[side]);
                let mut ring = 0;
                for (i, &v) in particles.iter().enumerate() {
                    while i >= ends[ring] as usize {
                        ring += 1;
                    }
                    let weight = &mut weights[v as usize];
                    *weight = weight.max(1.0 - ring as f32 / (rings + 1) as f32);
                }
            }
        }
    }
}
