//! Bending elements: one across each interior edge (quadratic isometric bending, Bergou et al. 2006).
//!
//! ```text
//!        x2                 v = Σ c_i x_i   is zero on a flat hinge and, for a developable fold, points along the
//!       /  \                normal with |v| / (A1 + A2) the curvature across the edge; E = ½ · B / (A1 + A2) · |v|².
//!     x0 -- x1   shared     c0 = cot(1,0,2) ... from the angles e0 makes with the other four edges at rest.
//!       \  /
//!        x3
//! ```
//!
//! With this weight a cylinder of radius `r` stores the `B / (2 r²)` per area of a plate, on right and on equilateral
//! triangles. On the latter it is the `√3/2` of Seung and Nelson 1988. The paper's 3 is for an energy without that
//! normalization.
//!
//! `E` is quadratic in positions, with one constant matrix `K` for all three coordinates: `E = ½ B Σ_xyz xᵀ K x`. It is the
//! same for every fabric of a uniform mass, and so are the eigenvalues of `A⁻¹ K`, `A` the areas around particles.
//!
//! On a cylinder that is the energy of a plate. A strip with free edges is up to 20 % softer along the threads, where it
//! relaxes sideways, and stiffer at 45°. Bending lengths, which go with the third root, are within 8 % of theory
//! (`lab::cantilever`).

use glam::{Vec2, Vec3, Vec4};

use super::batch::LANES;
use super::weave::Threads;
use crate::solver::topology::{NONE, Topology};

/// Bending elements in batches of four, and the pattern of their matrix. Per-batch arrays hold one entry for each of four
/// lanes; lanes beyond the last element have coefficients of zero.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Bends {
    /// Ends of the shared edge, then the two opposite corners.
    pub hinges: Vec<[[u32; 4]; LANES]>,
    /// Coefficients `c` of the four particles (dimensionless), one vector per lane.
    pub coefficients: Vec<[Vec4; LANES]>,
    /// Curvature at rest `[1/m]` across the edge, `±|v| / (A1 + A2)`, by lane; positive where `v` points along the
    /// [normal](Self::lean).
    pub rest: Vec<Vec4>,
    /// How far the normal leans to one of the two triangles (dimensionless), -1 to 1, by lane. The normal is `(x1 - x0) × o`,
    /// with `o = (x3 - x2) + lean (x3 + x2 - 2 x0)`, which at rest points along `v`.
    pub lean: Vec<Vec4>,
    /// `A1 + A2` `[m²]`, by lane.
    pub area: Vec<Vec4>,
    /// Number of elements.
    pub count: usize,
    /// Whether all are flat at rest.
    pub is_flat: bool,
    /// Start of each particle's row in [`Self::columns`]; `particles + 1` entries.
    pub row_start: Vec<u32>,
    /// Particles that share an element with the particle of the row, sorted; filled up with the last, whose entries count once.
    /// The diagonal is not kept. Rows sum to zero, since a cloth that is only moved has no curvature. So
    /// `(K x)_i = Σ K_ij (x_j - x_i)`.
    pub columns: Vec<[u32; LANES]>,
    /// Entries of `K` `[1/m²]`, as the columns.
    pub matrix: Vec<[f32; LANES]>,
    /// Largest eigenvalue of `A⁻¹ K` `[1/m⁴]`; 0 without elements.
    pub fastest: f32,
    /// Share of the stiffness that each element keeps (dimensionless), by lane: less than all where triangles are much smaller
    /// than the rest.
    pub keeps: Vec<Vec4>,
    /// `cos 2φ` and `sin 2φ` by lane; empty where nothing tells the angle. `φ` is the angle of the direction in which it bends,
    /// from the warp towards the weft.
    pub warp: Vec<[Vec4; 2]>,
    /// What it takes for curvature (dimensionless), by lane: `κ = H_00 κ_warp + 2 H_01 κ_twist + H_11 κ_weft`; as
    /// [`Self::warp`].
    pub shape: Vec<[Vec4; 3]>,
}

