//! A hierarchy of boxes over the faces of a [`Surface`](super::Surface) (Mezger 2003).
//!
//! The topology of the tree is built once over each rest shape, where neighbours stay neighbours however the cloth folds.
//! Islands join those of their cloths (`tree/join.rs`). The boxes are refitted bottom-up every time. The box of an inner node
//! is `box = box(left) ∪ box(right)`, that of a leaf the union of its faces' boxes. The nodes stand in depth-first order, so
//! the left child is the next node and one backward sweep refits the tree. Boxes of faces are tested a leaf at a time
//! (`tree/pack.rs`).
//!
//! ```text
//! node i ──► left  = i + 1
//!        └─► right = nodes[i].right          leaf: faces[first .. first + count]
//! ```
//!
//! A piece of cloth that hardly bends does not cross itself (Volino and Magnenat-Thalmann 1994; Provot 1997). So a node is not
//! tested against itself while all normals below lie within 60° of one direction. Inside, 90° would do. Around a point of its
//! border, cloth without strain closes to a cone at 60°. Triangles at its tip are steeper
//! **`[measured: none of 17,500 crossings of squeezed sheets missed]`**. The test needs a piece without slits, holes and seams.
//! So it is made only for nodes whose faces form a disc. Borders of the mesh in it, if any, run along the sides of its box at
//! rest. Nor may faces around a leaf fold back over it. Cloth that is squeezed within its plane slides over itself across them
//! **`[measured: up to a fifth of the crossings missed]`**.
//!
//! Two nodes that share particles always meet, and are most of all pairs that do. They are known from the start and are one
//! piece of cloth. The same test on the normals of both dismisses them, where borders run along the sides of the box of the
//! whole cloth only.
//!
//! A cloth with a particle that is not finite or absurdly far is *quarantined*: its leaves get the empty box, which meets
//! nothing. So it contributes no pair and changes no box that another cloth's pairs depend on.

mod bounds;
mod build;
mod discs;
mod join;
mod joints;
mod levels;
mod pack;
mod refit;
mod rings;
mod segment;
mod shared;
#[cfg(test)]
mod tests;
mod traverse;

use core::ops::Range;
use std::sync::Arc;

use glam::Vec3A;

pub(crate) use bounds::Bounds;
pub(crate) use traverse::Meeting;

use crate::solver::buffer::Buffer;
use pack::Pack;
pub(crate) use pack::lanes;

/// Faces per leaf at most: as many as a node has bits to mark them.
pub(crate) const LEAF: usize = u8::BITS as usize;
/// Set in [`Node::right`] of a leaf.
const IS_LEAF: u32 = 1 << 31;
/// Most edges at a particle that joins nodes.
const HUB: usize = 64;
/// [`Node::part`] of a node that holds more than one cloth.
const MIXED: u16 = u16::MAX;

/// A node of the topology.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
struct Branch {
    /// Right child, or `IS_LEAF | first` of a leaf.
    right: u32,
    /// Faces of a leaf.
    count: u16,
    part: u16,
    /// [`Joint`] of the two children, `NONE` of two that share nothing; of a leaf its number.
    link: u32,
    /// Whether the faces below form a disc without slits.
    disc: bool,
    /// Whether they form a disc, cut or not, without particles at a seam. Borders at its particles run along sides of the whole
    /// cloth only.
    smooth: bool,
}

/// A [`Branch`] with the boxes of where its faces are; flat, since boxes align what holds them to 16 bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
struct Node {
    bounds: Bounds,
    /// Box of the unit normals below; of all there are, where a leaf is folded.
    normals: Bounds,
    right: u32,
    count: u16,
    part: u16,
    link: u32,
    disc: bool,
    smooth: bool,
    /// Which faces of a leaf are marked, one bit each; whether any is below another node.
    marked: u8,
    /// Whether the faces around a leaf fold back over it.
    folded: bool,
}

/// A leaf and the ring of faces around it.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
struct Leaf {
    node: u32,
    /// The smallest node that holds the leaf and all of its ring.
    cover: u32,
    /// The entries of [`TreeTopology::faces`] that share a particle with the leaf and are in other leaves: a run of
    /// [`TreeTopology::rings`].
    ring: Range<u32>,
}

/// Two nodes, none above the other, that share particles.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
struct Joint {
    nodes: [u32; 2],
    /// Joints of their children: `first .. first + count`.
    first: u32,
    count: u32,
}

/// The faces of a leaf, one in each lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LeafRef<'a> {
    /// Their numbers.
    pub faces: &'a [u32],
    /// Their corners.
    pub corners: &'a [[u32; 3]],
    pack: &'a Pack,
}

