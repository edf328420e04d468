//! Joints: pairs of nodes that share particles, known from the start.

use super::shared::Shared;
use super::{HUB, IS_LEAF, Joint, MIXED, TreeTopology};
use crate::solver::detect::Surface;
use crate::solver::topology::NONE;

impl TreeTopology {
    /// Finds the pairs of nodes that share particles, from the children of each node downwards.
    pub(super) fn find_joints(&mut self, surface: &Surface, shared: &Shared) {
        let mut queue = std::collections::VecDeque::new();
        for i in 0..self.branches.len() as u32 {
            let node = self.branches[i as usize];
            if node.right & IS_LEAF != 0 || node.part == MIXED {
                continue;
            }
            // Through the hub of a fan of thousands every node would be joined to every other; boxes do for it.
            let is_hub = |v: u32| surface.topology.around(v).len() > HUB;
            let between: Vec<u32> = shared.particles(i).iter().copied().filter(|&v| !is_hub(v)).collect();
            if !between.is_empty() {
                self.branches[i as usize].link = self.joints.len() as u32;
                self.joints.push(Joint { nodes: [i + 1, node.right], first: 0, count: 0 });
                queue.push_back((self.joints.len() - 1, between));
            }
            while let Some((joint, between)) = queue.pop_front() {
                self.joints[joint].first = self.joints.len() as u32;
                for [a, b] in below(|i| self.branches[i as usize].right, self.joints[joint].nodes) {
                    let both = |v: &u32| shared.has(a, *v) && shared.has(b, *v);
                    let between: Vec<u32> = between.iter().copied().filter(both).collect();
                    if !between.is_empty() {
                        self.joints[joint].count += 1;
                        queue.push_back((self.joints.len(), between));
                        self.joints.push(Joint { nodes: [a, b], first: 0, count: 0 });
                    }
                }
            }
        }
    }
}

/// The pairs that two different nodes fall into, none of two leaves; `right` is that of a [`Branch`](super::Branch).
#[inline]
pub(super) fn below<F: Fn(u32) -> u32>(right: F, [a, b]: [u32; 2]) -> impl Iterator<Item = [u32; 2]> + use<F> {
    let halves = |i: u32| {
        let right = right(i);
        if right & IS_LEAF == 0 { [i + 1, right] } else { [i, NONE] }
    };
    let (left, right) = (halves(a), halves(b));
    let pairs = [[left[0], right[0]], [left[0], right[1]], [left[1], right[0]], [left[1], right[1]]];
    let leaves = left[1] == NONE && right[1] == NONE;
    pairs.into_iter().filter(move |pair| !leaves && !pair.contains(&NONE))
}
