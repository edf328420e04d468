//! Bending elements: one across each interior edge (quadratic isometric bending, Bergou et al. 2006).
//!
//! ```text
//!        x2                 v = Σ c_i x_i   is zero on a flat hinge and, for a developable fold, points along the
//!       /  \                normal with |v| proportional to the curvature; E = ½ · B / (A1 + A2) · |v|².
//!     x0 -- x1   shared     c0 = cot(1,0,2) ... from the angles e0 makes with the other four edges at rest.
//!       \  /
//!        x3
//! ```
//!
//! With this weight a cylinder of radius `r` stores the `B / (2 r²)` per area of a plate, on right and on equilateral triangles (on the latter it is
//! the `√3/2` of Seung and Nelson 1988). The paper's 3 is for an energy without that normalization.

use glam::{Vec3, Vec4};

use super::batch::{LANES, batches};
use super::{NONE, Topology};

/// Bending elements in batches of four. Per-batch arrays hold one entry for each of four lanes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bends {
    /// Ends of the shared edge, then the two opposite corners.
    pub particles: Vec<[[u32; 4]; LANES]>,
    /// Coefficients `c` of the four particles (dimensionless), one vector per lane.
    pub coefficients: Vec<[Vec4; LANES]>,
    /// `|v|` at rest [m], by lane.
    pub rest: Vec<Vec4>,
    /// `1 / (A1 + A2)` [1/m²], by lane: stiffness over `B` [N·m].
    pub inverse_area: Vec<Vec4>,
    /// Number of elements, lanes that repeat not counted.
    pub count: usize,
}

impl Bends {
    /// One element per interior edge of `topology`, at rest at `positions` [m].
    #[must_use]
    pub fn new(topology: &Topology, positions: &[Vec3]) -> Self {
        let hinges: Vec<[u32; 4]> = (0..topology.edges.len() as u32)
            .filter_map(|e| {
                let [f, g] = topology.edge_faces[e as usize];
                let [a, b] = topology.edges[e as usize];
                (g != NONE).then(|| [a, b, topology.opposite(e, f), topology.opposite(e, g)])
            })
            .filter(|h| h[2] != h[3])
            .collect();
        let mut bends = Self { count: hinges.len(), ..Self::default() };
        for batch in batches(topology.particles as usize, &hinges) {
            let lanes = batch.map(|h| hinges[h as usize]);
            let elements = lanes.map(|h| element(h.map(|p| positions[p as usize])));
            bends.particles.push(lanes);
            bends.coefficients.push(elements.map(|e| e.0));
            bends.rest.push(Vec4::from_array(elements.map(|e| e.1)));
            bends.inverse_area.push(Vec4::from_array(elements.map(|e| e.2)));
        }
        bends
    }
}

/// Coefficients, `|v|` at rest [m] and `1 / (A1 + A2)` [1/m²] of a hinge.
fn element(x: [Vec3; 4]) -> (Vec4, f32, f32) {
    let cot = |u: Vec3, v: Vec3| u.dot(v) / u.cross(v).length().max(1.0e-12);
    let (e0, e1, e2, e3, e4) = (x[1] - x[0], x[2] - x[0], x[3] - x[0], x[2] - x[1], x[3] - x[1]);
    let (c01, c02, c03, c04) = (cot(e0, e1), cot(e0, e2), cot(-e0, e3), cot(-e0, e4));
    let c = Vec4::new(c03 + c04, c01 + c02, -c01 - c03, -c02 - c04);
    let area = 0.5 * (e0.cross(e1).length() + e0.cross(e2).length());
    let v = x[0] * c.x + x[1] * c.y + x[2] * c.z + x[3] * c.w;
    // Rounding leaves a flat hinge with |v| of some 1e-7 of its size: that is flat.
    let size = e0.length() * c.abs().max_element();
    let rest = if v.length() < 1.0e-4 * size { 0.0 } else { v.length() };
    (c, rest, 1.0 / area)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_hinge_has_no_rest_vector_and_coefficients_that_sum_to_zero() {
        let (c, rest, _) = element([Vec3::ZERO, Vec3::X, Vec3::new(0.3, 0.8, 0.0), Vec3::new(0.6, -0.5, 0.0)]);
        assert!((c.x + c.y + c.z + c.w).abs() < 1.0e-5, "{c}");
        assert_eq!(rest, 0.0);
    }

    #[test]
    fn a_cylinder_bends_with_the_energy_of_a_plate() {
        // A plate of stiffness B bent to radius r stores B / (2 r²) per area.
        let (n, r) = (40, 2.0f32);
        let point = |i: u32, j: u32| {
            let angle = i as f32 / n as f32 / r;
            Vec3::new(r * angle.sin(), j as f32 / n as f32, r * angle.cos())
        };
        let flat = |i: u32, j: u32| Vec3::new(i as f32 / n as f32, j as f32 / n as f32, 0.0);
        let grid = |f: &dyn Fn(u32, u32) -> Vec3| -> Vec<Vec3> {
            (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))).map(|(i, j)| f(i, j)).collect()
        };
        let mut faces = Vec::new();
        for i in 0..n {
            for j in 0..n {
                let a = i * (n + 1) + j;
                faces.extend([[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]);
            }
        }
        let topology = Topology::new((n + 1) * (n + 1), faces);
        let bends = Bends::new(&topology, &grid(&flat));
        let bent = grid(&point);
        let mut seen = std::collections::BTreeSet::new();
        let mut energy = 0.0;
        for (k, lanes) in bends.particles.iter().enumerate() {
            for (lane, hinge) in lanes.iter().enumerate() {
                if seen.insert(*hinge) {
                    let c = bends.coefficients[k][lane].to_array();
                    let v: Vec3 = (0..4).map(|m| bent[hinge[m] as usize] * c[m]).sum();
                    energy += 0.5 * bends.inverse_area[k][lane] * v.length_squared();
                }
            }
        }
        let theory = 0.5 / (r * r);
        assert!((energy / theory - 1.0).abs() < 0.08, "energy {energy}, theory {theory}");
    }
}
