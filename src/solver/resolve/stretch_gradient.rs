//! Curves on which the sum over everything cancels.

use glam::Vec3;

use super::global_gradient::saturate;
use super::mass_split::{load, shares};
use super::view::View;
use super::{ResolveSettings, Resolver};

/// Passes of smoothing along the contour.
const PASSES: usize = 16;
/// Most rings that are moved.
const MOST_RINGS: f32 = 8.0;

impl Resolver {
    /// Like [`Self::follow_global_gradient`], with the gradient summed over a stretch of the contour around each crossing. It
    /// is for curves on which the sum over everything cancels.
    pub(super) fn follow_stretch_gradient(&mut self, view: View<'_>, contour: usize, step: f32, settings: &ResolveSettings) {
        self.patch.gather(view, &self.graph, contour);
        let share = shares([0, 1].map(|s: usize| load(view.positions, self.patch.sides[s].iter().copied())));
        let Self { graph, terms, pulls, smooth, along, displacements, patch, .. } = self;
        let nodes = graph.nodes_of(contour);
        let sign = |i: u32| if graph.side[i as usize] == 0 { 1.0 } else { -1.0 };
        pulls.resize(graph.side.len(), Vec3::ZERO);
        smooth.resize(graph.side.len(), Vec3::ZERO);
        for &i in nodes {
            pulls[i as usize] = sign(i) * terms[i as usize].pull().as_vec3();
        }
        for _ in 0..PASSES {
            for &i in nodes {
                let around: Vec3 = graph.linked(i as usize).map(|j| pulls[j as usize]).sum();
                smooth[i as usize] = pulls[i as usize] * 0.5 + around * 0.25;
            }
            for &i in nodes {
                pulls[i as usize] = smooth[i as usize];
            }
        }
        // A mean over some 2 sqrt(PASSES) crossings, back to a sum.
        let scale = 2.0 * (PASSES as f32).sqrt();
        along.resize(view.surface.len(), Vec3::ZERO);
        for side in 0..2 {
            for &v in &patch.sides[side] {
                along[v as usize] = Vec3::ZERO;
            }
        }
        for &i in nodes {
            let (c, t) = (&view.crossings[i as usize], &terms[i as usize]);
            let side = usize::from(graph.side[i as usize]);
            let d = sign(i) * saturate((pulls[i as usize] * scale).as_dvec3(), step);
            for v in view.surface.topology.edges[c.edge as usize] {
                along[v as usize] += d;
            }
            for v in view.surface.topology.faces[c.face as usize] {
                along[v as usize] -= d;
            }
            for (v, w) in view.surface.topology.edges[c.edge as usize].into_iter().zip([1.0 - c.t, c.t]) {
                displacements.add(v, share[side] * w * (t.r - t.s).as_vec3() * step, share[side] * step);
            }
            for (v, w) in view.surface.topology.faces[c.face as usize].into_iter().zip(c.weights) {
                displacements.add(v, share[1 - side] * w * t.s.as_vec3() * step, share[1 - side] * step);
            }
        }
        let rings = (settings.spread * graph.contours[contour].length / graph.contours[contour].edge).min(MOST_RINGS) as usize;
        patch.grow(view.surface, rings);
        for (side, share) in share.into_iter().enumerate() {
            let ends = &patch.ring_end[side];
            let mut ring = 0;
            for (k, &v) in patch.sides[side].iter().enumerate() {
                while k >= ends[ring] as usize {
                    ring += 1;
                }
                if ring > 0 {
                    // The mean of what the inner ring does.
                    let (mut sum, mut count) = (Vec3::ZERO, 0.0);
                    for &(u, _) in view.surface.topology.around(v) {
                        if patch.order(side, u).is_some_and(|r| r < ring) {
                            sum += along[u as usize];
                            count += 1.0;
                        }
                    }
                    along[v as usize] = sum / f32::max(count, 1.0);
                } else {
                    along[v as usize] = along[v as usize].clamp_length_max(step);
                }
                let fall = 1.0 - ring as f32 / (rings + 1) as f32;
                displacements.add(v, share * fall * along[v as usize], share * step);
            }
        }
    }
}
