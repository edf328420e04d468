//! Several cloths in one index space.
//!
//! ```text
//!            cloth 0        cloth 1     cloth 2
//! particles [0 ....... n0)[n0 .... n1)[n1 .. n2)      edges and faces likewise, each cloth a contiguous range
//! ```
//!
//! Because ranges are contiguous, comparing global ids orders whole cloths. So two cloths that only touch give every tie of the
//! orientation test the same sign, and count as not crossing.

use core::ops::Range;
use std::sync::Arc;

use glam::{Vec3, Vec3A, Vec4};

use crate::solver::scales::FARTHEST;
use crate::solver::topology::Topology;

/// One cloth to be concatenated into a [`Surface`].
#[derive(Clone, Copy, Debug)]
pub struct PartRef<'a> {
    /// Connectivity of the cloth.
    pub topology: &'a Arc<Topology>,
    /// Rest positions `[m]`, one per particle; they give areas, edge lengths and the topology of the search tree.
    pub rest: &'a [Vec3],
    /// Order of layered garments: of two cloths, the one with the larger number is worn outside. Equal numbers have no order.
    pub garment_layer: i32,
    /// Whether crossings of the cloth with itself count.
    pub self_collision: bool,
    /// Thickness of the cloth `[m]`: the distance at which two of its sides touch.
    pub thickness: f32,
}

/// Where one cloth lies inside a [`Surface`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Part {
    /// Its particles.
    pub particles: Range<u32>,
    /// Its edges.
    pub edges: Range<u32>,
    /// Its faces.
    pub faces: Range<u32>,
    /// Order of layered garments; larger is outside.
    pub garment_layer: i32,
    /// Whether crossings of the cloth with itself count.
    pub self_collision: bool,
    /// Thickness `[m]`.
    pub thickness: f32,
}

/// What of a [`Part`] may change while it is simulated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct PartSettings {
    /// As [`Part::garment_layer`].
    pub garment_layer: i32,
    /// As [`Part::self_collision`].
    pub self_collision: bool,
    /// As [`Part::thickness`] `[m]`.
    pub thickness: f32,
}

impl Part {
    /// Its particles.
    #[must_use]
    pub(crate) fn range(&self) -> Range<usize> {
        self.particles.start as usize..self.particles.end as usize
    }
}

/// Why cloths cannot be concatenated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SurfaceError {
    /// A cloth has another number of rest positions than particles.
    #[error("cloth {part} has {positions} rest positions for {particles} particles")]
    RestLength {
        /// Which cloth.
        part: usize,
        /// Rest positions given.
        positions: usize,
        /// Particles of its topology.
        particles: usize,
    },
    /// More cloths or particles than the indices can hold.
    #[error("more than {limit} {what} in one surface")]
    TooMany {
        /// What there is too much of.
        what: &'static str,
        /// The largest number allowed.
        limit: usize,
    },
}

/// One or several cloths in one index space. Immutable; positions are passed beside it as concatenated slices.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Surface {
    /// Connectivity over the particles of all cloths; shared with the only one.
    pub topology: Arc<Topology>,
    /// The cloths, in the order given.
    pub parts: Vec<Part>,
    /// Cloth of every particle.
    pub part_of_particle: Vec<u16>,
    /// Rest positions `[m]` of every particle.
    pub rest: Vec<Vec3>,
    /// Third of the rest area around every particle `[m²]`.
    pub areas: Vec<f32>,
    /// Whether a particle lies on a border.
    pub on_border: Vec<bool>,
    /// Mean rest length of all edges `[m]`.
    pub mean_edge: f32,
}

