//! The rest shape: topology, rest lengths, areas and the order in which constraints are solved. Built once per mesh and scale,
//! validated, immutable, and shared by every cloth made from it.

mod batch;
mod bends;
mod decimate;
pub mod geodesic;
mod membrane;
mod coarse;
mod order;
mod scaled;
mod source;
mod springs;
mod weave;
mod weld;

pub use batch::LANES;
pub use bends::{Bends, Weave};
pub use coarse::CoarseMesh;
pub use membrane::Membrane;
pub use source::{BuildReport, RestError, SourceMesh};
pub use springs::Springs;

use std::sync::{Arc, OnceLock};

use decimate::{Decimated, decimate};
use glam::Vec3;

use crate::solver::buffer::Buffer;
use crate::solver::detect::tree::TreeTopology;
use crate::solver::detect::{PartRef, Surface};
use crate::solver::embed::Embedding;
use crate::solver::topology::{NONE, Topology};

/// Faces below this fraction of the mesh's squared diagonal have no area (dimensionless).
const AREA_FRACTION: f32 = 1.0e-11;

/// A mesh at rest, ready to simulate.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct RestShape {
    /// Connectivity over particles.
    pub topology: Arc<Topology>,
    /// Rest positions `[m]` of the particles, in the scaled, unrotated frame of the mesh.
    pub positions: Vec<Vec3>,
    /// Third of the area of the faces around each particle `[m²]`.
    pub areas: Vec<f32>,
    /// Particle of each render vertex: at its place, or the one that it went into where the shape is coarser than its mesh.
    pub particle_of_vertex: Vec<u32>,
    /// Isolated render vertices: `(vertex, offset from its particle at rest [m])`.
    pub isolated: Vec<(u32, Vec3)>,
    /// Stretch and shear springs.
    pub springs: Springs,
    /// Triangles of the membrane.
    pub membrane: Membrane,
    /// Bending elements.
    pub bends: Bends,
    /// Coarse level over the cloth.
    pub coarse: CoarseMesh,
    /// Topology of the search tree over the faces, once it was asked for.
    tree_topology: Buffer<OnceLock<Arc<TreeTopology>>>,
    /// Mean rest length of the edges `[m]`.
    pub mean_edge: f32,
    /// How the render vertices follow, where the shape is coarser than its mesh.
    pub(crate) fine: Option<Arc<Fine>>,
}

/// Render vertices of a shape that is coarser than its mesh.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Fine {
    /// Those that went into another, in ascending order: their particle is that of another vertex.
    pub(crate) gone: Vec<u32>,
    /// What each of all follows.
    pub(crate) embedding: Embedding,
}

impl RestShape {
    /// Welds, cleans, renumbers and colours a mesh.
    ///
    /// # Errors
    /// [`RestError`] when nothing can be simulated.
    pub fn build(mesh: &SourceMesh) -> Result<(Self, BuildReport), RestError> {
        Self::build_from(mesh, None)
    }

    /// The same of a mesh whose edges that are shorter than `shortest_edge` `[m]` are collapsed first. Lengths are between the
    /// `authored` vertices `[m]`, those of the mesh before it was scaled.
    ///
    /// # Errors
    /// [`RestError`] when nothing can be simulated.
    pub(crate) fn build_decimated(
        mesh: &SourceMesh,
        authored: &[Vec3],
        shortest_edge: f32,
    ) -> Result<(Self, BuildReport), RestError> {
        Self::build_from(mesh, Some((authored, shortest_edge)))
    }

