//! The boxes of a tree by depth, to be looked at.

use super::{Bounds, IS_LEAF, Tree};

impl Tree {
    /// The boxes `[m]` down to a `depth`, each with its own, as of the last [`Self::refit`]. The root is at depth 0; what is in
    /// no smaller box is in a leaf.
    pub fn boxes(&self, depth: u32) -> impl Iterator<Item = (u32, Bounds)> + '_ {
        let mut stack: Vec<(u32, u32)> = if self.nodes.is_empty() { Vec::new() } else { vec![(0, 0)] };
        core::iter::from_fn(move || {
            let (i, level) = stack.pop()?;
            let node = &self.nodes[i as usize];
            if node.right & IS_LEAF == 0 && level < depth {
                stack.extend([(node.right, level + 1), (i + 1, level + 1)]);
            }
            Some((level, node.bounds))
        })
    }
}
