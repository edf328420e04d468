//! A hierarchy of boxes over the faces of a [`Surface`] (Mezger 2003).
//!
//! Built once over the rest shape, where neighbours stay neighbours however the cloth folds, and refitted bottom-up every time:
//! for an inner node `box = box(left) ∪ box(right)`, for a leaf the union of its faces' boxes. The nodes stand in depth-first order,
//! so the left child is the next node and one backward sweep refits the tree. Boxes of faces are tested a leaf at a time (`tree/pack.rs`).
//!
//! ```text
//! node i ──► left  = i + 1
//!        └─► right = nodes[i].right          leaf: faces[first .. first + count]
//! ```
//!
//! A piece of cloth that hardly bends does not cross itself (Volino and Magnenat-Thalmann 1994; Provot 1997): a node is not tested against
//! itself while all normals below lie within 60° of one direction: inside, 90° would do; around a point of its border cloth without strain closes to
//! a cone at 60°, and triangles at its tip are steeper **`[measured: none of 17,500 crossings of squeezed sheets missed]`**. It needs a piece
//! without slits, holes and seams, so it is drawn only for nodes whose faces form a disc in which borders of the mesh, if any, run along the
//! sides of its box at rest. Nor may faces around a leaf fold back over it: cloth that is squeezed within its plane slides over itself across
//! them **`[measured: up to a fifth of the crossings missed]`**.
//!
//! Two nodes that share particles always meet, and are most of all that does. They are known from the start and are one piece
//! of cloth: the same test on the normals of both dismisses them, where borders run along the sides of the box of the whole cloth only.
//!
//! A cloth with a particle that is not finite or absurdly far is *quarantined*: its leaves get the empty box, which meets nothing,
//! so it contributes no pair and changes no box that another cloth's pairs depend on.

mod levels;
mod pack;

use core::ops::Range;

use glam::{Vec3, Vec3A, Vec4};

use self::pack::{Pack, lanes};
use super::seams::{loose, rest_box, runs_along_a_side, seams};
use super::surface::{Surface, is_sane};
use crate::solver::rest::NONE;

/// Faces per leaf at most: as many as there are bits in [`Node::marked`].
const LEAF: usize = u8::BITS as usize;
/// Set in [`Node::right`] of a leaf.
const IS_LEAF: u32 = 1 << 31;
/// Cosine of how far normals may lie from one direction for what they belong to to be flat: 60°. See the module.
pub const FLAT: f32 = 0.5;
/// Most edges at a particle that joins nodes.
const HUB: usize = 64;
/// First of a pair on the stack whose second is a [`Joint`].
const JOINT: u32 = NONE;
/// [`Node::part`] of a node that holds more than one cloth.
const MIXED: u16 = u16::MAX;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// Smallest corner `[m]`.
    pub min: Vec3A,
    /// Largest corner `[m]`.
    pub max: Vec3A,
}

impl Bounds {
    /// The box that meets nothing, not even itself.
    pub const EMPTY: Self = Self { min: Vec3A::INFINITY, max: Vec3A::NEG_INFINITY };

    /// The box of all unit normals.
    const ALL_NORMALS: Self = Self { min: Vec3A::NEG_ONE, max: Vec3A::ONE };

    /// The smallest box around both.
    #[inline]
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// For a box of unit normals: whether all lie within 60° of the direction of its centre.
    #[inline]
    fn are_flat(&self) -> bool {
        let axis = self.min + self.max;
        let least = (axis * self.min).min(axis * self.max).element_sum();
        least > 0.0 && least * least > FLAT * FLAT * axis.length_squared()
    }

    /// The smallest box around points.
    #[inline]
    fn around(points: impl Iterator<Item = Vec3A>) -> Self {
        points.fold(Self::EMPTY, |sum, x| Self { min: sum.min.min(x), max: sum.max.max(x) })
    }

    /// Whether all of it lies before the plane through the origin across `axis`.
    #[inline]
    fn lies_before(&self, axis: Vec3A) -> bool {
        (axis * self.min).min(axis * self.max).element_sum() > 0.0
    }

