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
            has_fans: has_fans(surface),
            tools: Buffer::default(),
            costs: [0; 2],
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

/// Whether each corner of each face has an edge that knows the face.
fn has_fans(surface: &Surface) -> bool {
    let topology = &surface.topology;
    topology.face_edges.iter().zip(0..).all(|(edges, f)| {
        let knows = |k: usize| topology.edge_faces[edges[k] as usize].contains(&f);
        // Corner k is between edge k and the one before.
        (0..3).all(|k| knows(k) || knows((k + 2) % 3))
    })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::Vec3;

    use super::*;
    use crate::solver::detect::PartRef;
    use crate::solver::topology::Topology;

    #[test]
    fn a_face_that_is_third_at_both_edges_of_a_corner_is_not_known_there() {
        let pages = vec![[0, 1, 3], [0, 1, 4], [0, 2, 5], [0, 2, 6], [0, 1, 2]];
        let known = |faces: &[[u32; 3]]| {
            let (topology, rest) = (Arc::new(Topology::new(7, faces.to_vec())), [Vec3::ZERO; 7]);
            let part = PartRef { topology: &topology, rest: &rest, garment_layer: 0, self_collision: true, thickness: 0.01 };
            has_fans(&Surface::new(&[part]).expect("a cloth"))
        };
        assert!(known(&pages[..4]) && known(&[pages[0], pages[1], pages[4]]), "another edge knows the third face");
        assert!(!known(&pages));
    }
}
