//! Which nodes are pieces of cloth that cannot cross themselves while their normals hardly differ: discs.

use glam::Vec3;

use super::shared::Shared;
use super::{IS_LEAF, MIXED, TreeTopology};
use crate::solver::detect::Surface;
use crate::solver::detect::seams::{loose, rest_box, runs_along_a_side, seams};
use crate::solver::topology::NONE;

/// The faces below a node.
#[derive(Clone, Copy)]
struct Piece {
    /// Smallest and largest corner at rest `[m]`.
    bounds: [Vec3; 2],
    /// Euler characteristic: vertices less edges plus faces.
    euler: i64,
    /// Whether every face is reached from every other across edges.
    connected: bool,
    /// Whether there is an edge at which normals say nothing.
    seam: bool,
    /// Whether there is a particle around which cloth may lie over itself although normals agree.
    loose: bool,
}

impl TreeTopology {
    /// Marks the nodes whose faces form a disc (connected, `V - E + F = 1`) without seams. Borders of the mesh may be at the
    /// sides of its box only.
    ///
    /// The facts on the children of a node give those of the node, except where one of the children is in pieces. Then the
    /// faces of the node are walked.
    pub(super) fn find_discs(&mut self, surface: &Surface, shared: &Shared) {
        let topology = &surface.topology;
        let seams = seams(surface);
        let loose = loose(surface, &seams);
        // Borders of the mesh, in the order of their faces.
        let mut borders: Vec<(u32, u32)> = (0..topology.edges.len() as u32)
            .filter(|&e| topology.is_border(e))
            .map(|e| (shared.place[topology.edge_faces[e as usize][0] as usize], e))
            .collect();
        borders.sort_unstable();
        let mut flood = Flood { owner: vec![NONE; topology.faces.len()], queue: Vec::new() };
        let nothing = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        let mut pieces =
            vec![Piece { bounds: nothing, euler: 0, connected: false, seam: false, loose: false }; self.branches.len()];
        for i in (0..self.branches.len()).rev() {
            let node = self.branches[i];
            let range = shared.ranges[i].clone();
            if node.part == MIXED || range.is_empty() {
                continue;
            }
            let faces = &self.faces[range.start as usize..range.end as usize];
            pieces[i] = if node.right & IS_LEAF == 0 {
                let [a, b] = [pieces[i + 1], pieces[node.right as usize]];
                let edges = shared.edges[i];
                Piece {
                    bounds: [a.bounds[0].min(b.bounds[0]), a.bounds[1].max(b.bounds[1])],
                    euler: a.euler + b.euler - shared.particles(i as u32).len() as i64 + i64::from(edges),
                    connected: if a.connected && b.connected { edges > 0 } else { flood.connects(surface, i as u32, faces) },
                    seam: a.seam || b.seam,
                    loose: a.loose || b.loose,
                }
            } else {
                flood.leaf(surface, i as u32, faces, &seams, &loose)
            };
            let Piece { bounds, euler, connected, seam, loose } = pieces[i];
            let first = borders.partition_point(|(at, _)| *at < range.start);
            let mut own = borders[first..].iter().take_while(|(at, _)| *at < range.end);
            let disc = connected && euler == 1;
            self.branches[i].disc = disc && !seam && own.all(|&(_, e)| runs_along_a_side(surface, bounds, e));
            self.branches[i].smooth = disc && !loose;
        }
    }
}

/// Walks over faces from one to the next.
struct Flood {
    /// The node that asks, of faces that were not reached yet.
    owner: Vec<u32>,
    queue: Vec<u32>,
}

impl Flood {
    /// Whether every one of some `faces` of a node is reached from the first.
    fn connects(&mut self, surface: &Surface, node: u32, faces: &[u32]) -> bool {
        let topology = &surface.topology;
        faces.iter().for_each(|&f| self.owner[f as usize] = node);
        self.queue.clear();
        self.queue.push(faces[0]);
        self.owner[faces[0] as usize] = NONE;
        let mut reached = 0;
        while let Some(f) = self.queue.pop() {
            reached += 1;
            for g in topology.face_edges[f as usize].into_iter().flat_map(|e| topology.edge_faces[e as usize]) {
                if g != NONE && self.owner[g as usize] == node {
                    self.owner[g as usize] = NONE;
                    self.queue.push(g);
                }
            }
        }
        faces.iter().for_each(|&f| self.owner[f as usize] = NONE);
        reached == faces.len()
    }

    /// The few faces of a leaf.
    fn leaf(&mut self, surface: &Surface, node: u32, faces: &[u32], seams: &[bool], loose: &[bool]) -> Piece {
        let topology = &surface.topology;
        let distinct = |of: &[[u32; 3]]| {
            let all = || faces.iter().flat_map(|&f| of[f as usize]);
            all().enumerate().filter(|&(k, number)| !all().take(k).any(|other| other == number)).count() as i64
        };
        let corners = || faces.iter().flat_map(|&f| topology.faces[f as usize]);
        let edges = || faces.iter().flat_map(|&f| topology.face_edges[f as usize]);
        Piece {
            bounds: rest_box(surface, corners()),
            euler: distinct(&topology.faces) - distinct(&topology.face_edges) + faces.len() as i64,
            connected: self.connects(surface, node, faces),
            seam: edges().any(|e| seams[e as usize]),
            loose: corners().any(|v| loose[v as usize]),
        }
    }
}