    /// Whether two boxes come within `margin` `[m]` along every axis; touching counts.
    #[inline]
    #[must_use]
    pub fn meets(&self, other: &Self, margin: Vec3A) -> bool {
        (self.min - margin).cmple(other.max).all() && (other.min - margin).cmple(self.max).all()
    }
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Bounds,
    /// Right child, or `IS_LEAF | first` of a leaf.
    right: u32,
    /// Faces of a leaf.
    count: u16,
    part: u16,
    /// Whether the faces below form a disc without slits.
    disc: bool,
    /// Whether they form a disc, cut or not, in which no particle lies at a seam, or at a border that does not run along a side of the whole cloth.
    smooth: bool,
    /// Which faces of a leaf are marked, one bit each; whether any is below another node.
    marked: u8,
    /// Whether the faces around a leaf fold back over it.
    folded: bool,
    /// [`Joint`] of the two children, `NONE` of two that share nothing; of a leaf its number.
    link: u32,
    /// Box of the unit normals below; of all there are, where a leaf is folded.
    normals: Bounds,
}

/// A leaf and the ring of faces around it.
#[derive(Clone, Debug)]
struct Leaf {
    node: u32,
    /// The smallest node that holds the leaf and all of its ring.
    cover: u32,
    /// The entries of [`Tree::faces`] that share a particle with the leaf and are in other leaves: a run of [`Tree::rings`].
    ring: Range<u32>,
    /// Sum of the unit normals.
    axis: Vec3A,
}

/// Two nodes, none above the other, that share particles.
#[derive(Clone, Copy, Debug)]
struct Joint {
    nodes: [u32; 2],
    /// Joints of their children: `first .. first + count`.
    first: u32,
    count: u32,
}

/// The hierarchy. See the module.
#[derive(Clone, Debug, Default)]
pub struct Tree {
    nodes: Vec<Node>,
    /// Faces in the order of the leaves.
    faces: Vec<u32>,
    /// Boxes of the faces of each leaf.
    packs: Vec<Pack>,
    /// Unit normal of each entry of `faces`.
    normals: Vec<Vec3A>,
    /// Corners of each entry of `faces`.
    corners: Vec<[u32; 3]>,
    leaves: Vec<Leaf>,
    /// Rings of all leaves, one after the other.
    rings: Vec<u32>,
    quarantined: Vec<bool>,
    joints: Vec<Joint>,
    stack: Vec<(u32, u32)>,
}

impl Tree {
    /// Builds the hierarchy over the rest shape.
    #[must_use]
    pub fn new(surface: &Surface) -> Self {
        let mut tree = Self {
            faces: (0..surface.topology.faces.len() as u32).collect(),
            normals: vec![Vec3A::ZERO; surface.topology.faces.len()],
            quarantined: vec![false; surface.parts.len()],
            ..Self::default()
        };
        let centre: Vec<Vec3> =
            surface.topology.faces.iter().map(|t| t.iter().map(|&v| surface.rest[v as usize]).sum::<Vec3>() / 3.0).collect();
        if !surface.parts.is_empty() {
            tree.split_parts(surface, &centre, 0, surface.parts.len());
        }
        tree.find_discs(surface);
        tree.find_joints(surface);
        tree.find_rings(surface);
        tree.corners = tree.faces.iter().map(|&f| surface.topology.faces[f as usize]).collect();
        // Depth of the pair stack is bounded by a small multiple of the depth of the tree.
        tree.stack.reserve(256);
        tree
    }

