//! The membrane in triangles: stretch along warp and weft, shear between them, on a mesh that is cut in any way.
//!
//! `F = [F_warp F_weft]` is the deformation gradient of a triangle, linear in its corners. Its constraints are those of
//! strain-based dynamics (Müller et al. 2014), with the lengths of Kim 2020, eq. 18. The three store the energy of a fabric
//! whose threads stretch apart from each other:
//!
//! ```text
//! E = ½ A (K_warp C_warp² + K_weft C_weft² + G C_shear²)      A: area at rest
//! C_warp = |F_warp| - 1     C_weft = |F_weft| - 1     C_shear = F_warp · F_weft
//! ```
//!
//! They are solved one after the other, each a constraint of XPBD of compliance `1 / (A K)`. With `a_i = ∂F_warp/∂x_i` and
//! `b_i = ∂F_weft/∂x_i` `[1/m]` all that they do is
//!
//! ```text
//! Δx_i = w_i (a_i P + b_i Q)      ΔF_warp = g_aa P + g_ab Q,  ΔF_weft = g_ab P + g_bb Q      g_ab = Σ w_i a_i b_i
//! ```
//!
//! so that corners are read and written once. `1/|F|` is found as in [springs](super::spring), and has their strain limit.

use glam::{Mat4, Vec4};

use super::rows::Rows;
use super::spring::{Bound, inverse_length};
use crate::solver::rest::{LANES, Membrane};
use crate::solver::scales::LEAST_MOBILITY;
use crate::solver::settings::Fabric;