impl Surface {
    /// Concatenates cloths.
    ///
    /// # Errors
    /// [`SurfaceError`] when rest positions do not match a topology, or when there are too many cloths or particles.
    pub fn new(cloths: &[PartRef<'_>]) -> Result<Self, SurfaceError> {
        let limit = usize::from(u16::MAX);
        if cloths.len() > limit {
            return Err(SurfaceError::TooMany { what: "cloths", limit });
        }
        let total: usize = cloths.iter().map(|c| c.topology.particles as usize).sum();
        let limit = (u32::MAX / 8) as usize;
        if total > limit {
            return Err(SurfaceError::TooMany { what: "particles", limit });
        }
        let topology = match cloths {
            [only] => Arc::clone(only.topology),
            _ => Arc::new(Topology::join(cloths.iter().map(|cloth| &**cloth.topology))),
        };
        let mut surface = Self { topology, ..Self::default() };
        for (i, cloth) in cloths.iter().enumerate() {
            let particles = cloth.topology.particles as usize;
            if cloth.rest.len() != particles {
                return Err(SurfaceError::RestLength { part: i, positions: cloth.rest.len(), particles });
            }
            surface.append(i as u16, cloth);
        }
        surface.measure();
        Ok(surface)
    }

    /// Gives a cloth other positions at rest `[m]`; false if it has another number of them.
    pub(crate) fn reshape(&mut self, part: usize, rest: &[Vec3]) -> bool {
        let range = self.parts.get(part).map(Part::range);
        let Some(mine) = range.and_then(|range| self.rest.get_mut(range)).filter(|mine| mine.len() == rest.len()) else {
            return false;
        };
        mine.copy_from_slice(rest);
        self.measure();
        true
    }

    fn append(&mut self, index: u16, cloth: &PartRef<'_>) {
        let of = cloth.topology;
        let [p0, e0, f0] = self.parts.last().map_or([0; 3], |last| [last.particles.end, last.edges.end, last.faces.end]);
        self.rest.extend_from_slice(cloth.rest);
        self.part_of_particle.resize(self.rest.len(), index);
        self.parts.push(Part {
            particles: p0..p0 + of.particles,
            edges: e0..e0 + of.edges.len() as u32,
            faces: f0..f0 + of.faces.len() as u32,
            garment_layer: cloth.garment_layer,
            self_collision: cloth.self_collision,
            thickness: cloth.thickness,
        });
    }

    fn measure(&mut self) {
        self.areas.clear();
        self.areas.resize(self.rest.len(), 0.0);
        for t in &self.topology.faces {
            let [a, b, c] = t.map(|v| self.rest[v as usize]);
            let third = (b - a).cross(c - a).length() / 6.0;
            for &v in t {
                self.areas[v as usize] += third;
            }
        }
        let edges = &self.topology.edges;
        self.on_border.clear();
        self.on_border.resize(self.rest.len(), false);
        for (e, ends) in edges.iter().enumerate() {
            if self.topology.is_border(e as u32) {
                self.on_border[ends[0] as usize] = true;
                self.on_border[ends[1] as usize] = true;
            }
        }
        let sum: f64 = edges.iter().map(|e| f64::from(self.rest[e[0] as usize].distance(self.rest[e[1] as usize]))).sum();
        self.mean_edge = (sum / edges.len().max(1) as f64) as f32;
    }

    /// Finds the squares of the least heights of the faces around each particle `[m²]`, infinite where there is no face.
    /// Particles are `at` their positions `[m]`.
    pub(crate) fn least_heights_squared(&self, at: impl Fn(u32) -> Vec3A, squares: &mut Vec<f32>) {
        squares.clear();
        squares.resize(self.len(), f32::INFINITY);
        for t in &self.topology.faces {
            let [a, b, c] = t.map(&at);
            let base = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
            let height = (b - a).cross(c - a).length_squared() / base.max(f32::MIN_POSITIVE);
            t.iter().for_each(|&v| squares[v as usize] = squares[v as usize].min(height));
        }
    }

    /// Cloth of a particle.
    #[must_use]
    pub fn part(&self, particle: u32) -> u16 {
        self.part_of_particle[particle as usize]
    }

    /// Cloth of a face.
    #[must_use]
    pub(crate) fn part_of_face(&self, face: u32) -> u16 {
        self.part(self.topology.faces[face as usize][0])
    }

    /// Cloth of an edge.
    #[must_use]
    pub(crate) fn part_of_edge(&self, edge: u32) -> u16 {
        self.part(self.topology.edges[edge as usize][0])
    }

    /// Number of particles.
    #[must_use]
    pub fn len(&self) -> usize {
        self.rest.len()
    }

    /// Whether there are no particles.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rest.is_empty()
    }
}

/// Whether a position can be handed to the search tree.
#[must_use]
pub(crate) fn is_sane(p: Vec4) -> bool {
    let p = p.truncate().abs();
    // `NaN` compares false.
    p.x <= FARTHEST && p.y <= FARTHEST && p.z <= FARTHEST
}