/// Share of the particles whose elements keep all of their stiffness (dimensionless). The few smallest triangles of a mesh
/// would ask for steps that no other needs.
const KEPT: f32 = 0.99;

/// The same for meshes with more small triangles (dimensionless). Those with edges half as long as is usual keep all, since
/// widths go with the fourth power.
const SMALL: f32 = 16.0;

/// Steps of the power iteration, and what its result is multiplied by (dimensionless): it comes from below.
const POWER_STEPS: u32 = 32;
const POWER_MARGIN: f32 = 1.1;

impl Bends {
    /// One element per interior edge of `topology`, at rest at `positions` `[m]`; `areas` `[m²]` around particles.
    #[must_use]
    pub fn new(topology: &Topology, positions: &[Vec3], areas: &[f32]) -> Self {
        let hinges: Vec<[u32; 4]> = (0..topology.edges.len() as u32)
            .filter_map(|e| {
                let [f, g] = topology.edge_faces[e as usize];
                let [a, b] = topology.edges[e as usize];
                (g != NONE).then(|| [a, b, topology.opposite(e, f), topology.opposite(e, g)])
            })
            .filter(|h| h[2] != h[3])
            .collect();
        let mut bends = Self { count: hinges.len(), ..Self::default() };
        for batch in hinges.chunks(LANES) {
            let lane = |k: usize| batch.get(k).copied();
            let elements: [Element; LANES] = std::array::from_fn(|k| match lane(k) {
                Some(hinge) => Element::new(hinge.map(|p| positions[p as usize])),
                None => Element { area: 1.0, ..Element::default() },
            });
            bends.hinges.push(std::array::from_fn(|k| lane(k).unwrap_or(batch[0])));
            bends.coefficients.push(elements.map(|e| e.coefficients));
            bends.rest.push(Vec4::from_array(elements.map(|e| e.rest)));
            bends.lean.push(Vec4::from_array(elements.map(|e| e.lean)));
            bends.area.push(Vec4::from_array(elements.map(|e| e.area)));
        }
        bends.is_flat = bends.rest.iter().all(|rest| *rest == Vec4::ZERO);
        bends.find_rows(positions.len());
        bends.keeps = vec![Vec4::ONE; bends.hinges.len()];
        bends.matrix = bends.matrix_of(|_| Vec4::ONE);
        bends.soften(areas);
        bends.matrix = bends.matrix_of(|_| Vec4::ONE);
        // Power iteration comes from below, Gershgorin's bound from above.
        bends.fastest = (0..areas.len())
            .map(|i| bends.width(i, areas))
            .fold(0.0, f32::max)
            .min(POWER_MARGIN * bends.largest_eigenvalue(&bends.matrix, areas));
        bends
    }

    fn find_rows(&mut self, particles: usize) {
        let hinges = &self.hinges.as_flattened()[..self.count];
        let mut rows: Vec<Vec<u32>> = vec![Vec::new(); particles];
        for hinge in hinges {
            for &p in hinge {
                rows[p as usize].extend(hinge);
            }
        }
        self.row_start.push(0);
        for (i, row) in rows.iter_mut().enumerate() {
            row.sort_unstable();
            row.dedup();
            row.retain(|p| *p as usize != i);
            for chunk in row.chunks(LANES) {
                self.columns.push(std::array::from_fn(|lane| chunk[lane.min(chunk.len() - 1)]));
            }
            self.row_start.push(self.columns.len() as u32);
        }
    }