    fn build_from(mesh: &SourceMesh, decimation: Option<(&[Vec3], f32)>) -> Result<(Self, BuildReport), RestError> {
        let vertices = mesh.positions.len();
        if vertices < 3 {
            return Err(RestError::TooFewVertices(vertices));
        }
        if let Some(bad) = mesh.positions.iter().position(|p| !p.is_finite()) {
            return Err(RestError::NotFinite(bad));
        }
        if let Some(bad) = mesh.positions.iter().position(|p| p.abs().max_element() > source::FARTHEST) {
            return Err(RestError::TooFar(bad));
        }
        let (low, high) = bounds(&mesh.positions);
        let diagonal = low.distance(high);
        let mut leader = weld::weld(&mesh.positions, weld::WELD_FRACTION * diagonal);
        let mut report = BuildReport { vertices, ..BuildReport::default() };
        let (mut triangles, mut threads) = clean(mesh, &leader, AREA_FRACTION * diagonal * diagonal, &mut report);
        if triangles.is_empty() {
            return Err(RestError::NoTriangles {
                given: mesh.triangles.len(),
                out_of_range: report.out_of_range,
                degenerate: report.degenerate,
            });
        }

        let mut drawn = None;
        if let Some((authored, shortest_edge)) = decimation.filter(|(authored, _)| authored.len() == vertices) {
            let Decimated { triangles: left, of, into } = decimate(authored, &triangles, shortest_edge);
            let ends = |face: &[u32; 3]| face.map(|v| mesh.positions[v as usize]);
            threads = of.iter().zip(&left).filter_map(|(of, face)| Some(threads.get(*of as usize)?.onto(ends(face)))).collect();
            triangles = left;
            let went = |v: &u32| into[leader[*v as usize] as usize] != leader[*v as usize];
            let gone: Vec<u32> = (0..vertices as u32).filter(went).collect();
            leader.iter_mut().for_each(|v| *v = into[*v as usize]);
            drawn = Some(gone).filter(|gone| !gone.is_empty());
        }

        // Particles: the leaders that a face refers to, numbered for locality.
        let mut compact = vec![NONE; vertices];
        let mut origin = Vec::new();
        for &v in triangles.iter().flatten() {
            if compact[v as usize] == NONE {
                compact[v as usize] = origin.len() as u32;
                origin.push(v);
            }
        }
        let given = Topology::new(origin.len() as u32, triangles.iter().map(|t| t.map(|v| compact[v as usize])).collect());
        let number = order::cuthill_mckee(&given);
        let mut positions = vec![Vec3::ZERO; origin.len()];
        for (old, &v) in origin.iter().enumerate() {
            positions[number[old] as usize] = mesh.positions[v as usize];
        }
        let mut faces: Vec<([u32; 3], usize)> = (given.faces.iter().map(|t| t.map(|p| number[p as usize]))).zip(0..).collect();
        faces.sort_by_key(|(t, _)| (t.iter().copied().max(), *t));
        let threads: Vec<weave::Threads> = faces.iter().filter_map(|(_, old)| threads.get(*old).copied()).collect();
        let topology = Topology::new(origin.len() as u32, faces.into_iter().map(|(t, _)| t).collect());
        let twice = weave::of_edges(&topology, &positions, &threads);

        let mut shape = Self {
            areas: vec![0.0; positions.len()],
            particle_of_vertex: leader
                .iter()
                .map(|&l| compact[l as usize])
                .map(|c| if c == NONE { NONE } else { number[c as usize] })
                .collect(),
            springs: Springs::new(&topology, &positions, &twice),
            ..Self::default()
        };
        for face in &topology.faces {
            let [a, b, c] = face.map(|p| positions[p as usize]);
            for &p in face {
                shape.areas[p as usize] += (b - a).cross(c - a).length() / 6.0;
            }
        }
        shape.membrane = Membrane::new(&topology, &positions, &threads);
        shape.bends = Bends::new(&topology, &positions, &shape.areas);
        shape.bends.weave(&topology, &positions, &twice, &threads);
        let length: f64 =
            topology.edges.iter().map(|e| f64::from(positions[e[0] as usize].distance(positions[e[1] as usize]))).sum();
        shape.mean_edge = (length / topology.edges.len() as f64) as f32;
        shape.coarse = CoarseMesh::new(&topology, &positions, shape.mean_edge);
        shape.topology = Arc::new(topology);
        shape.positions = positions;
        shape.attach_isolated(mesh);
        if let Some(gone) = drawn {
            let Self { topology, positions, mean_edge, particle_of_vertex, .. } = &shape;
            let embedding = Embedding::along(&topology.faces, positions, *mean_edge, &mesh.positions, particle_of_vertex);
            shape.fine = embedding.map(|embedding| Arc::new(Fine { gone, embedding }));
        }
        report.particles = shape.positions.len();
        report.faces = shape.topology.faces.len();
        report.isolated = shape.isolated.len();
        debug_assert!(shape.is_consistent());
        Ok((shape, report))
    }

