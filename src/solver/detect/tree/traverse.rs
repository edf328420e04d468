//! Walks the tree against itself: every pair of leaves, and in them of faces, whose boxes meet.

use glam::Vec3A;

use super::joints::below;
use super::pack::lanes;
use super::{Bounds, IS_LEAF, Joint, LEAF, MIXED, Node, Tree};
use crate::solver::detect::Surface;
use crate::solver::effort::{Effort, Meter};
use crate::solver::scales::ALIGNED;
use crate::solver::topology::NONE;

/// First of a pair on the stack whose second is a [`Joint`].
const JOINT: u32 = NONE;

/// Two leaves with faces whose boxes come close, or a leaf and itself.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Meeting {
    /// The leaves.
    pub leaves: [u32; 2],
    /// Bit `k` of entry `i`: face `i` of the first leaf comes close to face `k` of the second. Each pair of a leaf with itself
    /// is listed once.
    pub hits: [u8; LEAF],
    /// Whether some of their faces may share a particle.
    pub joined: bool,
}

impl Meeting {
    /// How many pairs of faces come close.
    #[must_use]
    pub(crate) fn count(&self) -> usize {
        u64::from_le_bytes(self.hits).count_ones() as usize
    }
}

impl Tree {
    /// Calls `found` once with every pair of different faces whose boxes come within `margin` `[m]`. Faces of a cloth that does
    /// not collide with itself are paired only with those of other cloths.
    pub fn pairs(&mut self, surface: &Surface, margin: f32, mut found: impl FnMut(u32, u32)) {
        self.meetings(surface, margin, &Effort::UNBOUNDED.meter(), |tree, met| tree.pairs_of(met, &mut found));
    }

    /// As [`Self::pairs`], two leaves at a time. Those that come last are left out where there is too much work.
    pub(crate) fn meetings(&mut self, surface: &Surface, margin: f32, meter: &Meter, found: impl FnMut(&Self, &Meeting)) {
        self.traverse::<false>(surface, margin, &[(0, 0)], meter, found);
    }

    /// As [`Self::meetings`], in parts where there is too much work: each goes on where the one before stopped. Pairs of nodes
    /// that are left do not depend on where particles are. Says whether it began with the first part, and whether this was the
    /// last.
    pub(crate) fn go_on(
        &mut self,
        surface: &Surface,
        margin: f32,
        meter: &Meter,
        found: impl FnMut(&Self, &Meeting),
    ) -> [bool; 2] {
        let left = core::mem::take(&mut self.left);
        let is_first = left.is_empty();
        self.traverse::<false>(surface, margin, if is_first { &[(0, 0)] } else { left.as_slice() }, meter, found);
        self.left = left;
        self.left.clear();
        self.left.extend_from_slice(&self.stack);
        [is_first, self.left.is_empty()]
    }

    /// As [`Self::meetings`], only for pairs with a face that is [marked](Self::mark).
    pub(crate) fn meetings_with(&mut self, surface: &Surface, margin: f32, meter: &Meter, found: impl FnMut(&Self, &Meeting)) {
        self.traverse::<true>(surface, margin, &[(0, 0)], meter, found);
    }

    /// Marks faces, and the nodes above them.
    pub(crate) fn mark(&mut self, marked: &[bool]) {
        for i in (0..self.nodes.len()).rev() {
            let node = self.nodes[i];
            self.nodes[i].marked = if node.right & IS_LEAF == 0 {
                u8::from((self.nodes[i + 1].marked | self.nodes[node.right as usize].marked) != 0)
            } else {
                let bit = |(lane, &f): (usize, &u32)| u8::from(marked[f as usize]) << lane;
                self.topology.faces[node.run()].iter().enumerate().map(bit).sum()
            };
        }
    }

    /// Calls `found` with each pair of faces of a meeting, in order.
    #[inline]
    pub(crate) fn pairs_of(&self, met: &Meeting, mut found: impl FnMut(u32, u32)) {
        let [faces, others] = met.leaves.map(|leaf| self.leaf(leaf).faces);
        for (&face, &hits) in faces.iter().zip(&met.hits) {
            lanes(u32::from(hits)).for_each(|k| found(face, others[k]));
        }
    }

    /// Takes the pairs of nodes that are `left` apart, and leaves in the stack those that it did not come to.
    fn traverse<const MARKED: bool>(
        &mut self,
        surface: &Surface,
        margin: f32,
        left: &[(u32, u32)],
        meter: &Meter,
        found: impl FnMut(&Self, &Meeting),
    ) {
        let mut stack = core::mem::take(&mut *self.stack);
        stack.clear();
        stack.extend_from_slice(left);
        self.walk::<MARKED>(surface, margin, &mut stack, meter, found);
        *self.stack = stack;
    }