    /// The matrix of a cloth whose elements have a `share` of the stiffness they keep (dimensionless), by batch.
    fn matrix_of(&self, share: impl Fn(usize) -> Vec4) -> Vec<[f32; LANES]> {
        let mut matrix = vec![[0.0; LANES]; self.columns.len()];
        for (k, hinges) in self.hinges.iter().enumerate() {
            let stiffness = self.keeps[k] * share(k) / self.area[k];
            for (lane, hinge) in hinges.iter().enumerate() {
                let c = self.coefficients[k][lane];
                for (i, &row) in hinge.iter().enumerate() {
                    for (j, &column) in hinge.iter().enumerate() {
                        if let Some((at, place)) = self.entry(row, column) {
                            matrix[at][place] += stiffness[lane] * c[i] * c[j];
                        }
                    }
                }
            }
        }
        matrix
    }

    /// Notes where the warp is: by `twice` the angle of each edge, and by the directions of each face.
    pub(super) fn weave(&mut self, topology: &Topology, positions: &[Vec3], twice: &[Vec2], threads: &[Threads]) {
        if twice.is_empty() {
            return;
        }
        // In the order of the hinges.
        let edges: Vec<u32> = (0..topology.edges.len() as u32)
            .filter(|&e| {
                let [f, g] = topology.edge_faces[e as usize];
                g != NONE && topology.opposite(e, f) != topology.opposite(e, g)
            })
            .collect();
        for (batch, edges) in edges.chunks(LANES).enumerate() {
            // It bends at a right angle to its edge.
            let twice: [Vec2; LANES] = std::array::from_fn(|lane| edges.get(lane).map_or(Vec2::ZERO, |&e| -twice[e as usize]));
            self.warp.push([Vec4::from_array(twice.map(|t| t.x)), Vec4::from_array(twice.map(|t| t.y))]);
            let shapes: [Vec3; LANES] = std::array::from_fn(|lane| {
                edges.get(lane).map_or(Vec3::ZERO, |&e| {
                    let [f, g] = topology.edge_faces[e as usize].map(|f| threads[f as usize]);
                    let x = self.hinges[batch][lane].map(|p| positions[p as usize]);
                    let at = |threads: &Threads, x: Vec3| Vec2::new(x.dot(threads.warp), x.dot(threads.weft));
                    let [along, first, second] = [x[1] - x[0], x[2] - x[0], x[3] - x[0]];
                    let flat = [0.5 * (at(&f, along) + at(&g, along)), at(&f, first), at(&g, second)];
                    let c = self.coefficients[batch][lane] / self.area[batch][lane];
                    let of = |(c, p): (f32, Vec2)| 0.5 * c * Vec3::new(p.x * p.x, p.x * p.y, p.y * p.y);
                    [c.y, c.z, c.w].into_iter().zip(flat).map(of).sum()
                })
            });
            let row = |of: fn(Vec3) -> f32| Vec4::from_array(shapes.map(of));
            self.shape.push([row(|s| s.x), row(|s| s.y), row(|s| s.z)]);
        }
    }

    /// How far Gershgorin's circle of a particle reaches `[1/m⁴]`.
    fn width(&self, i: usize, areas: &[f32]) -> f32 {
        let row = self.matrix[self.row(i)].as_flattened();
        (row.iter().map(|k| k.abs()).sum::<f32>() + row.iter().sum::<f32>().abs()) / areas[i]
    }

    /// Makes elements softer where Gershgorin's circles are widest.
    fn soften(&mut self, areas: &[f32]) {
        let widths: Vec<f32> = (0..areas.len()).map(|i| self.width(i, areas)).collect();
        let mut sorted: Vec<f32> = widths.iter().copied().filter(|width| *width > 0.0 && width.is_finite()).collect();
        if sorted.is_empty() {
            return;
        }
        let mut quantile = |share: f32| {
            let at = ((sorted.len() - 1) as f32 * share) as usize;
            *sorted.select_nth_unstable_by(at, f32::total_cmp).1
        };
        self.fastest = quantile(KEPT).min(SMALL * quantile(0.5));
        for (keeps, hinges) in self.keeps.iter_mut().zip(&self.hinges) {
            let width = hinges.map(|hinge| hinge.iter().fold(self.fastest, |width, &p| widths[p as usize].max(width)));
            *keeps *= self.fastest / Vec4::from_array(width);
        }
    }