/// Solves every triangle once in a substep of `h` `[s]`.
pub(crate) fn solve(membrane: &Membrane, fabric: &Fabric, h: f32, positions: &mut [Vec4]) {
    let weft = 2.0 * fabric.stretch_stiffness / (1.0 + fabric.stretch_ratio);
    let compliance = |stiffness: f32| Vec4::splat((stiffness * h * h).max(1.0e-12).recip());
    let [warp, weft, shear] = [fabric.stretch_ratio * weft, weft, fabric.shear_stiffness].map(compliance);
    let (sin, cos) = fabric.warp_angle.sin_cos();
    let (sin, cos) = (Vec4::splat(sin), Vec4::splat(cos));
    let bound = Bound::new(fabric.strain_limit);
    let elements = membrane.corners.iter().zip(&membrane.warp).zip(&membrane.weft).zip(&membrane.inverse_area);
    for (((corners, a), b), &inverse_area) in elements {
        let x = corners.map(|lanes| lanes.map(|p| positions[p as usize]));
        let columns = x.map(|[a, b, c, d]| Mat4::from_cols(a, b, c, d).transpose());
        let row = |k: usize| Rows([columns[k].x_axis, columns[k].y_axis, columns[k].z_axis]);
        let w = columns.map(|m| m.w_axis);
        let (d1, d2) = (row(1) - row(0), row(2) - row(0));
        // The warp of the fabric, turned from that of the texture.
        let [a1, a2] = [0, 1].map(|k| a[k] * cos + b[k] * sin);
        let [b1, b2] = [0, 1].map(|k| b[k] * cos - a[k] * sin);
        let (a, b) = ([-(a1 + a2), a1, a2], [-(b1 + b2), b1, b2]);
        let weigh = |a: &[Vec4; 3], b: &[Vec4; 3]| w[0] * a[0] * b[0] + w[1] * a[1] * b[1] + w[2] * a[2] * b[2];
        let (aa, ab, bb) = (weigh(&a, &a), weigh(&a, &b), weigh(&b, &b));
        let (mut f_warp, mut f_weft) = (d1 * a1 + d2 * a2, d1 * b1 + d2 * b2);

        // What only a corner next to the line of the held ones can change is thrown as far again if it goes half as far.
        let lightest = w[0].max(w[1]).max(w[2]) * LEAST_MOBILITY;
        let least = |a: &[Vec4; 3]| lightest * (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
        let p = f_warp * stretch(f_warp.dot(f_warp), aa.max(least(&a)), warp * inverse_area, bound);
        (f_warp, f_weft) = (f_warp - p * aa, f_weft - p * ab);
        let q = f_weft * stretch(f_weft.dot(f_weft), bb.max(least(&b)), weft * inverse_area, bound);
        (f_warp, f_weft) = (f_warp - q * ab, f_weft - q * bb);
        let sheared = f_warp.dot(f_weft);
        let mobility = aa * f_weft.dot(f_weft) + (ab + ab) * sheared + bb * f_warp.dot(f_warp);
        let r = sheared / (mobility + shear * inverse_area);
        let (p, q) = (p + f_weft * r, q + f_warp * r);

        for k in 0..3 {
            let moves = (p * (w[k] * a[k]) + q * (w[k] * b[k])).columns();
            for lane in 0..LANES {
                positions[corners[k][lane] as usize] = x[k][lane] - moves[lane];
            }
        }
    }
}

/// How much of `F` to take back `[kg·m²]`: its `square`d length (dimensionless), how easily it yields `[1/(kg·m²)]`, and its
/// compliance in the substep `[1/(kg·m²)]`.
#[inline(always)]
fn stretch(square: Vec4, mobility: Vec4, compliance: Vec4, bound: Bound) -> Vec4 {
    let u = inverse_length(square);
    let elastic = (Vec4::splat(2.0 / 3.0) - u) / (mobility + compliance);
    let back = elastic.max(bound.least(u) / mobility);
    // Nothing can move where all corners are held.
    Vec4::select(mobility.cmpgt(Vec4::ZERO), back, Vec4::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::rest::{RestShape, SourceMesh};
    use glam::{Mat2, Quat, Vec2, Vec3, vec2, vec3};

    /// A sheet of triangles that are all unlike, its warp along z.
    fn sheet() -> RestShape {
        let mut mesh = SourceMesh::default();
        let shift = |i: u32, j: u32| 0.003 * (f32::from((i * 7 + j * 3) as u8 % 5) - 2.0);
        for i in 0..5 {
            mesh.positions.extend((0..5).map(|j| vec3(0.02 * i as f32 + shift(i, j), 0.0, 0.02 * j as f32 + shift(j, i + 1))));
        }
        for a in (0..4).flat_map(|i| (0..4).map(move |j| 5 * i + j)) {
            mesh.triangles.extend([[a, a + 1, a + 5], [a + 1, a + 6, a + 5]]);
        }
        mesh.uvs = mesh.positions.iter().map(|x| vec2(x.x, x.z)).collect();
        RestShape::build(&mesh).map(|(rest, _)| rest).unwrap_or_default()
    }

    /// Its particles where `place` puts them, with masses.
    fn placed(rest: &RestShape, place: impl Fn(Vec3) -> Vec3) -> Vec<Vec4> {
        rest.positions.iter().zip(&rest.areas).map(|(x, area)| place(*x).extend(1.0 / (0.2 * area))).collect()
    }

    /// Lengths of the warp and the weft, and the cosine between them, of a sheet that is deformed alike everywhere.
    fn deformation(rest: &RestShape, positions: &[Vec4]) -> [f32; 3] {
        let mut fit = (Mat2::ZERO, Mat2::ZERO);
        let mean = |x: &dyn Fn(usize) -> Vec2| (0..positions.len()).map(x).sum::<Vec2>() / positions.len() as f32;
        let (rest_at, at) =
            (|p: usize| vec2(rest.positions[p].x, rest.positions[p].z), |p: usize| vec2(positions[p].x, positions[p].z));
        let (rest_mean, now_mean) = (mean(&rest_at), mean(&at));
        for p in 0..positions.len() {
            let (r, x) = (rest_at(p) - rest_mean, at(p) - now_mean);
            fit.0 += Mat2::from_cols(r * r.x, r * r.y);
            fit.1 += Mat2::from_cols(x * r.x, x * r.y);
        }
        let f = fit.1 * fit.0.inverse();
        [f.y_axis.length(), f.x_axis.length(), f.x_axis.dot(f.y_axis)]
    }

    #[test]
    fn what_is_turned_as_a_whole_stays_and_what_moves_keeps_its_momentum() {
        let rest = sheet();
        assert!(!rest.membrane.is_empty());
        let fabric = Fabric { stretch_ratio: 2.0, warp_angle: 0.4, ..Fabric::default() };
        let turn = Quat::from_euler(glam::EulerRot::XYZ, 0.7, -0.3, 1.1);
        let mut x = placed(&rest, |p| turn * p);
        let before = x.clone();
        solve(&rest.membrane, &fabric, 1.0 / 360.0, &mut x);
        let moved = x.iter().zip(&before).map(|(a, b)| (*a - *b).length()).fold(0.0, f32::max);
        assert!(moved < 1.0e-6, "moved by {moved} m");

        let mut x = placed(&rest, |p| turn * vec3(1.1 * p.x + 0.2 * p.z, 0.3 * p.x * p.z, 0.95 * p.z));
        let sum = |x: &[Vec4]| -> Vec3 { x.iter().map(|x| x.truncate() / x.w).sum() };
        let (before, start) = (sum(&x), x.clone());
        solve(&rest.membrane, &fabric, 1.0 / 360.0, &mut x);
        let spin: Vec3 = x.iter().zip(&start).map(|(x, old)| old.truncate().cross((*x - *old).truncate() / x.w)).sum();
        let size: f32 = x.iter().zip(&start).map(|(x, old)| (*x - *old).truncate().length() / x.w).sum();
        assert!(size > 1.0e-7 && sum(&x).distance(before) < 1.0e-3 * size, "{:?}, {before:?}, {size}", sum(&x));
        assert!(spin.length() < 0.02 * 0.1 * size, "{spin} of {size}");
    }

    #[test]
    fn threads_get_their_length_back_and_only_shear_turns_them() {
        let rest = sheet();
        let stiff = Fabric { stretch_stiffness: 1.0e7, shear_stiffness: 0.0, strain_limit: f32::INFINITY, ..Fabric::default() };
        let mut x = placed(&rest, |p| vec3(1.05 * p.x + 0.1 * p.z, 0.0, 0.96 * p.z));
        let sheared = deformation(&rest, &x)[2];
        (0..300).for_each(|_| solve(&rest.membrane, &stiff, 1.0 / 360.0, &mut x));
        let [warp, weft, shear] = deformation(&rest, &x);
        assert!((warp - 1.0).abs() < 2.0e-3 && (weft - 1.0).abs() < 2.0e-3, "{warp} {weft}");
        assert!((shear / sheared - 1.0).abs() < 0.2, "{shear}, sheared by {sheared} before");
        let square = Fabric { shear_stiffness: 1.0e7, ..stiff };
        (0..300).for_each(|_| solve(&rest.membrane, &square, 1.0 / 360.0, &mut x));
        let [warp, weft, shear] = deformation(&rest, &x);
        assert!((warp - 1.0).abs() < 2.0e-3 && (weft - 1.0).abs() < 2.0e-3 && shear.abs() < 5.0e-3, "{warp} {weft} {shear}");
    }

    /// A strip under a load, held at its other end.
    #[test]
    fn the_warp_is_the_stiffer_one_by_as_much_whichever_way_the_fabric_is_turned_and_mapped() {
        let mut seen: Option<[f32; 2]> = None;
        for (angle, mirrored) in [(0.0_f32, 1.0_f32), (0.4, 1.0), (0.4, -1.0)] {
            let mut mesh = SourceMesh::default();
            for i in 0..9 {
                mesh.positions.extend((0..4).map(|j| vec3(0.02 * j as f32, 0.0, 0.02 * i as f32)));
            }
            for a in (0..8).flat_map(|i| (0..3).map(move |j| 4 * i + j)) {
                mesh.triangles.extend([[a, a + 1, a + 4], [a + 1, a + 5, a + 4]]);
            }
            // The warp of the texture lies at the angle to z, so that turned by it the fabric's runs along z.
            let way = Vec2::from_angle(angle);
            mesh.uvs = mesh
                .positions
                .iter()
                .map(|x| vec2(mirrored * (way.x * x.x + way.y * x.z), way.x * x.z - way.y * x.x))
                .collect();
            let rest = RestShape::build(&mesh).map(|(rest, _)| rest).unwrap_or_default();
            let stiff = |warp_angle: f32| Fabric {
                stretch_stiffness: 20.0,
                stretch_ratio: 3.0,
                shear_stiffness: 1.0,
                warp_angle,
                strain_limit: f32::INFINITY,
                ..Fabric::default()
            };
            let (h, pull) = (1.0 / 360.0, 0.03);
            // Force per width 0.3 N/m: each particle of the end takes its share as a way of a substep.
            let run = |warp_angle: f32| {
                let mut x = placed(&rest, |p| p);
                let end = |p: &Vec3| p.z > 0.159;
                for (x, p) in x.iter_mut().zip(&rest.positions) {
                    if p.z < 0.001 {
                        x.w = 0.0;
                    }
                }
                for _ in 0..6000 {
                    for (x, p) in x.iter_mut().zip(&rest.positions).filter(|(_, p)| end(p)) {
                        let share = if p.x > 0.001 && p.x < 0.059 { 1.0 } else { 0.5 };
                        x.z += pull * 0.02 * share * x.w * h * h;
                    }
                    solve(&rest.membrane, &stiff(warp_angle), h, &mut x);
                }
                let tip: Vec<f32> = x.iter().zip(&rest.positions).filter(|(_, p)| end(p)).map(|(x, _)| x.z).collect();
                tip.iter().sum::<f32>() / tip.len() as f32 / 0.16 - 1.0
            };
            let turned = angle * mirrored;
            let (along, across) = (run(turned), run(turned + core::f32::consts::FRAC_PI_2));
            assert!(across > 1.4 * along, "turned by {angle}, {mirrored}: {along}, {across}");
            let first = seen.get_or_insert([along, across]);
            let off = [along / first[0] - 1.0, across / first[1] - 1.0];
            assert!(
                off.iter().all(|off| off.abs() < 0.02),
                "turned by {angle}, {mirrored}: {along}, {across} in place of {first:?}"
            );
        }
    }

    #[test]
    fn a_stretched_thread_at_held_corners_throws_nothing_away() {
        for lever in [1.0e-2, 1.0e-3, 1.0e-4, 1.0e-6] {
            let mut mesh = SourceMesh::default();
            // An edge that is almost along the weft, and a corner over it.
            mesh.positions.extend([Vec3::ZERO, vec3(0.02, 0.0, lever * 0.02), vec3(0.01, 0.0, 0.01)]);
            mesh.triangles.push([0, 1, 2]);
            mesh.uvs = mesh.positions.iter().map(|x| vec2(x.x, x.z)).collect();
            let rest = RestShape::build(&mesh).map(|(rest, _)| rest).unwrap_or_default();
            for stretch_stiffness in [2.0e3, 1.0e7] {
                let mut x = placed(&rest, |p| vec3(1.1 * p.x, p.y, p.z));
                for (x, _) in x.iter_mut().zip(&rest.positions).filter(|(_, p)| p.z < 0.005) {
                    x.w = 0.0;
                }
                let before = x.clone();
                solve(&rest.membrane, &Fabric { stretch_stiffness, ..Fabric::default() }, 1.0 / 360.0, &mut x);
                let moved = x.iter().zip(&before).map(|(a, b)| (*a - *b).truncate().length()).fold(0.0, f32::max);
                assert!(moved < 0.002, "lever {lever}, {stretch_stiffness} N/m: thrown {moved} m");
            }
        }
    }

    #[test]
    fn held_corners_and_triangles_without_size_give_no_bad_numbers() {
        let rest = sheet();
        for place in [|p: Vec3| p * 1.2, |p: Vec3| p * 8.0, |p: Vec3| p * 1.0e5, |_| Vec3::ZERO, |p: Vec3| vec3(p.x, 0.0, 0.0)]
        {
            let mut x = placed(&rest, place);
            x.iter_mut().take(12).for_each(|x| x.w = 0.0);
            let before = x.clone();
            solve(&rest.membrane, &Fabric::default(), 1.0 / 360.0, &mut x);
            assert!(x.iter().all(|x| x.is_finite()));
            assert!(x.iter().zip(&before).all(|(x, old)| x.w > 0.0 || x == old));
        }
    }
}