    /// Whether the next [`Self::go_on`] goes on with what the last one left.
    pub(crate) fn has_left(&self) -> bool {
        !self.left.is_empty()
    }

    /// Takes `pairs` of nodes apart until there are `count`, or leaves only. Walked from the last to the first, they find what
    /// the pairs before found, in the same order. `next` is a buffer.
    #[expect(clippy::too_many_arguments, reason = "buffers of who asks, which are borrowed apart")]
    pub(crate) fn split(
        &self,
        surface: &Surface,
        margin: f32,
        marked: bool,
        count: usize,
        pairs: &mut Vec<(u32, u32)>,
        next: &mut Vec<(u32, u32)>,
        meter: &Meter,
    ) {
        let (margin, nothing) = (Vec3A::splat(margin), &mut |_: &Self, _: &Meeting| {});
        let mut goes_on = !self.nodes.is_empty();
        while goes_on && pairs.len() < count {
            goes_on = false;
            next.clear();
            for &pair in pairs.iter() {
                if self.is_of_leaves(pair) {
                    next.push(pair);
                } else {
                    goes_on = true;
                    meter.spend(1);
                    if marked {
                        self.take_apart::<true>(pair, surface, margin, next, nothing);
                    } else {
                        self.take_apart::<false>(pair, surface, margin, next, nothing);
                    }
                }
            }
            core::mem::swap(pairs, next);
        }
    }

    /// As [`Self::meetings`] or, for `marked` faces, [`Self::meetings_with`], of pairs of nodes in a `stack`, from the last to
    /// the first.
    pub(crate) fn meetings_of(
        &self,
        surface: &Surface,
        margin: f32,
        marked: bool,
        stack: &mut Vec<(u32, u32)>,
        meter: &Meter,
        found: impl FnMut(&Self, &Meeting),
    ) {
        if marked {
            self.walk::<true>(surface, margin, stack, meter, found);
        } else {
            self.walk::<false>(surface, margin, stack, meter, found);
        }
    }

    /// Whether no pair of nodes comes of a pair, as both are leaves.
    fn is_of_leaves(&self, (a, b): (u32, u32)) -> bool {
        let [a, b] = if a == JOINT { self.topology.joints[b as usize].nodes } else { [a, b] };
        self.nodes[a as usize].right & self.nodes[b as usize].right & IS_LEAF != 0
    }

    fn walk<const MARKED: bool>(
        &self,
        surface: &Surface,
        margin: f32,
        stack: &mut Vec<(u32, u32)>,
        meter: &Meter,
        mut found: impl FnMut(&Self, &Meeting),
    ) {
        if self.nodes.is_empty() {
            stack.clear();
            return;
        }
        let margin = Vec3A::splat(margin);
        while !meter.is_spent()
            && let Some(pair) = stack.pop()
        {
            meter.spend(1);
            self.take_apart::<MARKED>(pair, surface, margin, stack, &mut found);
        }
    }

    /// Takes a pair of nodes apart into pairs of their children, or asks their faces.
    #[inline(always)]
    fn take_apart<const MARKED: bool>(
        &self,
        (a, b): (u32, u32),
        surface: &Surface,
        margin: Vec3A,
        stack: &mut Vec<(u32, u32)>,
        found: &mut impl FnMut(&Self, &Meeting),
    ) {
        if a == JOINT {
            if !MARKED || self.topology.joints[b as usize].nodes.iter().any(|&i| self.nodes[i as usize].marked != 0) {
                self.descend::<MARKED>(b, margin, stack, found);
            }
            return;
        }
        let (left, right) = (&self.nodes[a as usize], &self.nodes[b as usize]);
        if MARKED && left.marked | right.marked == 0 {
            return;
        }
        let (leaf_a, leaf_b) = (left.right & IS_LEAF != 0, right.right & IS_LEAF != 0);
        if a == b {
            if left.part != MIXED && !surface.parts[usize::from(left.part)].self_collision {
                return;
            }
            if left.disc && left.normals.are_flat() {
                return;
            }
            if leaf_a {
                if !(left.disc && self.hardly_bend([left])) {
                    self.within::<MARKED>(left, margin, found);
                }
            } else {
                stack.push((left.right, left.right));
                stack.push((a + 1, a + 1));
                if left.link != NONE {
                    stack.push((JOINT, left.link));
                } else if self.meet(a + 1, left.right, margin) {
                    stack.push((a + 1, left.right));
                }
            }
        } else if leaf_a && leaf_b {
            self.between::<MARKED>([left, right], self.topology.unjoined, margin, found);
        } else if leaf_b || (!leaf_a && extent(&left.bounds) >= extent(&right.bounds)) {
            for child in [left.right, a + 1] {
                if self.meet(child, b, margin) {
                    stack.push((child, b));
                }
            }
        } else {
            for child in [right.right, b + 1] {
                if self.meet(a, child, margin) {
                    stack.push((a, child));
                }
            }
        }
    }

