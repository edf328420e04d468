//! Pins: particles that follow targets, moved every substep.

use glam::Vec4;

use crate::solver::anchors::{Anchors, RIGID};

/// Time in which a pin of weight one half pulls its particle to 1/e of the distance `[s]`.
const SOFT_TIME: f32 = 0.1;

/// Moves anchored particles towards their targets at fraction `s` of the frame, in a step of `h` `[s]`; rigid ones are put
/// there.
pub(crate) fn solve(anchors: &Anchors, s: f32, h: f32, positions: &mut [Vec4]) {
    solve_rigid(anchors, s, positions);
    solve_soft(anchors, s, h, positions);
}

/// Puts rigidly anchored particles where their targets are at fraction `s` of the frame.
pub(crate) fn solve_rigid(anchors: &Anchors, s: f32, positions: &mut [Vec4]) {
    for (k, &p) in anchors.particles.iter().enumerate().filter(|(k, _)| anchors.weights[*k] >= RIGID) {
        let x = &mut positions[p as usize];
        *x = anchors.from[k].lerp(anchors.to[k], s).extend(x.w);
    }
}

/// Moves the others towards theirs, in a step of `h` `[s]`.
pub(crate) fn solve_soft(anchors: &Anchors, s: f32, h: f32, positions: &mut [Vec4]) {
    for (k, &p) in anchors.particles.iter().enumerate().filter(|(k, _)| anchors.weights[*k] < RIGID) {
        let (target, weight) = (anchors.from[k].lerp(anchors.to[k], s), anchors.weights[k]);
        let x = &mut positions[p as usize];
        let rate = weight / ((1.0 - weight) * SOFT_TIME);
        *x += ((target - x.truncate()) * (1.0 - (-rate * h).exp())).extend(0.0);
    }
}