    /// Largest eigenvalue of `A⁻¹ K` `[1/m⁴]`, by power iteration: from below.
    fn largest_eigenvalue(&self, matrix: &[[f32; LANES]], areas: &[f32]) -> f32 {
        // Noise that is the same in every run.
        let noise = |i: usize| ((i as u32).wrapping_mul(2_654_435_761) >> 8) as f32 / (1 << 23) as f32 - 1.0;
        let norm = |x: &[f32]| x.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt() as f32;
        let mut x: Vec<f32> = (0..areas.len()).map(noise).collect();
        let mut y = x.clone();
        let mut largest = 0.0;
        for _ in 0..POWER_STEPS {
            let size = norm(&x);
            for (i, y) in y.iter_mut().enumerate() {
                let entries = self.columns[self.row(i)].as_flattened().iter().zip(matrix[self.row(i)].as_flattened());
                *y = entries.map(|(column, k)| (x[*column as usize] - x[i]) * k).sum::<f32>() / (areas[i] * size);
            }
            largest = norm(&y);
            core::mem::swap(&mut x, &mut y);
        }
        largest
    }

    /// Where the entry of two different particles that share a hinge is: index in [`Self::columns`], and lane.
    #[must_use]
    pub fn entry(&self, row: u32, column: u32) -> Option<(usize, usize)> {
        let range = self.row(row as usize);
        // By halving: a hub of a fan has a row of thousands.
        let first = range.start;
        let columns = &self.columns[range];
        let k = columns.partition_point(|lanes| lanes[LANES - 1] < column);
        Some((first + k, columns.get(k)?.iter().position(|c| *c == column)?))
    }

    /// Where the row of a particle is in [`Self::columns`].
    #[must_use]
    pub fn row(&self, particle: usize) -> core::ops::Range<usize> {
        self.row_start[particle] as usize..self.row_start[particle + 1] as usize
    }

    /// Memory held `[B]`.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.hinges.len() * (size_of::<[[u32; 4]; LANES]>() + 8 * size_of::<Vec4>())
            + (self.warp.len() * 2 + self.shape.len() * 3) * size_of::<Vec4>()
            + size_of_val(&self.row_start[..])
            + 2 * size_of_val(&self.columns[..])
    }
}

/// Makes bending along the warp as stiff as asked, compared with bending along the weft. Each element is `1 + α cos 2(φ - φ₀)`
/// times as stiff, with `φ` the direction in which it bends and `φ₀` the warp's. `α` is found from what the elements of this
/// mesh take for curvature along the two.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Weave {
    /// Angle of the warp in the texture, `φ₀` `[rad]`.
    pub angle: f32,
    /// `cos 2(φ - φ₀)`, by lane.
    pub along: Vec<Vec4>,
    /// The matrix of the elements times [`Self::along`] `[1/m²]`.
    pub matrix: Vec<[f32; LANES]>,
    /// Largest eigenvalue for `α` of -1, 0 and 1 `[1/m⁴]`.
    fastest: [f32; 3],
    /// Mean of `κ²` of the elements where only the warp bends, and only the weft, and the same times [`Self::along`].
    even: Vec2,
    uneven: Vec2,
}

/// Largest `α` (dimensionless): no element may be without stiffness. Grids along the threads reach a ratio of 40, equilateral
/// triangles one of 3 in their worst direction.
const MOST_UNEVEN: f32 = 0.95;

/// By how much `α` moves the ratio where edges have all directions alike (dimensionless), as on equilateral triangles. Meshes
/// on which it moves it less get less of it. Squares cut into four at 45° to the threads it does not move at all.
const SPREAD: f32 = 4.0 / 3.0;

