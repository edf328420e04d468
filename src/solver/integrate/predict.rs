//! Where each particle goes if nothing holds it.
//!
//! Leapfrog: velocities live between positions, so the velocity over a substep `h` after one of `h'` grows by `a (h' + h) / 2`.
//! Free fall from rest is then exact at every substep, `x_n = a (n h)² / 2`, and a particle that does not move has no velocity.

use glam::Vec4;

/// Moves free particles by `x + (x - x') · carry + a · push` and remembers `x` in `previous`.
///
/// `carry` = `h / h'` times what drag leaves of a velocity (dimensionless), `push` = `h (h' + h) / 2` `[s²]`.
/// `acceleration` `[m/s²]` holds gravity and wind, one per particle, `w` = 0.
pub(crate) fn predict(positions: &mut [Vec4], previous: &mut [Vec4], acceleration: &[Vec4], carry: f32, push: f32) {
    debug_assert_eq!([positions.len(); 2], [previous.len(), acceleration.len()]);
    let push = Vec4::splat(push);
    let carry = Vec4::splat(carry);
    for ((x, old), &a) in positions.iter_mut().zip(previous).zip(acceleration) {
        let moved = (*x - *old) * carry + a * push;
        *old = *x;
        *x += moved;
    }
}

/// [`predict`] with one acceleration for all particles.
pub(crate) fn predict_uniform(positions: &mut [Vec4], previous: &mut [Vec4], acceleration: Vec4, carry: f32, push: f32) {
    debug_assert_eq!(positions.len(), previous.len());
    let kick = acceleration * push;
    let carry = Vec4::splat(carry);
    for (x, old) in positions.iter_mut().zip(previous) {
        let moved = (*x - *old) * carry + kick;
        *old = *x;
        *x += moved;
    }
}