    /// Marks the nodes whose faces form a disc (connected, `V - E + F = 1`) without seams and with borders of the mesh at the sides of its box only.
    fn find_discs(&mut self, surface: &Surface) {
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

    /// Finds the pairs of nodes that share particles, from the children of each node downwards.
    fn find_joints(&mut self, surface: &Surface) {
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
            let mut shared: Vec<u32> = below.filter(|&v| belongs(v, node.right)).collect();
            shared.sort_unstable();
            shared.dedup();
            // Through the hub of a fan of thousands every node would be joined to every other; boxes do for it.
            shared.retain(|&v| topology.around(v).len() <= HUB);
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

    /// Where each face stands in `faces`.
    fn places(&self) -> Vec<u32> {
        let mut place = vec![0; self.faces.len()];
        for (i, &f) in self.faces.iter().enumerate() {
            place[f as usize] = i as u32;
        }
        place
    }

    /// Finds the faces around each leaf; at the hub of a fan only those beside it.
    fn find_rings(&mut self, surface: &Surface) {
        let topology = &surface.topology;
        let place = self.places();
        for (i, node) in (0..).zip(&self.nodes).filter(|(_, node)| node.right & IS_LEAF != 0) {
            let (run, first) = (node.run(), self.rings.len());
            for &f in &self.faces[run.clone()] {
                let corners =
                    topology.faces[f as usize].into_iter().map(|v| topology.around(v)).filter(|edges| edges.len() <= HUB);
                let around = corners.flatten().map(|&(_, e)| e);
                for e in topology.face_edges[f as usize].into_iter().chain(around) {
                    for &f in topology.edge_faces[e as usize].iter().filter(|&&f| f != NONE) {
                        let f = place[f as usize];
                        if !run.contains(&(f as usize)) && !self.rings[first..].contains(&f) {
                            self.rings.push(f);
                        }
                    }
                }
            }
            let cover = self.cover(run, &self.rings[first..]);
            self.leaves.push(Leaf { node: i, cover, ring: first as u32..self.rings.len() as u32, axis: Vec3A::ZERO });
        }
    }

    /// The smallest node that holds a run of `faces` and some others.
    fn cover(&self, run: Range<usize>, others: &[u32]) -> u32 {
        let first = others.iter().map(|&i| i as usize).fold(run.start, usize::min);
        let last = others.iter().map(|&i| i as usize).fold(run.end - 1, usize::max);
        let mut node = 0;
        while self.nodes[node].right & IS_LEAF == 0 {
            let right = self.nodes[node].right as usize;
            let border = self.faces_below(right).start;
            node = if last < border {
                node + 1
            } else if first >= border {
                right
            } else {
                break;
            };
        }
        node as u32
    }

    /// The pairs that two different nodes fall into; none of two leaves.
    fn below(&self, [a, b]: [u32; 2]) -> impl Iterator<Item = [u32; 2]> + use<> {
        let halves = |i: u32| {
            let right = self.nodes[i as usize].right;
            if right & IS_LEAF == 0 { [i + 1, right] } else { [i, NONE] }
        };
        let (left, right) = (halves(a), halves(b));
        let pairs = [[left[0], right[0]], [left[0], right[1]], [left[1], right[0]], [left[1], right[1]]];
        let leaves = left[1] == NONE && right[1] == NONE;
        pairs.into_iter().filter(move |pair| !leaves && !pair.contains(&NONE))
    }

    fn faces_below(&self, node: usize) -> Range<usize> {
        let (mut first, mut last) = (node, node);
        while self.nodes[first].right & IS_LEAF == 0 {
            first += 1;
        }
        while self.nodes[last].right & IS_LEAF == 0 {
            last = self.nodes[last].right as usize;
        }
        self.nodes[first].run().start..self.nodes[last].run().end
    }

    fn split_parts(&mut self, surface: &Surface, centre: &[Vec3], first: usize, last: usize) {
        if last - first == 1 {
            let faces = &surface.parts[first].faces;
            self.split_faces(first as u16, centre, faces.start as usize, faces.end as usize);
            return;
        }
        let node = self.push(0, 0, MIXED);
        let middle = usize::midpoint(first, last);
        self.split_parts(surface, centre, first, middle);
        self.nodes[node].right = self.nodes.len() as u32;
        self.split_parts(surface, centre, middle, last);
    }

    fn split_faces(&mut self, part: u16, centre: &[Vec3], first: usize, last: usize) {
        if last - first <= LEAF {
            let node = self.push(IS_LEAF | first as u32, (last - first) as u16, part);
            self.nodes[node].link = self.packs.len() as u32;
            self.packs.push(Pack::EMPTY);
            return;
        }
        let node = self.push(0, 0, part);
        let run = &mut self.faces[first..last];
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for &f in run.iter() {
            low = low.min(centre[f as usize]);
            high = high.max(centre[f as usize]);
        }
        let size = high - low;
        let axis = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        // A multiple of the leaf size, so that leaves are full.
        let middle = ((last - first).div_ceil(2 * LEAF) * LEAF).min(last - first - 1);
        run.select_nth_unstable_by(middle, |&a, &b| {
            centre[a as usize][axis].total_cmp(&centre[b as usize][axis]).then(a.cmp(&b))
        });
        self.split_faces(part, centre, first, first + middle);
        self.nodes[node].right = self.nodes.len() as u32;
        self.split_faces(part, centre, first + middle, last);
    }

    fn push(&mut self, right: u32, count: u16, part: u16) -> usize {
        self.nodes.push(Node {
            bounds: Bounds::EMPTY,
            right,
            count,
            part,
            disc: false,
            smooth: false,
            marked: 0,
            folded: false,
            link: NONE,
            normals: Bounds::EMPTY,
        });
        self.nodes.len() - 1
    }

    /// Fits the boxes to the positions `[m]` and finds the cloths to leave out.
    ///
    /// With `ahead` `[m]`, one per particle, boxes also hold where particles will be; normals do not.
    pub fn refit(&mut self, surface: &Surface, positions: &[Vec4], ahead: Option<&[Vec3A]>) {
        for (part, out) in surface.parts.iter().zip(&mut self.quarantined) {
            let range = part.particles.start as usize..part.particles.end as usize;
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
    }

    /// Fits the leaves and their faces to where particles are `now` `[m]`; `around` is the box of three of them.
    #[inline]
    fn fit_leaves(&mut self, now: impl Fn(u32) -> Vec3A, around: impl Fn([u32; 3]) -> Bounds) {
        for leaf in &mut self.leaves {
            let node = &mut self.nodes[leaf.node as usize];
            let run = node.run();
            (node.bounds, node.normals, leaf.axis) = (Bounds::EMPTY, Bounds::EMPTY, Vec3A::ZERO);
            node.folded = false;
            let pack = &mut self.packs[node.link as usize];
            for ((lane, normal), &corners) in self.normals[run.clone()].iter_mut().enumerate().zip(&self.corners[run]) {
                let [a, b, c] = corners.map(&now);
                let own = around(corners);
                pack.set(lane, &own);
                *normal = (b - a).cross(c - a).normalize_or_zero();
                node.bounds = node.bounds.union(own);
                node.normals = Bounds { min: node.normals.min.min(*normal), max: node.normals.max.max(*normal) };
                leaf.axis += *normal;
            }
            if self.quarantined[usize::from(node.part)] {
                (node.bounds, node.normals) = (Bounds::EMPTY, Bounds::EMPTY);
            }
        }
    }

    /// Gives leaves over which the faces around them fold back all normals, and with them what they are part of.
    fn find_folds(&mut self) {
        let Self { nodes, normals, leaves, rings, quarantined, .. } = self;
        let mut any = false;
        for Leaf { node, cover, ring, axis } in leaves.iter() {
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

    /// Whether a cloth was left out at the last [`Self::refit`].
    #[must_use]
    pub fn is_quarantined(&self, part: u16) -> bool {
        self.quarantined[usize::from(part)]
    }

    /// Calls `found` once with every pair of different faces whose boxes come within `margin` `[m]`; in a cloth that does not
    /// collide with itself, only with faces of other cloths.
    pub fn pairs(&mut self, surface: &Surface, margin: f32, found: impl FnMut(u32, u32)) {
        self.traverse::<false>(surface, margin, found);
    }

    /// As [`Self::pairs`], only for pairs with a face that is `marked` (by face).
    pub fn pairs_with(&mut self, surface: &Surface, margin: f32, marked: &[bool], found: impl FnMut(u32, u32)) {
        for i in (0..self.nodes.len()).rev() {
            let node = self.nodes[i];
            self.nodes[i].marked = if node.right & IS_LEAF == 0 {
                u8::from((self.nodes[i + 1].marked | self.nodes[node.right as usize].marked) != 0)
            } else {
                let bit = |(lane, &f): (usize, &u32)| u8::from(marked[f as usize]) << lane;
                self.faces[node.run()].iter().enumerate().map(bit).sum()
            };
        }
        self.traverse::<true>(surface, margin, found);
    }

    fn traverse<const MARKED: bool>(&mut self, surface: &Surface, margin: f32, mut found: impl FnMut(u32, u32)) {
        if self.nodes.is_empty() {
            return;
        }
        let margin = Vec3A::splat(margin);
        let mut stack = core::mem::take(&mut self.stack);
        stack.clear();
        stack.push((0, 0));
        while let Some((a, b)) = stack.pop() {
            if a == JOINT {
                if !MARKED || self.joints[b as usize].nodes.iter().any(|&i| self.nodes[i as usize].marked != 0) {
                    self.descend::<MARKED>(b, margin, &mut stack, &mut found);
                }
                continue;
            }
            let (left, right) = (&self.nodes[a as usize], &self.nodes[b as usize]);
            if MARKED && left.marked | right.marked == 0 {
                continue;
            }
            let (leaf_a, leaf_b) = (left.right & IS_LEAF != 0, right.right & IS_LEAF != 0);
            if a == b {
                if left.part != MIXED && !surface.parts[usize::from(left.part)].self_collision {
                    continue;
                }
                if left.disc && left.normals.are_flat() {
                    continue;
                }
                if leaf_a {
                    if !(left.disc && self.hardly_bend([left])) {
                        self.within::<MARKED>(left, margin, &mut found);
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
                self.between::<MARKED>(left, right, margin, &mut found);
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
        self.stack = stack;
    }

    /// Takes two nodes that share particles apart, unless they are one piece that hardly bends.
    #[inline]
    fn descend<const MARKED: bool>(
        &self,
        joint: u32,
        margin: Vec3A,
        stack: &mut Vec<(u32, u32)>,
        found: &mut impl FnMut(u32, u32),
    ) {
        let Joint { nodes: [a, b], first, count } = self.joints[joint as usize];
        let (left, right) = (&self.nodes[a as usize], &self.nodes[b as usize]);
        if left.smooth && right.smooth && left.normals.union(right.normals).are_flat() {
            return;
        }
        if left.right & right.right & IS_LEAF != 0 {
            if !(left.smooth && right.smooth && self.hardly_bend([left, right])) {
                self.between::<MARKED>(left, right, margin, found);
            }
            return;
        }
        // The joints stand in the order of the pairs.
        let mut joint = first;
        for pair in self.below([a, b]) {
            if joint < first + count && self.joints[joint as usize].nodes == pair {
                stack.push((JOINT, joint));
                joint += 1;
            } else if self.meet(pair[0], pair[1], margin) {
                stack.push((pair[0], pair[1]));
            }
        }
    }

    /// Whether all normals of some leaves lie within 60° of their sum. Their box, which is tested first, takes in more than the normals.
    #[inline]
    fn hardly_bend<const N: usize>(&self, leaves: [&Node; N]) -> bool {
        let normals = || leaves.into_iter().flat_map(|leaf| &self.normals[leaf.run()]);
        let axis: Vec3A = normals().sum();
        let limit = FLAT * axis.length();
        limit > 0.0 && !leaves.iter().any(|leaf| leaf.folded) && normals().all(|n| n.dot(axis) >= limit)
    }

    #[inline]
    fn meet(&self, a: u32, b: u32, margin: Vec3A) -> bool {
        self.nodes[a as usize].bounds.meets(&self.nodes[b as usize].bounds, margin)
    }

    fn within<const MARKED: bool>(&self, leaf: &Node, margin: Vec3A, found: &mut impl FnMut(u32, u32)) {
        if self.quarantined[usize::from(leaf.part)] {
            return;
        }
        let (pack, faces, marked) = (&self.packs[leaf.link as usize], &self.faces[leaf.run()], u32::from(leaf.marked));
        for (i, &face) in faces.iter().enumerate() {
            let others = (!1 << i) & if !MARKED || marked & (1 << i) != 0 { u32::MAX } else { marked };
            for j in lanes(others & pack.meets(&pack.get(i), margin)) {
                found(face, faces[j]);
            }
        }
    }

    fn between<const MARKED: bool>(&self, a: &Node, b: &Node, margin: Vec3A, found: &mut impl FnMut(u32, u32)) {
        if self.quarantined[usize::from(a.part)] || self.quarantined[usize::from(b.part)] {
            return;
        }
        let (left, right) = (&self.packs[a.link as usize], &self.packs[b.link as usize]);
        let (faces, others) = (&self.faces[a.run()], &self.faces[b.run()]);
        let (mine, theirs) = (u32::from(a.marked), u32::from(b.marked));
        for i in lanes(left.meets(&b.bounds, margin)) {
            let asked = if !MARKED || mine & (1 << i) != 0 { u32::MAX } else { theirs };
            if asked == 0 {
                continue;
            }
            for j in lanes(asked & right.meets(&left.get(i), margin)) {
                found(faces[i], others[j]);
            }
        }
    }

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
                for (lane, &face) in self.faces[node.run()].iter().enumerate() {
                    if hit(&self.packs[node.link as usize].get(lane)) {
                        found(face);
                    }
                }
            }
        }
        self.stack = stack;
    }
}

impl Node {
    #[inline]
    fn run(&self) -> Range<usize> {
        let first = (self.right & !IS_LEAF) as usize;
        first..first + usize::from(self.count)
    }
}

#[inline]
fn extent(b: &Bounds) -> f32 {
    (b.max - b.min).element_sum()
}
