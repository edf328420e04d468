//! Builds the topology: faces are split at the middle of the longest side of their box until they fit a leaf.

use std::sync::Arc;

use glam::Vec3;

use super::shared::Shared;
use super::{Branch, HUB, IS_LEAF, LEAF, Leaf, MIXED, Tree, TreeTopology};
use crate::solver::detect::Surface;
use crate::solver::topology::NONE;

impl Tree {
    /// Builds it over the rest shape of a surface. Its boxes are empty until they are [fitted](Self::refit).
    #[must_use]
    pub(crate) fn of_surface(surface: &Surface) -> Self {
        Self::new(Arc::new(TreeTopology::new(surface)))
    }
}

impl TreeTopology {
    /// Builds it over the rest shape.
    #[must_use]
    pub fn new(surface: &Surface) -> Self {
        let mut built = Self {
            faces: (0..surface.topology.faces.len() as u32).collect(),
            unjoined: has_unjoined(surface),
            ..Self::default()
        };
        let centre: Vec<Vec3> =
            surface.topology.faces.iter().map(|t| t.iter().map(|&v| surface.rest[v as usize]).sum::<Vec3>() / 3.0).collect();
        if !surface.parts.is_empty() {
            built.split_parts(0, surface.parts.len(), &mut |built, part| {
                let faces = &surface.parts[part].faces;
                built.split_faces(part as u16, &centre, faces.start as usize, faces.end as usize);
            });
        }
        let shared = Shared::new(&built, surface);
        built.find_discs(surface, &shared);
        built.find_joints(surface, &shared);
        built.find_rings(surface, &shared);
        built.branches.shrink_to_fit();
        built.leaves.shrink_to_fit();
        built.rings.shrink_to_fit();
        built.joints.shrink_to_fit();
        built.corners = built.faces.iter().map(|&f| surface.topology.faces[f as usize]).collect();
        built
    }

    /// Halves a range of cloths until `plant` puts the nodes of each of them behind what is there.
    pub(super) fn split_parts(&mut self, first: usize, last: usize, plant: &mut impl FnMut(&mut Self, usize)) {
        if last - first == 1 {
            plant(self, first);
            return;
        }
        let node = self.push(0, 0, MIXED);
        let middle = usize::midpoint(first, last);
        self.split_parts(first, middle, plant);
        self.branches[node].right = self.branches.len() as u32;
        self.split_parts(middle, last, plant);
    }

    fn split_faces(&mut self, part: u16, centre: &[Vec3], first: usize, last: usize) {
        if last - first <= LEAF {
            self.push_leaf(part, first, last - first);
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
        self.branches[node].right = self.branches.len() as u32;
        self.split_faces(part, centre, first + middle, last);
    }

    pub(super) fn push_leaf(&mut self, part: u16, first: usize, count: usize) {
        let node = self.push(IS_LEAF | first as u32, count as u16, part);
        self.branches[node].link = self.leaves.len() as u32;
        self.leaves.push(Leaf { node: node as u32, cover: node as u32, ring: 0..0 });
    }

    pub(super) fn push(&mut self, right: u32, count: u16, part: u16) -> usize {
        self.branches.push(Branch { right, count, part, link: NONE, disc: false, smooth: false });
        self.branches.len() - 1
    }
}

/// Whether there are particles that no [`Joint`](super::Joint) knows.
fn has_unjoined(surface: &Surface) -> bool {
    let topology = &surface.topology;
    let is_third = |(f, e): (u32, u32)| !topology.edge_faces[e as usize].contains(&f);
    let mut edges = (0..).zip(&topology.face_edges).flat_map(|(f, edges)| edges.map(|e| (f, e)));
    (0..surface.len() as u32).any(|v| topology.around(v).len() > HUB) || edges.any(is_third)
}