impl LeafRef<'_> {
    /// Which faces come within `margin` `[m]` of a box along every axis, a bit for each lane.
    #[inline]
    pub(crate) fn within(&self, bounds: &Bounds, margin: Vec3A) -> u32 {
        self.pack.meets(bounds, margin)
    }
}

/// What of a tree stays wherever its faces are. See the module.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct TreeTopology {
    branches: Vec<Branch>,
    /// Faces in the order of the leaves.
    faces: Vec<u32>,
    /// Corners of each entry of `faces`.
    corners: Vec<[u32; 3]>,
    leaves: Vec<Leaf>,
    /// Rings of all leaves, one after the other.
    rings: Vec<u32>,
    joints: Vec<Joint>,
    /// Whether nodes may share particles without a [`Joint`]: hubs of large fans, and edges of more than two faces.
    unjoined: bool,
}

impl TreeTopology {
    /// Memory held by it `[B]`.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.branches[..])
            + size_of_val(&self.faces[..])
            + size_of_val(&self.corners[..])
            + size_of_val(&self.leaves[..])
            + size_of_val(&self.rings[..])
            + size_of_val(&self.joints[..])
    }
}

/// The boxes of where faces are. See the module.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Tree {
    /// Shared with the rest shape where there is one cloth.
    topology: Arc<TreeTopology>,
    nodes: Vec<Node>,
    /// Boxes of the faces of each leaf.
    packs: Vec<Pack>,
    /// Unit normal of each entry of [`TreeTopology::faces`].
    normals: Vec<Vec3A>,
    /// Sum of the unit normals of each leaf.
    axes: Vec<Vec3A>,
    quarantined: Vec<bool>,
    stack: Buffer<Vec<(u32, u32)>>,
    /// Where the last [`Self::go_on`] stopped; empty where it came to its end.
    left: Vec<(u32, u32)>,
}

impl Tree {
    /// Its boxes are empty until they are [fitted](Self::refit).
    #[must_use]
    pub fn new(topology: Arc<TreeTopology>) -> Self {
        // The last one is a leaf of the last cloth.
        let cloths = topology.branches.last().map_or(0, |last| usize::from(last.part) + 1);
        Self {
            nodes: topology.branches.iter().map(|branch| branch.node()).collect(),
            packs: vec![Pack::EMPTY; topology.leaves.len()],
            normals: vec![Vec3A::ZERO; topology.faces.len()],
            axes: vec![Vec3A::ZERO; topology.leaves.len()],
            quarantined: vec![false; cloths],
            // Depth of the pair stack is bounded by a small multiple of the depth of the tree.
            stack: Buffer(Vec::with_capacity(256)),
            left: Vec::new(),
            topology,
        }
    }

    /// Whether a cloth was left out at the last [`Self::refit`].
    #[must_use]
    pub fn is_quarantined(&self, part: u16) -> bool {
        self.quarantined[usize::from(part)]
    }

    /// Number of faces.
    pub fn len(&self) -> usize {
        self.topology.faces.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.topology.faces.is_empty()
    }

    /// Number of cloths.
    pub(crate) fn cloths(&self) -> usize {
        self.quarantined.len()
    }

    /// Number of leaves.
    pub fn leaves(&self) -> u32 {
        self.topology.leaves.len() as u32
    }

    /// A leaf.
    #[inline]
    pub(crate) fn leaf(&self, leaf: u32) -> LeafRef<'_> {
        let TreeTopology { faces, corners, leaves, .. } = &*self.topology;
        let run = self.nodes[leaves[leaf as usize].node as usize].run();
        LeafRef { faces: &faces[run.clone()], corners: &corners[run], pack: &self.packs[leaf as usize] }
    }
}

const _: () = assert!(size_of::<Node>() == 80 && size_of::<Branch>() == 16);

impl Branch {
    /// A node with empty boxes.
    fn node(self) -> Node {
        let Self { right, count, part, link, disc, smooth } = self;
        let (bounds, normals) = (Bounds::EMPTY, Bounds::EMPTY);
        Node { bounds, normals, right, count, part, link, disc, smooth, marked: 0, folded: false }
    }

    fn run(&self) -> Range<usize> {
        run(self.right, self.count)
    }
}

impl Node {
    #[inline]
    fn run(&self) -> Range<usize> {
        run(self.right, self.count)
    }
}

/// Where the faces of a leaf stand in [`TreeTopology::faces`].
#[inline]
fn run(right: u32, count: u16) -> Range<usize> {
    let first = (right & !IS_LEAF) as usize;
    first..first + usize::from(count)
}
