//! Joints: pairs of nodes that share particles, known from the start.

use super::{HUB, IS_LEAF, Joint, MIXED, Tree};
use crate::solver::detect::Surface;
use crate::solver::rest::NONE;

impl Tree {
    /// Finds the pairs of nodes that share particles, from the children of each node downwards.
    pub(super) fn find_joints(&mut self, surface: &Surface) {
        let topology = &surface.topology;
        let place = self.places();
        let ranges: Vec<_> = (0..self.nodes.len()).map(|i| self.faces_below(i)).collect();
        let belongs = |v: u32, node: u32| {
            topology.around(v).iter().any(|&(_, e)| {
                let faces = topology.edge_faces[e as usize];
                faces.iter().any(|&f| f != NONE && ranges[node as usize].contains(&(place[f as usize] as usize)))
            })
        };
        let mut queue = std::collections::VecDeque::new();
        for i in 0..self.nodes.len() as u32 {
            let node = self.nodes[i as usize];
            if node.right & IS_LEAF != 0 || node.part == MIXED {
                continue;
            }
            let below = self.faces[ranges[i as usize + 1].clone()].iter().flat_map(|&f| topology.faces[f as usize]);
            // Through the hub of a fan of thousands every node would be joined to every other; boxes do for it.
            let mut shared: Vec<u32> = below.filter(|&v| topology.around(v).len() <= HUB && belongs(v, node.right)).collect();
            shared.sort_unstable();
            shared.dedup();
            if !shared.is_empty() {
                self.nodes[i as usize].link = self.joints.len() as u32;
                self.joints.push(Joint { nodes: [i + 1, node.right], first: 0, count: 0 });
                queue.push_back((self.joints.len() - 1, shared));
            }
            while let Some((joint, shared)) = queue.pop_front() {
                self.joints[joint].first = self.joints.len() as u32;
                for [a, b] in self.below(self.joints[joint].nodes) {
                    let shared: Vec<u32> = shared.iter().copied().filter(|&v| belongs(v, a) && belongs(v, b)).collect();
                    if !shared.is_empty() {
                        self.joints[joint].count += 1;
                        queue.push_back((self.joints.len(), shared));
                        self.joints.push(Joint { nodes: [a, b], first: 0, count: 0 });
                    }
                }
            }
        }
    }

    /// The pairs that two different nodes fall into; none of two leaves.
    pub(super) fn below(&self, [a, b]: [u32; 2]) -> impl Iterator<Item = [u32; 2]> + use<> {
        let halves = |i: u32| {
            let right = self.nodes[i as usize].right;
            if right & IS_LEAF == 0 { [i + 1, right] } else { [i, NONE] }
        };
        let (left, right) = (halves(a), halves(b));
        let pairs = [[left[0], right[0]], [left[0], right[1]], [left[1], right[0]], [left[1], right[1]]];
        let leaves = left[1] == NONE && right[1] == NONE;
        pairs.into_iter().filter(move |pair| !leaves && !pair.contains(&NONE))
    }
}
