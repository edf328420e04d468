//! Springs along the edges of the mesh: stretch, and shear along the diagonals of quads.

use glam::{Vec2, Vec3, Vec4};

use super::batch::{LANES, batches};
use crate::solver::topology::{NONE, Topology};

/// A diagonal is this much longer than every other edge of its two faces (dimensionless; √2 in a square, 1 among equilateral
/// triangles).
const DIAGONAL_RATIO: f32 = 1.15;

/// Mean angle to the threads `[rad]` at which springs still pass for threads. Cotton is 140 times as stiff in stretch as in
/// shear. At this angle its springs add as much shear stiffness `K sin²(2φ) / 4` as it has.
const OFF_THREAD: f32 = 5.0 * core::f32::consts::PI / 180.0;

/// Distance constraints in batches of four. All arrays have one entry per batch.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Springs {
    /// First particle of each spring.
    pub a: Vec<[u32; LANES]>,
    /// Second particle of each spring.
    pub b: Vec<[u32; LANES]>,
    /// One over the squared rest length `[1/m²]`.
    pub inverse_square: Vec<Vec4>,
    /// `ΣA / L²` (dimensionless): stiffness of the spring over that of the membrane (Van Gelder 1998).
    pub width_ratio: Vec<Vec4>,
    /// 1 where the spring is the diagonal of a quad, else 0.
    pub shear: Vec<Vec4>,
    /// `cos 2φ` and `sin 2φ`, `φ` its angle from the warp towards the weft; empty where nothing tells it.
    pub warp: Vec<[Vec4; 2]>,
    /// Number of springs, lanes that repeat not counted.
    pub count: usize,
}

impl Springs {
    /// One spring per edge of `topology`, at rest at `positions` `[m]`. `twice`: cosine and sine of twice the angle of each
    /// edge from the warp, or none.
    #[must_use]
    pub fn new(topology: &Topology, positions: &[Vec3], twice: &[Vec2]) -> Self {
        let length = |e: u32| {
            let [a, b] = topology.edges[e as usize];
            positions[a as usize].distance(positions[b as usize])
        };
        let area = |f: u32| {
            let [a, b, c] = topology.faces[f as usize].map(|p| positions[p as usize]);
            0.5 * (b - a).cross(c - a).length()
        };
        let mut springs = Self { count: topology.edges.len(), ..Self::default() };
        // By the later end: it follows the earlier one in memory and in the sweep.
        let mut order: Vec<u32> = (0..topology.edges.len() as u32).collect();
        order.sort_by_key(|&e| (topology.edges[e as usize][1], e));
        let sorted: Vec<[u32; 2]> = order.iter().map(|&e| topology.edges[e as usize]).collect();
        for batch in batches(topology.particles as usize, &sorted) {
            let batch = batch.map(|i| order[i as usize]);
            springs.a.push(batch.map(|e| topology.edges[e as usize][0]));
            springs.b.push(batch.map(|e| topology.edges[e as usize][1]));
            springs.inverse_square.push(Vec4::from_array(batch.map(|e| length(e).powi(2).recip())));
            springs.width_ratio.push(Vec4::from_array(batch.map(|e| {
                let around: f32 = topology.edge_faces[e as usize].iter().filter(|&&f| f != NONE).map(|&f| area(f)).sum();
                around / length(e).powi(2)
            })));
            if !twice.is_empty() {
                let twice = batch.map(|e| twice[e as usize]);
                springs.warp.push([Vec4::from_array(twice.map(|t| t.x)), Vec4::from_array(twice.map(|t| t.y))]);
            }
            springs.shear.push(Vec4::from_array(batch.map(|e| {
                // A border may cut quads in half.
                let diagonal = topology.edge_faces[e as usize].iter().filter(|&&f| f != NONE).all(|&f| {
                    topology.face_edges[f as usize]
                        .iter()
                        .all(|&other| other == e || length(e) > DIAGONAL_RATIO * length(other))
                });
                f32::from(u8::from(diagonal))
            })));
        }
        springs
    }

    /// Both ends of each, and one over its squared length at rest `[1/m²]`; what fills up the last lanes of a colour comes
    /// twice.
    pub(in crate::solver) fn each(&self) -> impl Iterator<Item = (usize, usize, f32)> {
        self.a.iter().zip(&self.b).zip(&self.inverse_square).flat_map(|((a, b), inverse_square)| {
            (0..LANES).map(move |lane| (a[lane] as usize, b[lane] as usize, inverse_square[lane]))
        })
    }

    /// Whether they run along the threads of a fabric whose warp is turned by `warp_angle` `[rad]`, as far as the threads are
    /// known. Only then are they a membrane that stretches and shears as the fabric.
    #[must_use]
    pub(crate) fn run_along_threads(&self, warp_angle: f32) -> bool {
        let threads = Vec2::from_angle(2.0 * warp_angle);
        let (mut off, mut all) = (0.0, 0.0);
        for (k, [cos, sin]) in self.warp.iter().enumerate() {
            // A spring stands for the area around it.
            let area = (Vec4::ONE - self.shear[k]) * self.width_ratio[k] / self.inverse_square[k];
            let along = *cos * threads.x + *sin * threads.y;
            off += area.dot(*cos * *cos + *sin * *sin - along * along);
            all += area.dot(Vec4::ONE);
        }
        off <= (2.0 * OFF_THREAD).sin().powi(2) * all
    }
}
