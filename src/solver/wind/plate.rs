//! Flat plates: the force of the wind on four triangles at a time.

use glam::{Mat4, Vec4};

use crate::solver::rest::LANES;

/// What a triangle does with the wind.
#[derive(Clone, Copy, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Plate {
    /// `ρ / 12`: ½ of the dynamic pressure, ½ of the cross product, ⅓ for each corner `[kg/m³]`.
    pub(super) share: f32,
    pub(super) drag: f32,
    pub(super) lift: f32,
}

impl Plate {
    /// Adds the forces on four triangles to their corners.
    #[inline(always)]
    pub(super) fn press(self, faces: &[[u32; 3]; LANES], positions: &[Vec4], relative: &[Vec4], forces: &mut [Vec4]) {
        let corner = |k: usize| -> [Vec4; LANES] { std::array::from_fn(|lane| positions[faces[lane][k] as usize]) };
        let wind = std::array::from_fn(|lane| {
            let [a, b, c] = faces[lane].map(|i| relative[i as usize]);
            (a + b + c) * (1.0 / 3.0)
        });
        let force = self.forces(corner(0), corner(1), corner(2), wind);
        for (face, force) in faces.iter().zip(force) {
            for &i in face {
                forces[i as usize] += force;
            }
        }
    }

    /// `F / 3` of four triangles `a b c` in the relative wind `v`, with a bound on `|F| / (3 |v|)` in the fourth lane.
    ///
    /// With `N` twice the area along the normal, `c = |N · v|` and `cos θ = c / (|N| |v|)`:
    ///
    /// ```text
    /// F = ½ρ ½c (v (C_D - C_L cos θ) ± N C_L |v| / |N|)        |F| <= ½ρ ½c |v| (C_D + C_L sin² θ)
    /// ```
    #[inline]
    fn forces(self, a: [Vec4; LANES], b: [Vec4; LANES], c: [Vec4; LANES], wind: [Vec4; LANES]) -> [Vec4; LANES] {
        let e: Rows = rows(std::array::from_fn(|lane| b[lane] - a[lane]));
        let f: Rows = rows(std::array::from_fn(|lane| c[lane] - a[lane]));
        let v: Rows = rows(wind);
        let normal = [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]];
        let (area2, speed2, across) = (dot(normal, normal), dot(v, v), dot(normal, v));
        // False for what is not a number. The upper bounds are far beyond sound and keep the products finite.
        let acts = area2.cmpgt(Vec4::splat(1.0e-24))
            & speed2.cmpgt(Vec4::splat(1.0e-12))
            & area2.cmplt(Vec4::splat(1.0e12))
            & speed2.cmplt(Vec4::splat(1.0e8));
        let inverse = (area2 * speed2).sqrt().recip();
        let cosine = across.abs() * inverse;
        let pressure = across.abs() * self.share;
        let along = pressure * (Vec4::splat(self.drag) - cosine * self.lift);
        // The side of the normal away from the wind: the sign of `across` times `|across|` is `across`.
        let lee = across * (speed2 * inverse) * (self.share * self.lift);
        let strength = pressure * (Vec4::splat(self.drag + self.lift) - cosine * cosine * self.lift);
        let [x, y, z] = std::array::from_fn(|axis| v[axis] * along + normal[axis] * lee);
        let force = [x, y, z, strength].map(|row| Vec4::select(acts, row, Vec4::ZERO));
        let m = Mat4::from_cols(force[0], force[1], force[2], force[3]).transpose();
        [m.x_axis, m.y_axis, m.z_axis, m.w_axis]
    }
}

/// Components of four vectors, each in one register.
type Rows = [Vec4; 3];

#[inline]
fn rows(v: [Vec4; LANES]) -> Rows {
    let m = Mat4::from_cols(v[0], v[1], v[2], v[3]).transpose();
    [m.x_axis, m.y_axis, m.z_axis]
}

#[inline]
fn dot(a: Rows, b: Rows) -> Vec4 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
