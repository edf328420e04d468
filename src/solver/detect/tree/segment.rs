//! Walks the tree along a segment.

use glam::{Vec3, Vec3A};

use super::{Bounds, IS_LEAF, Tree};

impl Tree {
    /// Calls `found` with every face whose box a segment from `from` along `path` `[m]` may meet.
    pub fn along(&mut self, from: Vec3, path: Vec3, mut found: impl FnMut(u32)) {
        if self.nodes.is_empty() {
            return;
        }
        let (a, b) = (Vec3A::from(from), Vec3A::from(from + path));
        let segment = Bounds { min: a.min(b), max: a.max(b) };
        let inverse = Vec3A::from(path).recip();
        let hit = |bounds: &Bounds| {
            if !bounds.meets(&segment, Vec3A::ZERO) {
                return false;
            }
            // Slabs; an axis without motion gives infinities of both signs or NaN, which `max` and `min` let pass.
            let (u, v) = ((bounds.min - a) * inverse, (bounds.max - a) * inverse);
            let (near, far) = (u.min(v), u.max(v));
            let near = near.x.max(near.y).max(near.z);
            let far = far.x.min(far.y).min(far.z);
            near.partial_cmp(&(far * (1.0 + 1.0e-5) + 1.0e-6)) != Some(core::cmp::Ordering::Greater)
        };
        let mut stack = core::mem::take(&mut self.stack);
        stack.clear();
        stack.push((0, 0));
        while let Some((i, _)) = stack.pop() {
            let node = &self.nodes[i as usize];
            if !hit(&node.bounds) {
                continue;
            }
            if node.right & IS_LEAF == 0 {
                stack.push((node.right, 0));
                stack.push((i + 1, 0));
            } else {
                for (lane, &face) in self.topology.faces[node.run()].iter().enumerate() {
                    if hit(&self.packs[node.link as usize].get(lane)) {
                        found(face);
                    }
                }
            }
        }
        self.stack = stack;
    }
}
