//! Which nodes are pieces of cloth that cannot cross themselves while their normals hardly differ: discs.

use super::{MIXED, Tree};
use crate::solver::detect::Surface;
use crate::solver::detect::seams::{loose, rest_box, runs_along_a_side, seams};
use crate::solver::rest::NONE;

impl Tree {
    /// Marks the nodes whose faces form a disc (connected, `V - E + F = 1`) without seams and with borders of the mesh at the sides of its box only.
    pub(super) fn find_discs(&mut self, surface: &Surface) {
        let topology = &surface.topology;
        let mut owner = vec![u32::MAX; topology.faces.len()];
        let mut seen_edge = vec![u32::MAX; topology.edges.len()];
        let mut seen_vertex = vec![u32::MAX; surface.len()];
        let mut queue = Vec::new();
        let seams = seams(surface);
        let loose = loose(surface, &seams);
        for i in 0..self.nodes.len() {
            let faces = self.faces_below(i);
            let id = i as u32;
            if self.nodes[i].part == MIXED || faces.is_empty() {
                continue;
            }
            for &f in &self.faces[faces.clone()] {
                owner[f as usize] = id;
            }
            let corners = self.faces[faces.clone()].iter().flat_map(|&f| topology.faces[f as usize]);
            let own = rest_box(surface, corners);
            let (mut vertices, mut edges, mut reached, mut is_cut, mut is_loose) = (0, 0, 0, false, false);
            queue.clear();
            queue.push(self.faces[faces.start]);
            owner[self.faces[faces.start] as usize] = u32::MAX;
            while let Some(f) = queue.pop() {
                reached += 1;
                for v in topology.faces[f as usize] {
                    vertices += usize::from(seen_vertex[v as usize] != id);
                    seen_vertex[v as usize] = id;
                    is_loose |= loose[v as usize];
                }
                for e in topology.face_edges[f as usize] {
                    edges += usize::from(seen_edge[e as usize] != id);
                    seen_edge[e as usize] = id;
                    is_cut |= seams[e as usize] || (topology.is_border(e) && !runs_along_a_side(surface, own, e));
                    for g in topology.edge_faces[e as usize] {
                        if g != NONE && owner[g as usize] == id {
                            owner[g as usize] = u32::MAX;
                            queue.push(g);
                        }
                    }
                }
            }
            let disc = reached == faces.len() && vertices + reached == edges + 1;
            self.nodes[i].disc = disc && !is_cut;
            self.nodes[i].smooth = disc && !is_loose;
        }
    }
}