    /// Topology of the search tree over the faces. Islands of several cloths join them, one of a single cloth shares it, as do
    /// multiples of the shape. Made when it is first asked for: cloth that meets no cloth has none.
    pub fn tree_topology(&self) -> &Arc<TreeTopology> {
        self.tree_topology.get_or_init(|| {
            let part = PartRef {
                topology: &self.topology,
                rest: &self.positions,
                garment_layer: 0,
                self_collision: true,
                thickness: 0.0,
            };
            Arc::new(Surface::new(&[part]).map_or_else(|_| TreeTopology::default(), |surface| TreeTopology::new(&surface)))
        })
    }

    /// Whether every index is that of a particle, arrays have one length, and constraints that are solved at once share no
    /// particle.
    fn is_consistent(&self) -> bool {
        let n = self.positions.len();
        let known = |p: &u32| (*p as usize) < n;
        let springs =
            self.springs.a.iter().zip(&self.springs.b).all(|(a, b)| share_nothing(core::array::from_fn(|i| [a[i], b[i]])));
        let mut triangles = self.membrane.corners.iter();
        springs
            && triangles.all(|[a, b, c]| share_nothing(core::array::from_fn(|i| [a[i], b[i], c[i]])))
            && self.bends.hinges.iter().flatten().flatten().all(known)
            && self.springs.a.iter().chain(&self.springs.b).flatten().all(known)
            && self.springs.inverse_square.iter().all(|x| x.is_finite() && x.min_element() > 0.0)
            && self.particle_of_vertex.iter().all(known)
            && self.areas.len() == n
            && self.topology.particles as usize == n
    }

    /// Vertices without a face ride on the nearest particle, found outwards along a sorted axis.
    fn attach_isolated(&mut self, mesh: &SourceMesh) {
        let mut order: Vec<u32> = (0..self.positions.len() as u32).collect();
        order.sort_by(|&a, &b| self.positions[a as usize].x.total_cmp(&self.positions[b as usize].x));
        for (v, particle) in self.particle_of_vertex.iter_mut().enumerate().filter(|(_, p)| **p == NONE) {
            let at = mesh.positions[v];
            let start = order.partition_point(|&p| self.positions[p as usize].x < at.x);
            let (mut nearest, mut best) = (order[0], f32::INFINITY);
            let mut look = |p: u32| {
                let d = self.positions[p as usize] - at;
                let better = (d.length_squared(), p) < (best, nearest);
                if better {
                    (best, nearest) = (d.length_squared(), p);
                }
                d.x * d.x <= best
            };
            order[start..].iter().take_while(|p| look(**p)).for_each(drop);
            order[..start].iter().rev().take_while(|p| look(**p)).for_each(drop);
            *particle = nearest;
            self.isolated.push((v as u32, at - self.positions[nearest as usize]));
        }
    }

    /// Whether a render vertex went into another, where the shape is coarser than its mesh.
    pub(crate) fn is_gone(&self, vertex: u32) -> bool {
        self.fine.as_ref().is_some_and(|fine| fine.gone.binary_search(&vertex).is_ok())
    }

    /// Distance constraints and bending elements solved per substep.
    #[must_use]
    pub fn constraints(&self) -> usize {
        self.springs.count + self.bends.count
    }

