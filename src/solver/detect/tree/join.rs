//! Joins the topologies of the trees of cloths into that of an island. Their nodes stand one after the other, below a few that
//! hold more than one cloth.
//!
//! ```text
//!             MIXED                     numbers of nodes, faces, particles, leaves and joints shift by what stands before
//!            /     \
//!       MIXED       cloth 2
//!      /     \
//! cloth 0   cloth 1
//! ```
//!
//! The result is that of [`TreeTopology::new`] for all cloths at once, which would take a hundred times as long.

use std::sync::Arc;

use super::{Branch, IS_LEAF, Joint, Leaf, TreeTopology};
use crate::solver::topology::NONE;

impl TreeTopology {
    /// Joins those of single cloths, each with the number of its particles; that of the only one is shared.
    #[must_use]
    pub fn join(cloths: &[(&Arc<Self>, u32)]) -> Arc<Self> {
        if let [(only, _)] = cloths
            && !only.branches.is_empty()
        {
            return Arc::clone(only);
        }
        let sum = |of: fn(&Self) -> usize| cloths.iter().map(|(cloth, _)| of(cloth)).sum::<usize>();
        let faces = sum(|cloth| cloth.faces.len());
        let mut joined = Self {
            branches: Vec::with_capacity(sum(|cloth| cloth.branches.len()) + cloths.len()),
            faces: Vec::with_capacity(faces),
            corners: Vec::with_capacity(faces),
            leaves: Vec::with_capacity(sum(|cloth| cloth.leaves.len())),
            rings: Vec::with_capacity(sum(|cloth| cloth.rings.len())),
            joints: Vec::with_capacity(sum(|cloth| cloth.joints.len())),
            unjoined: cloths.iter().any(|(cloth, _)| cloth.unjoined),
        };
        let mut particles = 0;
        if !cloths.is_empty() {
            joined.split_parts(0, cloths.len(), &mut |joined, part| {
                let (cloth, count) = cloths[part];
                joined.append(cloth, part as u16, particles);
                particles += count;
            });
        }
        Arc::new(joined)
    }

    /// Puts that of one cloth behind what is there, whose faces and particles come before its own.
    fn append(&mut self, cloth: &Self, part: u16, particles: u32) {
        if cloth.branches.is_empty() {
            self.push_leaf(part, self.faces.len(), 0);
            return;
        }
        let [nodes, faces, leaves, rings, joints] =
            [self.branches.len(), self.faces.len(), self.leaves.len(), self.rings.len(), self.joints.len()]
                .map(|len| len as u32);
        let shifted = |number: u32, by: u32| if number == NONE { NONE } else { number + by };
        self.branches.extend(cloth.branches.iter().map(|branch| {
            let is_leaf = branch.right & IS_LEAF != 0;
            // The flag of a leaf is above all numbers of faces.
            let right = branch.right + if is_leaf { faces } else { nodes };
            Branch { right, part, link: shifted(branch.link, if is_leaf { leaves } else { joints }), ..*branch }
        }));
        self.faces.extend(cloth.faces.iter().map(|f| f + faces));
        self.corners.extend(cloth.corners.iter().map(|corners| corners.map(|v| v + particles)));
        self.leaves.extend(cloth.leaves.iter().map(|leaf| Leaf {
            node: leaf.node + nodes,
            cover: leaf.cover + nodes,
            ring: leaf.ring.start + rings..leaf.ring.end + rings,
        }));
        self.rings.extend(cloth.rings.iter().map(|f| f + faces));
        self.joints.extend(cloth.joints.iter().map(|joint| Joint {
            nodes: joint.nodes.map(|i| i + nodes),
            first: joint.first + joints,
            count: joint.count,
        }));
    }
}

#[cfg(test)]
mod tests {
    use std::f32::consts::TAU;

    use glam::vec3;

    use super::*;
    use crate::solver::detect::tree::Tree;
    use crate::solver::detect::{PartRef, Surface};
    use crate::solver::rest::{RestShape, SourceMesh};
    use crate::solver::scene::grid;

    #[test]
    fn joined_topologies_are_that_of_all_cloths() {
        let sheet = |n: u32| grid(n, n + 2, |u, v| vec3(u, 0.1 * (7.0 * u).sin(), v));
        let tube = grid(9, 12, |u, v| vec3((TAU * u).cos(), v, (TAU * u).sin()));
        // Through a point in the middle, past an edge with three faces.
        let mut soup = SourceMesh { positions: (0..9).map(|i| vec3(i as f32, (i * i) as f32, 1.0)).collect(), ..tube.clone() };
        soup.triangles = [[0, 1, 2], [0, 1, 3], [1, 0, 4], [0, 5, 6], [0, 6, 7], [5, 8, 0], [2, 3, 7]].to_vec();
        soup.uvs.clear();
        let shapes: Vec<RestShape> =
            [sheet(13), tube, soup, sheet(4)].iter().map(|mesh| RestShape::build(mesh).expect("a mesh").0).collect();
        for n in 1..=shapes.len() {
            let part = |rest: &'_ RestShape| (rest.topology.clone(), rest.positions.clone());
            let parts: Vec<_> = shapes[..n].iter().map(part).collect();
            let parts: Vec<PartRef<'_>> = parts
                .iter()
                .map(|(topology, rest)| PartRef { topology, rest, garment_layer: 0, self_collision: true, thickness: 0.01 })
                .collect();
            let whole = TreeTopology::new(&Surface::new(&parts).expect("cloths"));
            let single: Vec<_> = shapes[..n].iter().map(|rest| (rest.tree_topology(), rest.topology.particles)).collect();
            assert!(*TreeTopology::join(&single) == whole, "{n} cloths");
        }
    }

    #[test]
    fn what_has_no_faces_joins_as_an_empty_leaf() {
        let (rest, _) = RestShape::build(&grid(5, 5, |u, v| vec3(u, 0.0, v))).expect("a sheet");
        let nothing = Arc::new(TreeTopology::default());
        let some = rest.tree_topology();
        let joined = Tree::new(TreeTopology::join(&[(&nothing, 0), (some, 25)]));
        let tree = Tree::new(rest.tree_topology().clone());
        assert_eq!((joined.leaves(), joined.leaf(0).faces.len()), (tree.leaves() + 1, 0));
        assert_eq!(joined.leaf(1).faces, tree.leaf(0).faces);
        let joined = Tree::new(TreeTopology::join(&[(some, 25), (&nothing, 0)]));
        assert_eq!((joined.leaves(), joined.is_quarantined(1)), (tree.leaves() + 1, false));
        assert_eq!(Tree::new(TreeTopology::join(&[(&nothing, 0)])).leaves(), 1);
    }

    #[test]
    fn that_of_the_only_cloth_is_shared_and_so_is_that_of_a_multiple() {
        let (rest, _) = RestShape::build(&grid(5, 5, |u, v| vec3(u, 0.0, v))).expect("a sheet");
        let shared = rest.tree_topology();
        assert!(Arc::ptr_eq(&TreeTopology::join(&[(shared, 25)]), shared));
        assert!(Arc::ptr_eq(rest.scaled(2.0).expect("a shape").tree_topology(), shared));
    }
}
