//! The faces of a leaf side by side, so that one face is asked against four at once.
//!
//! ```text
//! lanes     corner 0, 1, 2 of faces 0 1 2 3 | 4 5 6 7       where they are, and where they are foreseen to be
//! corners   v v v v | v …                                    that the faces own, in the order of faces, each with its box
//! edges     e e e e | e e e e | e …                          likewise
//! ```
//!
//! Lanes and boxes of a leaf are laid out when they are first asked for after everything moved. Leaves that only meet flat
//! neighbours are not asked.

use core::ops::Range;

use glam::{Vec3A, Vec4};

use super::gap::way;
use crate::solver::buffer::keep_room_up_to;
use crate::solver::detect::four::{Four, WIDE, each};
use crate::solver::detect::tree::{Bounds, LEAF, Tree};
use crate::solver::topology::NONE;

/// Corners of the faces of a leaf, by corner and half of the lanes `[m]`; lanes without a face repeat the last one.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Lanes {
    pub(super) now: [[Four; LEAF / WIDE]; 3],
    pub(super) ahead: [[Four; LEAF / WIDE]; 3],
}

impl Lanes {
    const NONE: Self = Self { now: [[Four::ZERO; LEAF / WIDE]; 3], ahead: [[Four::ZERO; LEAF / WIDE]; 3] };

    #[inline(never)]
    fn fit(&mut self, corners: &[[u32; 3]], positions: &[Vec4], ahead: &[Vec3A]) {
        let Some(last) = corners.len().checked_sub(1) else { return };
        for half in 0..LEAF / WIDE {
            let faces = each(|k| corners[(half * WIDE + k).min(last)]);
            for c in 0..3 {
                self.now[c][half] = Four::of(each(|k| positions[faces[k][c] as usize]));
                self.ahead[c][half] = Four::of(each(|k| ahead[faces[k][c] as usize].extend(0.0)));
            }
        }
    }
}

/// Four boxes `[m]`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Boxes {
    min: Four,
    max: Four,
}

impl Boxes {
    #[inline]
    fn of(boxes: [Bounds; WIDE]) -> Self {
        Self { min: Four::of(each(|k| boxes[k].min.extend(0.0))), max: Four::of(each(|k| boxes[k].max.extend(0.0))) }
    }

    /// Which of them come within `margin` `[m]` of another along every axis, as [`Bounds::meets`].
    #[inline]
    fn meets(&self, low: Four, high: Four, margin: Vec4) -> u32 {
        let within = |low: Vec4, high: Vec4, min: Vec4, max: Vec4| low.cmple(max) & (min - margin).cmple(high);
        let (x, y) = (within(low.x, high.x, self.min.x, self.max.x), within(low.y, high.y, self.min.y, self.max.y));
        (x & y & within(low.z, high.z, self.min.z, self.max.z)).bitmask()
    }
}

/// The particles or the edges that the faces of each leaf own.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Owned {
    /// First of a leaf; and where those of each face begin after it, and end.
    first: Vec<u32>,
    starts: Vec<[u8; LEAF + 1]>,
    /// The ends of each; twice a particle.
    ends: Vec<[u32; 2]>,
}

impl Owned {
    /// Of all leaves; `ends` gives those that a face owns.
    fn new<I: Iterator<Item = [u32; 2]>>(tree: &Tree, ends: impl Fn(u32) -> I) -> Self {
        let mut owned = Self::default();
        for leaf in 0..tree.leaves() {
            let (first, mut starts) = (owned.ends.len(), [0; LEAF + 1]);
            let faces = tree.leaf(leaf).faces;
            for (lane, start) in starts.iter_mut().enumerate() {
                *start = (owned.ends.len() - first) as u8;
                owned.ends.extend(faces.get(lane).into_iter().flat_map(|&f| ends(f)));
            }
            owned.first.push(first as u32);
            owned.starts.push(starts);
        }
        owned
    }

    /// Number of boxes for all leaves, at most.
    fn boxes(&self) -> usize {
        self.ends.len() / WIDE + self.first.len()
    }

    /// What the faces of a leaf own.
    #[inline]
    fn leaf(&self, leaf: u32) -> Owns<'_> {
        let (first, starts) = (self.first[leaf as usize] as usize, &self.starts[leaf as usize]);
        Owns { starts, ends: &self.ends[first..first + usize::from(starts[LEAF])] }
    }
}

/// What the faces of a leaf own.
#[derive(Clone, Copy)]
pub(super) struct Owns<'a> {
    starts: &'a [u8; LEAF + 1],
    /// The ends of each; twice a particle.
    pub(super) ends: &'a [[u32; 2]],
}

