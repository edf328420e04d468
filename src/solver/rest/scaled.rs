//! The rest shape of a mesh that is a multiple of another: every length is multiplied, and nothing is found anew.
//!
//! ```text
//!   length [m] s  area [m²] s²   curvature and shares of edges [1/m] s⁻¹   squares of those s⁻²   angles, weights: as they are
//! ```

use std::sync::Arc;

use glam::{Vec3, Vec4};

use super::{Bends, CoarseMesh, Membrane, RestShape, Springs};
use crate::solver::buffer::Buffer;

impl RestShape {
    /// The shape of the same mesh `s` times as large. It equals a newly built one, to the bit where `s` is a power of two, else
    /// to rounding. None where `s` is not positive or not finite.
    #[must_use]
    pub fn scaled(&self, s: f32) -> Option<Self> {
        if !(s > 0.0 && s.is_finite() && s.recip().is_finite()) {
            return None;
        }
        let mut shape = Self { tree_topology: Buffer(Arc::clone(self.tree_topology()).into()), ..self.clone() };
        let Self { positions, areas, isolated, springs, membrane, bends, coarse, mean_edge, .. } = &mut shape;
        positions.iter_mut().for_each(|x| *x *= s);
        areas.iter_mut().for_each(|area| *area *= s * s);
        isolated.iter_mut().for_each(|(_, offset)| *offset *= s);
        *mean_edge *= s;
        springs.scale(s);
        membrane.scale(s);
        bends.scale(s);
        coarse.scale(s);
        shape.is_consistent().then_some(shape)
    }

    /// Whether this is the shape of the same mesh as another, some times as large, to rounding.
    #[must_use]
    pub fn is_multiple_of(&self, other: &Self) -> bool {
        let s = self.mean_edge / other.mean_edge;
        // Of the coordinates, whose rounding is that of the largest.
        let size = self.positions.iter().fold(Vec3::ZERO, |size, x| size.max(x.abs())).max_element();
        let is_near = |(mine, theirs): (&Vec3, &Vec3)| mine.distance(*theirs * s) <= 1.0e-5 * size;
        self.topology == other.topology && self.positions.iter().zip(&other.positions).all(is_near)
    }
}

impl Springs {
    fn scale(&mut self, s: f32) {
        let by = (s * s).recip();
        self.inverse_square.iter_mut().for_each(|x| *x *= by);
    }
}

impl Membrane {
    fn scale(&mut self, s: f32) {
        let by = s.recip();
        self.warp.iter_mut().chain(&mut self.weft).flatten().for_each(|share| *share *= by);
        self.inverse_area.iter_mut().for_each(|x| *x *= by * by);
    }
}

impl Bends {
    fn scale(&mut self, s: f32) {
        let by = s.recip();
        self.rest.iter_mut().for_each(|curvature| *curvature *= by);
        for (area, coefficients) in self.area.iter_mut().zip(&self.coefficients) {
            // A lane beyond the last element has none, and an area of one.
            let scale = coefficients.map(|c| if c == Vec4::ZERO { 1.0 } else { s * s });
            *area *= Vec4::from_array(scale);
        }
        self.matrix.iter_mut().flatten().for_each(|x| *x *= by * by);
        self.fastest *= (by * by) * (by * by);
    }
}

impl CoarseMesh {
    fn scale(&mut self, s: f32) {
        self.spacing *= s;
        self.lengths.iter_mut().for_each(|length| *length *= s);
    }
}

#[cfg(test)]
mod tests {
    use glam::{Vec2, vec2, vec3};

    use super::*;
    use crate::solver::rest::SourceMesh;
    use crate::solver::scene::grid;

    /// A wavy sheet with threads and a vertex that has no face.
    fn mesh(s: f32) -> SourceMesh {
        let mut mesh = grid(9, 12, |u, v| vec3(u, 0.1 * (7.0 * u + 3.0 * v).sin(), 1.3 * v));
        mesh.uvs = mesh.positions.iter().map(|x| vec2(x.x + 0.2 * x.z, x.z)).collect();
        mesh.positions.push(vec3(0.4, 0.3, 0.2));
        mesh.uvs.push(Vec2::ZERO);
        mesh.positions.iter_mut().for_each(|x| *x *= s);
        mesh
    }

    fn built(s: f32) -> RestShape {
        RestShape::build(&mesh(s)).expect("a sheet").0
    }

    #[test]
    fn scaled_by_a_power_of_two_a_shape_is_the_one_that_would_be_built() {
        for s in [0.25, 0.5, 2.0, 1024.0] {
            assert!(built(1.0).scaled(s) == Some(built(s)), "times {s}");
            assert!(built(s).is_multiple_of(&built(1.0)), "times {s}");
        }
    }

    #[test]
    fn scaled_by_anything_a_shape_is_within_rounding_of_the_one_that_would_be_built() {
        for s in [0.013, 0.9, 1.37, 77.0] {
            let (scaled, built) = (built(1.0).scaled(s).expect("a shape"), built(s));
            let worst = |pairs: &mut dyn Iterator<Item = (f32, f32)>, unit: f32| {
                pairs.map(|(a, b)| (a - b).abs() / unit).fold(0.0, f32::max)
            };
            let edge = built.mean_edge;
            let of = |a: &[Vec4], b: &[Vec4]| -> Vec<(f32, f32)> {
                a.iter().zip(b).flat_map(|(a, b)| a.to_array().into_iter().zip(b.to_array())).collect()
            };
            let (a, b) = (&scaled, &built);
            let checks = [
                worst(&mut a.positions.iter().zip(&b.positions).map(|(a, b)| (a.distance(*b), 0.0)), edge),
                worst(&mut a.areas.iter().copied().zip(b.areas.iter().copied()), edge * edge),
                worst(&mut of(&a.springs.inverse_square, &b.springs.inverse_square).into_iter(), (edge * edge).recip()),
                worst(&mut of(&a.membrane.inverse_area, &b.membrane.inverse_area).into_iter(), (edge * edge).recip()),
                worst(&mut of(&a.bends.rest, &b.bends.rest).into_iter(), edge.recip()),
                worst(&mut of(&a.bends.area, &b.bends.area).into_iter(), edge * edge),
                worst(&mut [(a.bends.fastest, b.bends.fastest)].into_iter(), b.bends.fastest),
                worst(&mut a.coarse.lengths.iter().copied().zip(b.coarse.lengths.iter().copied()), edge),
            ];
            assert!(checks.iter().all(|&error| error < 1.0e-4), "times {s}: {checks:?}");
            assert_eq!((&a.topology, &a.springs.a, &a.bends.columns), (&b.topology, &b.springs.a, &b.bends.columns));
        }
    }

    #[test]
    fn no_shape_is_scaled_by_what_is_no_scale() {
        for s in [0.0, -1.0, f32::NAN, f32::INFINITY, 1.0e-40] {
            assert_eq!(built(1.0).scaled(s), None, "times {s}");
        }
    }

    #[test]
    fn a_shape_that_is_wider_in_one_direction_is_no_multiple() {
        let mut wide = mesh(1.0);
        wide.positions.iter_mut().for_each(|x| x.x *= 1.01);
        let wide = RestShape::build(&wide).expect("a sheet").0;
        assert!(wide.topology == built(1.0).topology && !wide.is_multiple_of(&built(1.0)));
    }
}