    /// Takes two nodes that share particles apart, unless they are one piece that hardly bends.
    #[inline]
    fn descend<const MARKED: bool>(
        &self,
        joint: u32,
        margin: Vec3A,
        stack: &mut Vec<(u32, u32)>,
        found: &mut impl FnMut(&Self, &Meeting),
    ) {
        let joints = &self.topology.joints;
        let Joint { nodes: [a, b], first, count } = joints[joint as usize];
        let (left, right) = (&self.nodes[a as usize], &self.nodes[b as usize]);
        if left.smooth && right.smooth && left.normals.union(right.normals).are_flat() {
            return;
        }
        if left.right & right.right & IS_LEAF != 0 {
            if !(left.smooth && right.smooth && self.hardly_bend([left, right])) {
                self.between::<MARKED>([left, right], true, margin, found);
            }
            return;
        }
        // The joints stand in the order of the pairs.
        let mut joint = first;
        for pair in below(|i| self.nodes[i as usize].right, [a, b]) {
            if joint < first + count && joints[joint as usize].nodes == pair {
                stack.push((JOINT, joint));
                joint += 1;
            } else if self.meet(pair[0], pair[1], margin) {
                stack.push((pair[0], pair[1]));
            }
        }
    }

    /// Whether all normals of some leaves lie within 60° of their sum. Their box, which is tested first, takes in more than the
    /// normals.
    #[inline]
    fn hardly_bend<const N: usize>(&self, leaves: [&Node; N]) -> bool {
        let normals = || leaves.into_iter().flat_map(|leaf| &self.normals[leaf.run()]);
        let axis: Vec3A = normals().sum();
        let limit = ALIGNED * axis.length();
        limit > 0.0 && !leaves.iter().any(|leaf| leaf.folded) && normals().all(|n| n.dot(axis) >= limit)
    }

    #[inline]
    fn meet(&self, a: u32, b: u32, margin: Vec3A) -> bool {
        self.nodes[a as usize].bounds.meets(&self.nodes[b as usize].bounds, margin)
    }

    fn within<const MARKED: bool>(&self, leaf: &Node, margin: Vec3A, found: &mut impl FnMut(&Self, &Meeting)) {
        if self.quarantined[usize::from(leaf.part)] {
            return;
        }
        let (pack, marked) = (&self.packs[leaf.link as usize], u32::from(leaf.marked));
        let mut met = Meeting { leaves: [leaf.link; 2], hits: [0; LEAF], joined: true };
        for (i, hits) in met.hits[..usize::from(leaf.count)].iter_mut().enumerate() {
            let others = (!1 << i) & if !MARKED || marked & (1 << i) != 0 { u32::MAX } else { marked };
            *hits = (others & pack.meets(&pack.get(i), margin)) as u8;
        }
        if met.hits != [0; LEAF] {
            found(self, &met);
        }
    }

    fn between<const MARKED: bool>(
        &self,
        [a, b]: [&Node; 2],
        joined: bool,
        margin: Vec3A,
        found: &mut impl FnMut(&Self, &Meeting),
    ) {
        if self.quarantined[usize::from(a.part)] || self.quarantined[usize::from(b.part)] {
            return;
        }
        let (left, right) = (&self.packs[a.link as usize], &self.packs[b.link as usize]);
        let (mine, theirs) = (u32::from(a.marked), u32::from(b.marked));
        let mut met = Meeting { leaves: [a.link, b.link], hits: [0; LEAF], joined };
        for i in lanes(left.meets(&b.bounds, margin)) {
            let asked = if !MARKED || mine & (1 << i) != 0 { u32::MAX } else { theirs };
            if asked != 0 {
                met.hits[i] = (asked & right.meets(&left.get(i), margin)) as u8;
            }
        }
        if met.hits != [0; LEAF] {
            found(self, &met);
        }
    }
}

#[inline]
fn extent(b: &Bounds) -> f32 {
    (b.max - b.min).element_sum()
}