impl Owns<'_> {
    /// Numbers of those that the face in a lane owns.
    #[inline]
    pub(super) fn of_face(&self, lane: usize) -> Range<usize> {
        usize::from(self.starts[lane])..usize::from(self.starts[lane + 1])
    }

    /// Boxes of all, four at a time and the empty one where there is none; `around` gives the box of the way of a particle.
    fn boxes(&self, around: impl Fn(u32) -> Bounds) -> impl Iterator<Item = Boxes> {
        self.ends
            .chunks(WIDE)
            .map(move |ends| Boxes::of(each(|k| ends.get(k).map_or(Bounds::EMPTY, |&[a, b]| around(a).union(around(b))))))
    }
}

/// Which of `boxes` come within `margin` `[m]` of another along every axis, a bit for each number.
#[inline]
pub(super) fn boxes_within(boxes: &[Boxes], bounds: &Bounds, margin: f32) -> u32 {
    let (low, high) = (Four::splat(bounds.min - Vec3A::splat(margin)), Four::splat(bounds.max));
    let met = boxes.iter().rev().map(|boxes| boxes.meets(low, high, Vec4::splat(margin)));
    met.fold(0, |bits, met| bits << WIDE | met)
}

/// What the faces of all leaves own.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Patches {
    corners: Owned,
    edges: Owned,
}

/// What was laid out of the leaves that were asked for since everything moved. Before leaves are asked for, and whenever
/// everything moved, it has to [forget](Self::forget).
#[derive(Debug, Default)]
pub(super) struct Laid {
    lanes: Vec<Lanes>,
    boxes: Vec<Boxes>,
    /// Where the lanes of each leaf are, and where its boxes are, those of corners before those of edges; `NONE`: nowhere.
    lanes_at: Vec<u32>,
    boxes_at: Vec<u32>,
}

impl Patches {
    /// Of a tree; `owns` has, of each face, bits 0 to 2 for corners it owns, and 3 to 5 for its edges.
    pub(super) fn new(tree: &Tree, faces: &[[u32; 3]], owns: &[u8]) -> Self {
        let owned = |f: u32, shift: u32, next: usize| {
            let (t, bits) = (faces[f as usize], owns[f as usize] >> shift);
            (0..3).filter(move |k| bits & (1 << k) != 0).map(move |k| [t[k], t[(k + next) % 3]])
        };
        Self { corners: Owned::new(tree, |f| owned(f, 0, 0)), edges: Owned::new(tree, |f| owned(f, 3, 1)) }
    }

    /// The corners and the edges that the faces of a leaf own.
    #[inline]
    pub(super) fn owned(&self, leaf: u32) -> [Owns<'_>; 2] {
        [self.corners.leaf(leaf), self.edges.leaf(leaf)]
    }
}

impl Laid {
    /// Forgets what is laid out: everything moved.
    pub(super) fn forget(&mut self, patches: &Patches) {
        let leaves = patches.corners.first.len();
        let most: usize = [&patches.corners, &patches.edges].map(Owned::boxes).iter().sum();
        let Self { lanes, boxes, lanes_at, boxes_at } = self;
        for at in [lanes_at, boxes_at] {
            at.clear();
            at.resize(leaves, NONE);
        }
        let were = [lanes.len(), boxes.len()];
        lanes.clear();
        boxes.clear();
        keep_room_up_to(lanes, were[0], leaves);
        keep_room_up_to(boxes, were[1], most);
    }

    /// The corners of the faces of a leaf.
    #[inline]
    pub(super) fn lanes(&mut self, tree: &Tree, leaf: u32, positions: &[Vec4], ahead: &[Vec3A]) -> &Lanes {
        let Self { lanes, lanes_at, .. } = self;
        let at = &mut lanes_at[leaf as usize];
        if *at == NONE {
            *at = lanes.len() as u32;
            lanes.push(Lanes::NONE);
            lanes[*at as usize].fit(tree.leaf(leaf).corners, positions, ahead);
        }
        &lanes[*at as usize]
    }

    /// Makes [boxes](Self::boxes) of what the faces of a leaf own.
    #[inline]
    pub(super) fn fit(&mut self, patches: &Patches, leaf: u32, positions: &[Vec4], ahead: &[Vec3A]) {
        let Self { boxes, boxes_at, .. } = self;
        let at = &mut boxes_at[leaf as usize];
        if *at == NONE {
            *at = boxes.len() as u32;
            for owned in [&patches.corners, &patches.edges] {
                boxes.extend(owned.leaf(leaf).boxes(|v| way(positions, ahead, v)));
            }
        }
    }

