//! Fits the boxes and the normals to where particles are now, bottom-up.

use glam::{Vec3A, Vec4};

use super::{Bounds, IS_LEAF, Leaf, Node, Tree, TreeTopology};
use crate::solver::detect::Surface;
use crate::solver::detect::surface::is_sane;

impl Tree {
    /// Fits the boxes to the positions `[m]` and finds the cloths to leave out.
    ///
    /// With `ahead` `[m]`, one per particle, boxes also hold where particles will be; normals do not.
    pub(crate) fn refit(&mut self, surface: &Surface, positions: &[Vec4], ahead: Option<&[Vec3A]>) {
        for (part, out) in surface.parts.iter().zip(&mut self.quarantined) {
            let range = part.range();
            *out = !positions[range].iter().all(|&p| is_sane(p));
        }
        let now = |v: u32| Vec3A::from_vec4(positions[v as usize]);
        let point = |x: Vec3A| Bounds { min: x, max: x };
        match ahead {
            None => self.fit_leaves(now, |corners| Bounds::around(corners.map(now).into_iter())),
            Some(ahead) => self.fit_leaves(now, |corners| {
                let [a, b, c] = corners.map(|v| point(now(v)).union(point(ahead[v as usize])));
                a.union(b).union(c)
            }),
        }
        for i in (0..self.nodes.len()).rev() {
            let right = self.nodes[i].right;
            if right & IS_LEAF == 0 {
                let (left, right) = (&self.nodes[i + 1], &self.nodes[right as usize]);
                let (bounds, normals) = (left.bounds.union(right.bounds), left.normals.union(right.normals));
                (self.nodes[i].bounds, self.nodes[i].normals) = (bounds, normals);
            }
        }
        self.find_folds();
        debug_assert!(self.encloses());
    }

    /// Whether the box of every inner node holds those of its children.
    fn encloses(&self) -> bool {
        let holds = |node: &Node, child: &Node| {
            node.bounds.min.cmple(child.bounds.min).all() && node.bounds.max.cmpge(child.bounds.max).all()
        };
        let inner = self.nodes.iter().enumerate().filter(|(_, node)| node.right & IS_LEAF == 0);
        let mut children = inner.map(|(i, node)| (node, &self.nodes[i + 1], &self.nodes[node.right as usize]));
        children.all(|(node, left, right)| holds(node, left) && holds(node, right))
    }

    /// Fits the leaves and their faces to where particles are `now` `[m]`; `around` is the box of three of them.
    #[inline]
    fn fit_leaves(&mut self, now: impl Fn(u32) -> Vec3A, around: impl Fn([u32; 3]) -> Bounds) {
        let TreeTopology { leaves, corners, .. } = &*self.topology;
        for (leaf, axis) in leaves.iter().zip(&mut self.axes) {
            let node = &mut self.nodes[leaf.node as usize];
            let run = node.run();
            (node.bounds, node.normals, *axis) = (Bounds::EMPTY, Bounds::EMPTY, Vec3A::ZERO);
            node.folded = false;
            let pack = &mut self.packs[node.link as usize];
            for ((lane, normal), &corners) in self.normals[run.clone()].iter_mut().enumerate().zip(&corners[run]) {
                let [a, b, c] = corners.map(&now);
                let own = around(corners);
                pack.set(lane, &own);
                *normal = (b - a).cross(c - a).normalize_or_zero();
                node.bounds = node.bounds.union(own);
                node.normals = Bounds { min: node.normals.min.min(*normal), max: node.normals.max.max(*normal) };
                *axis += *normal;
            }
            if self.quarantined[usize::from(node.part)] {
                (node.bounds, node.normals) = (Bounds::EMPTY, Bounds::EMPTY);
            }
        }
    }

    /// Gives leaves over which the faces around them fold back all normals, and with them what they are part of.
    fn find_folds(&mut self) {
        let Self { topology, nodes, normals, axes, quarantined, .. } = self;
        let TreeTopology { leaves, rings, .. } = &**topology;
        let mut any = false;
        for (Leaf { node, cover, ring }, axis) in leaves.iter().zip(axes) {
            // Boxes take in more than the normals, and are quicker.
            let leaf = &nodes[*node as usize];
            if nodes[*cover as usize].normals.lies_before(*axis) || quarantined[usize::from(leaf.part)] {
                continue;
            }
            let around = || rings[ring.start as usize..ring.end as usize].iter().map(|&i| normals[i as usize]);
            if !Bounds::around(around()).lies_before(*axis) && around().any(|n| n.dot(*axis) <= 0.0) {
                let node = &mut nodes[*node as usize];
                (node.folded, node.normals) = (true, Bounds::ALL_NORMALS);
                any = true;
            }
        }
        for i in (0..nodes.len()).rev().filter(|_| any) {
            if nodes[i].right & IS_LEAF == 0 {
                nodes[i].normals = nodes[i + 1].normals.union(nodes[nodes[i].right as usize].normals);
            }
        }
    }
}
