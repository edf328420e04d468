//! What is left of the motion of two sides into each other is taken out.

use glam::{Vec3, Vec4};

use super::Resolver;
use super::mass_split::{load, shares};
use super::tracked::Strategy;
use super::view::View;

impl Resolver {
    /// Removes the velocity with which the two sides of a contour run deeper into each other, and no other. The exchange is
    /// that of a perfectly inelastic collision along the direction of separation: momentum stays, energy does not grow.
    pub(super) fn stop_approach(&mut self, view: View<'_>, previous: &[Vec4], contour: usize) {
        let tracked = self.tracked.now[contour];
        let out = tracked.mean_direction.normalize_or_zero();
        let first = if tracked.strategy == Strategy::RegionPush && tracked.side == 1 { 1 } else { 0 };
        self.patch.gather(view, &self.graph, contour);
        let velocity = |side: usize| {
            let (mut sum, mut mass) = (Vec3::ZERO, 0.0);
            for &v in &self.patch.sides[side] {
                let v = v as usize;
                let m = if view.positions[v].w > 0.0 { view.positions[v].w.recip() } else { 0.0 };
                sum += m * (view.positions[v] - previous[v]).truncate();
                mass += m;
            }
            if mass > 0.0 { sum / mass } else { Vec3::ZERO }
        };
        let approach = -(velocity(first) - velocity(1 - first)).dot(out);
        if approach.is_nan() || approach <= 0.0 {
            return;
        }
        let share = shares([first, 1 - first].map(|s| load(view.positions, self.patch.sides[s].iter().copied())));
        for (k, side) in [first, 1 - first].into_iter().enumerate() {
            let by = 0.5 * share[k] * approach * if k == 0 { out } else { -out };
            for &v in &self.patch.sides[side] {
                self.approach.add(v, by, 0.0);
            }
        }
    }
}
