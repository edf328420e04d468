//! Damping of springs: the rate at which two ends approach or part decays, momentum stays.
//!
//! Once per frame, `v_b - v_a` along the spring is reduced by `1 - exp(-rate · dt)`, split by mass, as an impulse.

use glam::{Mat4, Vec4};

use super::IS_XYZ;
use crate::solver::rest::{LANES, Springs};

/// Notes the motion of each particle over the last substep: `xyz` `[m]`, `w` its inverse mass `[1/kg]`.
pub(crate) fn note(positions: &[Vec4], previous: &[Vec4], motion: &mut Vec<Vec4>) {
    debug_assert_eq!(positions.len(), previous.len());
    motion.clear();
    motion.extend(positions.iter().zip(previous).map(|(x, old)| Vec4::select(IS_XYZ, *x - *old, *x)));
}

/// Takes over what became of the motion that [`note`] noted: it moves `previous`, where it changed.
pub(crate) fn apply(positions: &[Vec4], motion: &[Vec4], previous: &mut [Vec4]) {
    debug_assert_eq!([positions.len(); 2], [motion.len(), previous.len()]);
    for ((x, old), motion) in positions.iter().zip(previous).zip(motion) {
        *old += Vec4::select(IS_XYZ, (*x - *old) - *motion, Vec4::ZERO);
    }
}

/// Damps every spring over `dt` `[s]` at `rate` `[1/s]`.
pub(crate) fn solve(springs: &Springs, rate: f32, dt: f32, positions: &[Vec4], motion: &mut [Vec4]) {
    let fraction = Vec4::splat(1.0 - (-rate * dt).exp());
    for (a, b) in springs.a.iter().zip(&springs.b) {
        let (ua, ub) = (a.map(|i| motion[i as usize]), b.map(|i| motion[i as usize]));
        let d: [Vec4; LANES] = std::array::from_fn(|l| positions[b[l] as usize] - positions[a[l] as usize]);
        let (d4, u4) = (rows(d), rows(std::array::from_fn(|l| ub[l] - ua[l])));
        let w = rows(std::array::from_fn(|l| ua[l] + ub[l])).w_axis;
        let approach = d4.x_axis * u4.x_axis + d4.y_axis * u4.y_axis + d4.z_axis * u4.z_axis;
        let squared = d4.x_axis * d4.x_axis + d4.y_axis * d4.y_axis + d4.z_axis * d4.z_axis;
        // Nothing where both ends are held.
        let moved = w * squared;
        let impulse = Vec4::select(moved.cmpgt(Vec4::ZERO), approach * fraction / moved, Vec4::ZERO).to_array();
        for lane in 0..LANES {
            let push = Vec4::select(IS_XYZ, d[lane], Vec4::ZERO) * impulse[lane];
            motion[a[lane] as usize] = ua[lane] + push * ua[lane].w;
            motion[b[lane] as usize] = ub[lane] - push * ub[lane].w;
        }
    }
}

#[inline(always)]
fn rows([a, b, c, d]: [Vec4; LANES]) -> Mat4 {
    Mat4::from_cols(a, b, c, d).transpose()
}
