//! Damping of springs: the rate at which two ends approach or part decays, momentum stays.
//!
//! Once per frame, `v_b - v_a` along the spring is reduced by `1 - exp(-rate · dt)`, split by mass, as an impulse: it moves `previous`.

use glam::{Mat4, Vec4};

use crate::solver::rest::{LANES, Springs};

const XYZ: Vec4 = Vec4::new(1.0, 1.0, 1.0, 0.0);

/// Damps every spring over `dt` [s] at `rate` [1/s].
pub fn solve(springs: &Springs, rate: f32, dt: f32, positions: &[Vec4], previous: &mut [Vec4]) {
    let fraction = 1.0 - (-rate * dt).exp();
    for (a, b) in springs.a.iter().zip(&springs.b) {
        let (xa, xb) = (a.map(|i| positions[i as usize]), b.map(|i| positions[i as usize]));
        let (oa, ob) = (a.map(|i| previous[i as usize]), b.map(|i| previous[i as usize]));
        let d: [Vec4; LANES] = std::array::from_fn(|l| (xb[l] - xa[l]) * XYZ);
        let u: [Vec4; LANES] = std::array::from_fn(|l| (xb[l] - ob[l]) - (xa[l] - oa[l]));
        let w = Vec4::from_array(std::array::from_fn(|l| xa[l].w + xb[l].w));
        let (d4, u4) =
            (Mat4::from_cols(d[0], d[1], d[2], d[3]).transpose(), Mat4::from_cols(u[0], u[1], u[2], u[3]).transpose());
        let approach = d4.x_axis * u4.x_axis + d4.y_axis * u4.y_axis + d4.z_axis * u4.z_axis;
        let squared = d4.x_axis * d4.x_axis + d4.y_axis * d4.y_axis + d4.z_axis * d4.z_axis;
        let impulse = (approach * fraction / (w * squared).max(Vec4::splat(f32::MIN_POSITIVE))).to_array();
        for lane in 0..LANES {
            let push = d[lane] * impulse[lane];
            previous[a[lane] as usize] = oa[lane] - push * xa[lane].w;
            previous[b[lane] as usize] = ob[lane] + push * xb[lane].w;
        }
    }
}
