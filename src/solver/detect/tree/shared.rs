//! What the two children of each node share, found for all nodes at once.
//!
//! The faces at a particle stand at some places of [`TreeTopology::faces`]. Take two of these places that follow each other.
//! Because of them, the particle is in both children of the lowest node above both places, and of no other node.

use core::ops::Range;

use super::{Branch, IS_LEAF, TreeTopology};
use crate::solver::detect::Surface;
use crate::solver::topology::NONE;

/// What nodes hold, and what their children share.
pub(super) struct Shared {
    /// Places of the faces below each node.
    pub ranges: Vec<Range<u32>>,
    /// Place of each face.
    pub place: Vec<u32>,
    /// Edges with a face in both children of each node.
    pub edges: Vec<u32>,
    /// Particles in both children of each node, in ascending order.
    particles: Runs,
    /// Places of the faces at each particle, in ascending order.
    places: Runs,
}

impl Shared {
    pub(super) fn new(tree: &TreeTopology, surface: &Surface) -> Self {
        let topology = &surface.topology;
        let TreeTopology { branches, faces, .. } = tree;
        let (place, ranges) = (places(faces), ranges(branches));
        let corners = || (0..).zip(faces).flat_map(|(at, &f)| topology.faces[f as usize].map(|v| (v, at)));
        let places = Runs::new(surface.len(), corners);
        let particles = || {
            let pairs = |v: u32| places.of(v).windows(2).map(move |pair| (v, [pair[0], pair[1]]));
            (0..surface.len() as u32).flat_map(pairs).map(|(v, pair)| (lowest_above(branches, &ranges, pair), v))
        };
        let particles = Runs::new(branches.len(), particles);
        let mut edges = vec![0; branches.len()];
        for &faces in topology.edge_faces.iter().filter(|faces| !faces.contains(&NONE)) {
            let [a, b] = faces.map(|f| place[f as usize]);
            edges[lowest_above(branches, &ranges, [a.min(b), a.max(b)]) as usize] += 1;
        }
        Self { ranges, place, edges, particles, places }
    }

    /// Particles in both children of a node, in ascending order.
    pub(super) fn particles(&self, node: u32) -> &[u32] {
        self.particles.of(node)
    }

    /// Whether a face below a node has a particle.
    pub(super) fn has(&self, node: u32, particle: u32) -> bool {
        self.places.of(particle).iter().any(|at| self.ranges[node as usize].contains(at))
    }
}

/// Where each face stands.
fn places(faces: &[u32]) -> Vec<u32> {
    let mut place = vec![0; faces.len()];
    for (i, &f) in faces.iter().enumerate() {
        place[f as usize] = i as u32;
    }
    place
}

/// Places of the faces below each node.
fn ranges(branches: &[Branch]) -> Vec<Range<u32>> {
    let mut ranges = vec![0..0; branches.len()];
    for (i, node) in branches.iter().enumerate().rev() {
        ranges[i] = if node.right & IS_LEAF == 0 {
            ranges[i + 1].start..ranges[node.right as usize].end
        } else {
            node.run().start as u32..node.run().end as u32
        };
    }
    ranges
}

/// The lowest node above two places, the smaller first: a leaf if it has both.
pub(super) fn lowest_above(branches: &[Branch], ranges: &[Range<u32>], [first, last]: [u32; 2]) -> u32 {
    let mut node = 0;
    while branches[node as usize].right & IS_LEAF == 0 {
        let right = branches[node as usize].right;
        let border = ranges[right as usize].start;
        node = if last < border {
            node + 1
        } else if first >= border {
            right
        } else {
            break;
        };
    }
    node
}

/// Runs of numbers, one for each key.
struct Runs {
    start: Vec<u32>,
    numbers: Vec<u32>,
}

impl Runs {
    /// Takes in `pairs` of a key below `keys` and a number, which stay in their order.
    fn new<I: Iterator<Item = (u32, u32)>>(keys: usize, pairs: impl Fn() -> I) -> Self {
        let mut start = vec![0; keys + 1];
        pairs().for_each(|(key, _)| start[key as usize + 1] += 1);
        for i in 1..start.len() {
            start[i] += start[i - 1];
        }
        let (mut next, mut numbers) = (start.clone(), vec![0; start[keys] as usize]);
        for (key, number) in pairs() {
            numbers[next[key as usize] as usize] = number;
            next[key as usize] += 1;
        }
        Self { start, numbers }
    }

    fn of(&self, key: u32) -> &[u32] {
        let key = key as usize;
        &self.numbers[self.start[key] as usize..self.start[key + 1] as usize]
    }
}