    /// Memory held by this shape `[B]`.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let of = size_of_val::<[f32]>;
        let t = &self.topology;
        of(&self.areas)
            + size_of_val(&self.positions[..])
            + size_of_val(&self.particle_of_vertex[..])
            + size_of_val(&self.isolated[..])
            + size_of_val(&t.faces[..])
            + size_of_val(&t.edges[..])
            + size_of_val(&t.edge_faces[..])
            + size_of_val(&t.face_edges[..])
            + size_of_val(&t.neighbour_start[..])
            + size_of_val(&t.neighbours[..])
            + self.springs.a.len() * (2 * size_of::<[u32; LANES]>() + 3 * 16)
            + size_of_val(&self.springs.warp[..])
            + size_of_val(&self.coarse.around[..])
            + size_of_val(&self.coarse.weights[..])
            + self.coarse.links.len() * (size_of::<[u32; 2]>() + size_of::<f32>())
            + self.membrane.bytes()
            + self.bends.bytes()
            + self.fine.as_ref().map_or(0, |fine| size_of_val(&fine.gone[..]) + fine.embedding.bytes())
            + self.tree_topology.get().map_or(0, |tree| tree.bytes())
    }
}

/// Whether the elements of a batch share no particle; a lane that is left over repeats the first or the one before it.
fn share_nothing<const N: usize>(batch: [[u32; N]; LANES]) -> bool {
    let mut pairs = (0..LANES).flat_map(|i| (0..i).map(move |j| (i, j)));
    pairs.all(|(i, j)| batch[i] == batch[j] || !batch[i].iter().any(|p| batch[j].contains(p)))
}

/// Smallest and largest corner `[m]` of a non-empty set of points.
fn bounds(points: &[Vec3]) -> (Vec3, Vec3) {
    points.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)))
}

/// Welded triangles without those that are out of range, degenerate or repeated, either way round; and the directions of their
/// threads, if any has one.
fn clean(mesh: &SourceMesh, leader: &[u32], area: f32, report: &mut BuildReport) -> (Vec<[u32; 3]>, Vec<weave::Threads>) {
    let mut kept: Vec<([u32; 3], [u32; 3], Option<weave::Threads>)> = Vec::with_capacity(mesh.triangles.len());
    for triangle in &mesh.triangles {
        if triangle.iter().any(|&v| v as usize >= leader.len()) {
            report.out_of_range += 1;
            continue;
        }
        let corners = triangle.map(|v| leader[v as usize]);
        let [a, b, c] = corners.map(|v| mesh.positions[v as usize]);
        if !((b - a).cross(c - a).length() > 2.0 * area) {
            report.degenerate += 1;
            continue;
        }
        let mut key = corners;
        key.sort_unstable();
        let uv = (mesh.uvs.len() == mesh.positions.len()).then(|| triangle.map(|v| mesh.uvs[v as usize]));
        kept.push((key, corners, uv.and_then(|uv| weave::Threads::new([a, b, c], uv))));
    }
    let mut order: Vec<usize> = (0..kept.len()).collect();
    order.sort_by_key(|&i| (kept[i].0, i));
    let mut repeated = vec![false; kept.len()];
    for pair in order.windows(2) {
        repeated[pair[1]] = kept[pair[0]].0 == kept[pair[1]].0;
    }
    report.duplicate = repeated.iter().filter(|r| **r).count();
    let kept = kept.into_iter().zip(repeated).filter(|(_, r)| !r).map(|(triangle, _)| triangle);
    let (triangles, threads): (Vec<_>, Vec<_>) = kept.map(|(_, corners, threads)| (corners, threads)).unzip();
    report.without_warp = threads.iter().filter(|t| t.is_none()).count();
    let any = report.without_warp < threads.len();
    (triangles, if any { threads.into_iter().map(Option::unwrap_or_default).collect() } else { Vec::new() })
}
