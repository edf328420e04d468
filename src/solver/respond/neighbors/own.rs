//! Who asks for what: each particle and each edge is asked for by one of its faces.

use glam::Vec3A;

use super::NeighborList;
use super::looked::Looked;
use super::patch::Patches;
use crate::solver::buffer::Buffer;
use crate::solver::detect::Surface;
use crate::solver::detect::seams::{loose, seams};
use crate::solver::detect::tree::Tree;

impl NeighborList {
    /// Prepares finding on a surface.
    #[must_use]
    pub(crate) fn new(surface: &Surface, tree: &Tree) -> Self {
        let topology = &surface.topology;
        let mut owns = vec![0; topology.faces.len()];
        let mut owned = vec![false; surface.len()];
        for (f, t) in topology.faces.iter().enumerate() {
            for (k, &v) in t.iter().enumerate() {
                if !std::mem::replace(&mut owned[v as usize], true) {
                    owns[f] |= 1 << k;
                }
                if topology.edge_faces[topology.face_edges[f][k] as usize][0] == f as u32 {
                    owns[f] |= 8 << k;
                }
            }
        }
        let start = vec![Vec3A::ZERO; surface.len()];
        let (astray, marked) = (vec![false; surface.len()], vec![false; topology.faces.len()]);
        let shifted = astray.clone();
        let mut neighbors = Self {
            patches: Patches::new(tree, &topology.faces, &owns),
            ahead: start.clone(),
            before: vec![Vec3A::INFINITY; surface.len()],
            there: start.clone(),
            start,
            astray,
            shifted,
            marked,
            shared: Vec3A::ZERO,
            haste: 0.0,
            faces: vec![Looked::default(); topology.faces.len()],
            drift: vec![0.0; surface.len()],
            longest: Vec::new(),
            loose: loose(surface, &seams(surface)),
            tools: Buffer::default(),
            visits: 0,
            is_cut: false,
        };
        neighbors.measure(surface);
        neighbors
    }

    /// Measures the longest edges of a surface, which is new or some times as large as before.
    pub(crate) fn measure(&mut self, surface: &Surface) {
        let length = |e: u32| {
            let [a, b] = surface.topology.edges[e as usize].map(|v| surface.rest[v as usize]);
            a.distance(b)
        };
        self.longest.clear();
        self.longest.extend(surface.parts.iter().map(|part| part.edges.clone().map(length).fold(0.0, f32::max)));
    }
}