    /// Boxes of the corners and of the edges that the faces of a leaf own; none before they were [made](Self::fit).
    #[inline]
    pub(super) fn boxes(&self, patches: &Patches, leaf: u32) -> [&[Boxes]; 2] {
        debug_assert_ne!(self.boxes_at[leaf as usize], NONE, "leaf {leaf} has no boxes yet");
        let counts =
            [&patches.corners, &patches.edges].map(|owned| usize::from(owned.starts[leaf as usize][LEAF]).div_ceil(WIDE));
        let boxes = self.boxes.get(self.boxes_at[leaf as usize] as usize..).unwrap_or_default();
        let (corners, rest) = boxes.split_at_checked(counts[0]).unwrap_or_default();
        [corners, rest.get(..counts[1]).unwrap_or_default()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::detect::{PartRef, Surface};
    use crate::solver::rest::RestShape;
    use crate::solver::scene::grid;

    #[test]
    fn what_faces_own_is_asked_as_its_box_is() {
        let mesh = grid(9, 8, |u, v| glam::vec3(u, 0.0, v));
        let (rest, _) = RestShape::build(&mesh).expect("a sheet");
        let part = PartRef {
            topology: &rest.topology,
            rest: &rest.positions,
            garment_layer: 0,
            self_collision: true,
            thickness: 0.01,
        };
        let surface = Surface::new(&[part]).expect("a cloth");
        let tree = Tree::of_surface(&surface);
        let faces = &surface.topology.faces;
        let patches = Patches::new(&tree, faces, &vec![0b10_1001; faces.len()]);
        let mut rng = fastrand::Rng::with_seed(2);
        let mut laid = Laid::default();
        laid.forget(&patches);
        let positions: Vec<Vec4> = surface.rest.iter().map(|x| (*x + rng.f32()).extend(1.0)).collect();
        let ahead: Vec<Vec3A> = positions.iter().map(|x| Vec3A::from_vec4(*x) + 0.2 * rng.f32()).collect();
        let mut met = 0;
        for leaf in 0..tree.leaves() {
            laid.fit(&patches, leaf, &positions, &ahead);
            let bounds = way(&positions, &ahead, rng.u32(0..72)).union(way(&positions, &ahead, rng.u32(0..72)));
            for ((of, boxes), count) in patches.owned(leaf).iter().zip(laid.boxes(&patches, leaf)).zip([1, 2]) {
                let within = boxes_within(boxes, &bounds, 0.1);
                let own = |&[a, b]: &[u32; 2]| way(&positions, &ahead, a).union(way(&positions, &ahead, b));
                let expected = of.ends.iter().map(own).map(|own| own.meets(&bounds, Vec3A::splat(0.1)));
                let bits = expected.enumerate().fold(0, |bits, (k, meets)| bits | u32::from(meets) << k);
                assert_eq!(within, bits);
                met += bits.count_ones();
                let lanes = tree.leaf(leaf).faces.len();
                assert!((0..lanes).all(|lane| of.of_face(lane) == (count * lane..count * (lane + 1))));
            }
        }
        assert!(met > 30, "{met}");
    }

    #[test]
    fn what_is_laid_out_is_that_of_its_leaf_in_any_order_until_everything_moves() {
        let mesh = grid(12, 9, |u, v| glam::vec3(u, 0.0, v));
        let (rest, _) = RestShape::build(&mesh).expect("a sheet");
        let tree = Tree::new(rest.tree_topology().clone());
        let faces = &rest.topology.faces;
        let mut rng = fastrand::Rng::with_seed(3);
        let patches = Patches::new(&tree, faces, &vec![0b10_1001; faces.len()]);
        let (mut laid, mut asked) = (Laid::default(), 0);
        for _ in 0..3 {
            let positions: Vec<Vec4> = rest.positions.iter().map(|x| (*x + rng.f32()).extend(1.0)).collect();
            let ahead: Vec<Vec3A> = positions.iter().map(|x| Vec3A::from_vec4(*x) + rng.f32()).collect();
            laid.forget(&patches);
            for _ in 0..tree.leaves() {
                let leaf = rng.u32(0..tree.leaves());
                let mut alone = Laid::default();
                alone.forget(&patches);
                alone.fit(&patches, leaf, &positions, &ahead);
                if rng.bool() {
                    assert_eq!(laid.lanes(&tree, leaf, &positions, &ahead), alone.lanes(&tree, leaf, &positions, &ahead));
                    asked += 1;
                }
                laid.fit(&patches, leaf, &positions, &ahead);
                assert_eq!(laid.boxes(&patches, leaf), alone.boxes(&patches, leaf));
            }
        }
        assert!(laid.lanes.len() < asked && asked > 10, "no leaf was asked twice");
    }
}
