//! Pins: particles that follow targets, moved every substep.

use glam::Vec4;

use crate::solver::step::Anchors;

/// A pin of at least this weight is rigid (dimensionless).
pub const RIGID: f32 = 0.999;

/// Time in which a pin of weight one half pulls its particle to 1/e of the distance [s].
const SOFT_TIME: f32 = 0.1;

/// Moves anchored particles towards their targets at fraction `s` of the frame; rigid ones are put there.
pub fn solve(anchors: &Anchors, s: f32, h: f32, positions: &mut [Vec4]) {
    for (k, &p) in anchors.particles.iter().enumerate() {
        let target = anchors.from[k].lerp(anchors.to[k], s);
        let x = &mut positions[p as usize];
        let weight = anchors.weights[k];
        if weight >= RIGID {
            *x = target.extend(x.w);
        } else {
            let rate = weight / ((1.0 - weight) * SOFT_TIME);
            *x += ((target - x.truncate()) * (1.0 - (-rate * h).exp())).extend(0.0);
        }
    }
}
