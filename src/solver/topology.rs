//! Which particles, edges and faces meet.

/// Marks an absent face in [`Topology::edge_faces`].
pub const NONE: u32 = u32::MAX;

/// Connectivity of a welded triangle mesh. Immutable after [`Topology::new`].
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Topology {
    /// Number of particles; every index below is smaller.
    pub particles: u32,
    /// Faces as triples of particles, counter-clockwise seen from the front. No degenerate and no duplicate faces.
    pub faces: Vec<[u32; 3]>,
    /// Unique edges, smaller particle first, sorted.
    pub edges: Vec<[u32; 2]>,
    /// The first two faces at each edge, smaller first; [`NONE`] beyond a border. A third face of a non-manifold edge is not
    /// listed.
    pub edge_faces: Vec<[u32; 2]>,
    /// Edges of each face: edge `k` joins corners `k` and `(k + 1) % 3`.
    pub face_edges: Vec<[u32; 3]>,
    /// Start of each particle's run in [`Self::neighbours`]; `particles + 1` entries.
    pub neighbour_start: Vec<u32>,
    /// Neighbours of every particle along edges: `(particle, edge)`, sorted by particle within a run.
    pub neighbours: Vec<(u32, u32)>,
}

impl Topology {
    /// Puts those of several cloths one behind the other.
    #[must_use]
    pub(crate) fn join<'a>(cloths: impl Iterator<Item = &'a Self>) -> Self {
        let mut to = Self { neighbour_start: vec![0], ..Self::default() };
        for from in cloths {
            let (p0, e0, f0) = (to.particles, to.edges.len() as u32, to.faces.len() as u32);
            let face = |f: u32| if f == NONE { NONE } else { f + f0 };
            to.particles += from.particles;
            to.faces.extend(from.faces.iter().map(|t| t.map(|v| v + p0)));
            to.edges.extend(from.edges.iter().map(|e| e.map(|v| v + p0)));
            to.edge_faces.extend(from.edge_faces.iter().map(|e| e.map(face)));
            to.face_edges.extend(from.face_edges.iter().map(|t| t.map(|e| e + e0)));
            let run0 = to.neighbours.len() as u32;
            to.neighbour_start.extend(from.neighbour_start.iter().skip(1).map(|s| s + run0));
            to.neighbours.extend(from.neighbours.iter().map(|&(v, e)| (v + p0, e + e0)));
        }
        to
    }

    /// Connects `faces` over `particles` particles. Faces must index below `particles` and have three different corners.
    #[must_use]
    pub fn new(particles: u32, faces: Vec<[u32; 3]>) -> Self {
        let mut half: Vec<(u32, u32, u32, u8)> = Vec::with_capacity(faces.len() * 3);
        for (f, t) in faces.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (t[k], t[(k + 1) % 3]);
                half.push((a.min(b), a.max(b), f as u32, k as u8));
            }
        }
        half.sort_unstable();
        let mut topology = Self { particles, face_edges: vec![[NONE; 3]; faces.len()], faces, ..Self::default() };
        for (a, b, face, k) in half {
            if topology.edges.last() != Some(&[a, b]) {
                topology.edges.push([a, b]);
                topology.edge_faces.push([NONE; 2]);
            }
            let edge = topology.edges.len() - 1;
            topology.face_edges[face as usize][k as usize] = edge as u32;
            if let Some(slot) = topology.edge_faces[edge].iter_mut().find(|s| **s == NONE) {
                *slot = face;
            }
        }
        topology.link_neighbours();
        topology
    }

    fn link_neighbours(&mut self) {
        let mut start = vec![0u32; self.particles as usize + 1];
        for e in &self.edges {
            start[e[0] as usize + 1] += 1;
            start[e[1] as usize + 1] += 1;
        }
        for i in 1..start.len() {
            start[i] += start[i - 1];
        }
        let mut next = start.clone();
        let mut neighbours = vec![(0, 0); self.edges.len() * 2];
        for (i, e) in self.edges.iter().enumerate() {
            for (a, b) in [(e[0], e[1]), (e[1], e[0])] {
                neighbours[next[a as usize] as usize] = (b, i as u32);
                next[a as usize] += 1;
            }
        }
        for p in 0..self.particles as usize {
            neighbours[start[p] as usize..start[p + 1] as usize].sort_unstable();
        }
        self.neighbour_start = start;
        self.neighbours = neighbours;
    }

    /// Neighbours of a particle with the edge that leads to each.
    #[must_use]
    pub fn around(&self, particle: u32) -> &[(u32, u32)] {
        let p = particle as usize;
        &self.neighbours[self.neighbour_start[p] as usize..self.neighbour_start[p + 1] as usize]
    }

    /// The corner of `face` that is not on `edge`.
    #[must_use]
    pub(crate) fn opposite(&self, edge: u32, face: u32) -> u32 {
        let [a, b] = self.edges[edge as usize];
        let t = self.faces[face as usize];
        t.into_iter().find(|&v| v != a && v != b).unwrap_or(t[0])
    }

    /// Whether an edge has fewer than two faces.
    #[must_use]
    pub fn is_border(&self, edge: u32) -> bool {
        self.edge_faces[edge as usize][1] == NONE
    }
}