impl Weave {
    /// Of a mesh whose warp is at `angle` `[rad]` in its texture; none where nothing tells it.
    #[must_use]
    pub fn new(bends: &Bends, areas: &[f32], angle: f32) -> Option<Self> {
        if bends.warp.is_empty() {
            return None;
        }
        let way = Vec2::from_angle(2.0 * angle);
        let along: Vec<Vec4> = bends.warp.iter().map(|[cos, sin]| *cos * way.x + *sin * way.y).collect();
        let (sin, cos) = angle.sin_cos();
        let (mut even, mut uneven) = (Vec2::ZERO, Vec2::ZERO);
        for (k, [h00, h01, h11]) in bends.shape.iter().enumerate() {
            let weight = bends.area[k] * bends.keeps[k];
            let warp = *h00 * (cos * cos) + *h01 * (2.0 * cos * sin) + *h11 * (sin * sin);
            let weft = *h00 * (sin * sin) - *h01 * (2.0 * cos * sin) + *h11 * (cos * cos);
            let squares = [warp * warp * weight, weft * weft * weight];
            even += Vec2::from_array(squares.map(|s| s.dot(Vec4::ONE)));
            uneven += Vec2::from_array(squares.map(|s| s.dot(along[k])));
        }
        let matrix = bends.matrix_of(|k| along[k]);
        let fastest = [-1.0, 0.0, 1.0].map(|alpha| {
            if alpha == 0.0 {
                return bends.fastest;
            }
            let both: Vec<[f32; LANES]> = bends
                .matrix
                .iter()
                .zip(&matrix)
                .map(|(k, along)| std::array::from_fn(|lane| k[lane] + alpha * along[lane]))
                .collect();
            POWER_MARGIN * bends.largest_eigenvalue(&both, areas)
        });
        Some(Self { angle, along, matrix, fastest, even, uneven })
    }

    /// `α`, and the share of all stiffness that keeps the mean of the two directions (dimensionless). `ratio`: stiffness along
    /// the warp over that along the weft.
    #[must_use]
    pub fn split(&self, ratio: f32) -> (f32, f32) {
        let Self { even, uneven, .. } = self;
        // (even.x + α uneven.x) / (even.y + α uneven.y) = ratio even.x / even.y: what the mesh itself is uneven by stays, as
        // with a ratio of 1.
        let ratio = ratio * even.x / even.y;
        let (wanted, rises) = (ratio * even.y - even.x, uneven.x - ratio * uneven.y);
        // A ratio beyond what any `α` has is met at its end.
        let alpha = if rises > 0.0 { wanted / rises } else { f32::MAX.copysign(wanted) };
        let spread = uneven.x / even.x - uneven.y / even.y;
        let most = MOST_UNEVEN * (spread / SPREAD).clamp(0.0, 1.0);
        let alpha = if alpha.is_finite() && most.is_finite() { alpha.clamp(-most, most) } else { 0.0 };
        let mean = even.element_sum();
        let share = mean / (mean + alpha * uneven.element_sum());
        (alpha, if share.is_finite() { share } else { 1.0 })
    }

    /// Largest eigenvalue for `α` `[1/m⁴]`, from above: it is convex in `α`.
    #[must_use]
    pub fn fastest(&self, alpha: f32) -> f32 {
        let [below, at, above] = self.fastest;
        at + alpha.abs() * (if alpha < 0.0 { below } else { above } - at)
    }
}

/// One lane of a batch.
#[derive(Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
struct Element {
    coefficients: Vec4,
    rest: f32,
    lean: f32,
    area: f32,
}

