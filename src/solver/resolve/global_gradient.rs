//! Contours that get shorter when their two sides move apart, along the gradient of the length.
//!
//! ```text
//!   g = Σ ± G          d = step g / sqrt(|g|² + 1)          every particle of the patch moves by ± its share of d
//! ```
//!
//! `±` by the side of the crossing's edge. The motion falls off over rings around the patch, so that a fine sheet follows
//! instead of holding its contour back.

use glam::{DVec3, Vec3};

use super::mass_split::{load, shares};
use super::patch::MOST_RINGS;
use super::view::View;
use super::{ResolveSettings, Resolver, tracked};

/// `d = step g / sqrt(|g|² + 1)`
pub(super) fn saturate(g: DVec3, step: f32) -> Vec3 {
    (g / (g.length_squared() + 1.0).sqrt()).as_vec3() * step
}

impl Resolver {
    /// Every crossing for itself.
    #[cfg(feature = "research")]
    pub(super) fn follow_each_gradient(&mut self, view: View<'_>, contour: usize, step: f32) {
        for &i in self.graph.nodes_of(contour) {
            let c = &view.crossings[i as usize];
            let edge = view.surface.topology.edges[c.edge as usize];
            let face = view.surface.topology.faces[c.face as usize];
            let [on_edge, on_face] = shares([load(view.positions, edge), load(view.positions, face)]);
            let d = saturate(self.terms[i as usize].pull(), step);
            for v in edge {
                self.displacements.add(v, on_edge * d, on_edge * step);
            }
            for v in face {
                self.displacements.add(v, -on_face * d, on_face * step);
            }
        }
    }

    /// The whole contour as one: summed gradient, uniform over the patch, and the exact vertex gradient.
    pub(super) fn follow_global_gradient(
        &mut self,
        view: View<'_>,
        contour: usize,
        step: f32,
        exact: bool,
        settings: &ResolveSettings,
    ) {
        self.patch.gather(view, &self.graph, contour);
        let share = shares([0, 1].map(|s: usize| load(view.positions, self.patch.sides[s].iter().copied())));
        let mut g = DVec3::ZERO;
        for &i in self.graph.nodes_of(contour) {
            let pull = self.terms[i as usize].pull();
            g += if self.graph.side[i as usize] == 0 { pull } else { -pull };
        }
        let (step, d) = if exact {
            let motion = self.tracked.now[contour].steer(saturate(g, 1.0), settings.pace, tracked::INERTIA);
            (step * self.tracked.now[contour].step_scale, step * motion)
        } else {
            (step, saturate(g, step))
        };
        if exact {
            let longest = self.tracked.now[contour].longest / self.graph.contours[contour].edge;
            let rings = ((settings.spread * longest) as usize).min(MOST_RINGS);
            self.patch.grow(view.surface, rings);
            for (side, share) in share.into_iter().enumerate() {
                let along = if side == 0 { d } else { -d };
                for ring in 0..rings {
                    let fall = 1.0 - (ring + 1) as f32 / (rings + 1) as f32;
                    let ends = &self.patch.ring_end[side];
                    for &v in &self.patch.sides[side][ends[ring] as usize..ends[ring + 1] as usize] {
                        self.displacements.add(v, share * fall * along, share * step);
                    }
                }
            }
        }
        for &i in self.graph.nodes_of(contour) {
            let (c, terms) = (&view.crossings[i as usize], &self.terms[i as usize]);
            let side = usize::from(self.graph.side[i as usize]);
            let (on_edge, on_face) = (share[side], share[1 - side]);
            let along = if side == 0 { d } else { -d };
            let (pull, tilt) =
                if exact { ((terms.r - terms.s).as_vec3() * step, terms.s.as_vec3() * step) } else { (Vec3::ZERO, Vec3::ZERO) };
            for (v, w) in view.surface.topology.edges[c.edge as usize].into_iter().zip([1.0 - c.t, c.t]) {
                self.displacements.add(v, on_edge * (along + w * pull), on_edge * step);
            }
            for (v, w) in view.surface.topology.faces[c.face as usize].into_iter().zip(c.weights) {
                self.displacements.add(v, on_face * (-along + w * tilt), on_face * step);
            }
        }
    }
}
