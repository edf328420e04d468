//! Where a shape would lie if it were rigid: the last resort of a cloth that cannot be untangled is its own shape at rest.
//!
//! ```text
//!   A = Σ a (x - x̄)(r - r̄)ᵀ        R maximizes tr(Rᵀ A):  R ← exp(Σ Rᵢ × Aᵢ / (|Σ Rᵢ · Aᵢ| + ε)) R
//! ```
//!
//! Müller, Bender, Chentanez and Macklin 2016, *A robust method to extract the rotational part of deformations*.

use glam::{DMat3, DQuat, DVec3, Vec3, Vec4};

use super::rest::RestShape;

/// Iterations of the rotation; from any start it is found to a thousandth.
const ITERATIONS: usize = 40;

/// Writes the shape at rest, rotated and moved to fit `positions` `[m]` best, weighed by area.
pub(crate) fn fit(rest: &RestShape, positions: &[Vec4], fitted: &mut Vec<Vec3>) {
    fitted.clear();
    if positions.len() != rest.positions.len() {
        return;
    }
    let at = |k: usize| positions[k].truncate().as_dvec3();
    let from = |k: usize| rest.positions[k].as_dvec3();
    let area = |k: usize| f64::from(rest.areas[k]);
    let all = || 0..positions.len();
    let total: f64 = all().map(area).sum();
    let mean = |of: &dyn Fn(usize) -> DVec3| all().map(|k| area(k) * of(k)).sum::<DVec3>() / total;
    let (now, then) = (mean(&at), mean(&from));
    let mut covariance = DMat3::ZERO;
    for k in all() {
        let (x, r) = (area(k) * (at(k) - now), from(k) - then);
        covariance += DMat3::from_cols(x * r.x, x * r.y, x * r.z);
    }
    let mut turn = DQuat::IDENTITY;
    for _ in 0..ITERATIONS {
        let r = DMat3::from_quat(turn);
        let columns = [(r.x_axis, covariance.x_axis), (r.y_axis, covariance.y_axis), (r.z_axis, covariance.z_axis)];
        let across: DVec3 = columns.iter().map(|(r, a)| r.cross(*a)).sum();
        let along: f64 = columns.iter().map(|(r, a)| r.dot(*a)).sum();
        turn = (DQuat::from_scaled_axis(across / (along.abs() + 1.0e-9 * total)) * turn).normalize();
    }
    if turn.is_finite() && now.is_finite() {
        fitted.extend(all().map(|k| (turn * (from(k) - then) + now).as_vec3()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::rest::SourceMesh;

    #[test]
    fn a_shape_that_was_only_moved_is_found_again() {
        let positions = (0..35_u8).map(|i| (f32::from(i / 5), f32::from(i % 5)));
        let positions = positions.map(|(u, v)| Vec3::new(u, 0.7 * v, (0.8 * u).sin())).collect();
        let triangles =
            (0..6).flat_map(|i| (0..4).map(move |j| 5 * i + j)).flat_map(|a| [[a, a + 1, a + 5], [a + 1, a + 6, a + 5]]);
        let mesh = SourceMesh { positions, triangles: triangles.collect(), ..SourceMesh::default() };
        let (rest, _) = RestShape::build(&mesh).expect("a sheet");
        let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 2.0);
        let there: Vec<Vec4> = rest.positions.iter().map(|p| (turn * p.as_dvec3() + DVec3::Y).as_vec3().extend(1.0)).collect();
        let mut fitted = Vec::new();
        fit(&rest, &there, &mut fitted);
        let off = fitted.iter().zip(&there).map(|(a, b)| a.distance(b.truncate())).fold(0.0, f32::max);
        assert!(fitted.len() == there.len() && off < 1.0e-3, "{off} m off");
    }
}