impl Element {
    /// Of a hinge at rest at `x` `[m]`.
    fn new(x: [Vec3; 4]) -> Self {
        let cot = |u: Vec3, v: Vec3| u.dot(v) / u.cross(v).length().max(1.0e-12);
        let (e0, e1, e2, e3, e4) = (x[1] - x[0], x[2] - x[0], x[3] - x[0], x[2] - x[1], x[3] - x[1]);
        let (c01, c02, c03, c04) = (cot(e0, e1), cot(e0, e2), cot(-e0, e3), cot(-e0, e4));
        let c = Vec4::new(c03 + c04, c01 + c02, -c01 - c03, -c02 - c04);
        let area = 0.5 * (e0.cross(e1).length() + e0.cross(e2).length());
        // Then the normal halves the angle between those of the triangles, as `v` does.
        let lean = 0.5 * (e0.cross(e1).length() - e0.cross(e2).length()) / area;
        let v = x[0] * c.x + x[1] * c.y + x[2] * c.z + x[3] * c.w;
        let flat = Self { coefficients: c, rest: 0.0, lean, area };
        // Rounding leaves a flat hinge with |v| of some 1e-7 of its size.
        if v.length() < 1.0e-4 * e0.length() * c.abs().max_element() {
            return flat;
        }
        let side = v.dot(e0.cross((x[3] - x[2]) + (e1 + e2) * lean));
        Self { rest: v.length().copysign(side) / area, lean, ..flat }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_hinge_has_no_rest_curvature_and_coefficients_that_sum_to_zero() {
        let Element { coefficients: c, rest, .. } =
            Element::new([Vec3::ZERO, Vec3::X, Vec3::new(0.3, 0.8, 0.0), Vec3::new(0.6, -0.5, 0.0)]);
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
        let bends = Bends::new(&topology, &grid(&flat), &vec![1.0 / (n * n) as f32; ((n + 1) * (n + 1)) as usize]);
        let bent = grid(&point);
        let mut energy = 0.0;
        for (k, hinges) in bends.hinges.iter().enumerate() {
            for (lane, hinge) in hinges.iter().enumerate() {
                let c = bends.coefficients[k][lane];
                let v: Vec3 = (0..4).map(|m| bent[hinge[m] as usize] * c[m]).sum();
                energy += 0.5 / bends.area[k][lane] * v.length_squared();
            }
        }
        let theory = 0.5 / (r * r);
        assert!((energy / theory - 1.0).abs() < 0.08, "energy {energy}, theory {theory}");
    }

    #[test]
    fn a_few_needles_among_many_triangles_ask_for_no_smaller_steps() {
        // Rows of squares; in every eighth they are a thousandth as wide.
        let (n, d) = (40u32, 0.01f32);
        let mut positions = Vec::new();
        let mut x = 0.0f32;
        for i in 0..=n {
            positions.extend((0..=n).map(|j| Vec3::new(x, d * j as f32, 0.0)));
            x += if i % 8 == 7 { 1.0e-3 * d } else { d };
        }
        let mut faces = Vec::new();
        for a in (0..n).flat_map(|i| (0..n).map(move |j| i * (n + 1) + j)) {
            faces.extend([[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]);
        }
        let topology = Topology::new((n + 1) * (n + 1), faces);
        let bends = Bends::new(&topology, &positions, &vec![d * d; positions.len()]);
        // Gershgorin's bound of squares of side d is 256 / d⁴.
        assert!(bends.fastest < SMALL * 256.0 / d.powi(4), "{}", bends.fastest);
    }

    #[test]
    fn the_curvature_at_rest_of_a_cylinder_is_that_of_the_cylinder() {
        let (r, d) = (0.1f32, 0.01f32);
        let at = |s: f32, y: f32| Vec3::new(r * (s / r).sin(), y, r * (s / r).cos());
        let Element { rest: across, .. } = Element::new([at(0.0, 0.0), at(0.0, d), at(-d, 0.0), at(d, d)]);
        assert!((across.abs() * r - 1.0).abs() < 0.02, "{across} for {}", 1.0 / r);
        let Element { rest: diagonal, .. } = Element::new([at(0.0, 0.0), at(d, d), at(d, 0.0), at(0.0, d)]);
        assert!(diagonal.abs() * r < 0.05, "{diagonal}");
    }
}
