//! Near pairs, in the order in which they were asked for, until there are enough to find closest points four at a time.

use glam::{Vec3, Vec3A, Vec4};

use super::closest::{edges, find_four, vertex_faces};
use super::near::{Found, Near};
use crate::solver::detect::ProximityKind;
use crate::solver::detect::four::{Four, WIDE, each};
use crate::solver::detect::tree::LEAF;

/// Pairs whose closest points are found at once, at least: enough to fill all lanes, and few enough for the fastest cache.
pub(super) const BATCH: usize = 64;
/// With what a row of faces adds: of each pair of faces three corners of either, and three times three edges.
const MOST_NEAR: usize = BATCH + LEAF * (3 + 3 + 3 * 3);

/// What is near and what of it may touch, in the order in which it was asked for.
#[derive(Debug)]
pub(super) struct Batch {
    near: Vec<Near>,
    /// Of each; more than there are.
    found: Vec<Found>,
    /// Which are particles and faces, and which edges.
    kinds: [Vec<u32>; 2],
}

impl Default for Batch {
    /// Room for as many pairs as two leaves can have.
    fn default() -> Self {
        let kinds = [Vec::with_capacity(MOST_NEAR), Vec::with_capacity(MOST_NEAR)];
        Self { near: Vec::with_capacity(MOST_NEAR), found: vec![Found::NOTHING; MOST_NEAR], kinds }
    }
}

impl Batch {
    pub(super) fn clear(&mut self) {
        self.near.clear();
        self.kinds.iter_mut().for_each(Vec::clear);
    }

    #[inline]
    pub(super) fn len(&self) -> usize {
        self.near.len()
    }

    #[inline]
    pub(super) fn push(&mut self, near: Near) {
        self.kinds[usize::from(near.kind == ProximityKind::EdgeEdge)].push(self.near.len() as u32);
        self.near.push(near);
    }

    /// Forgets all except those to `keep`.
    pub(super) fn retain(&mut self, keep: impl Fn(&Near) -> bool) {
        self.near.retain(keep);
        self.kinds.iter_mut().for_each(Vec::clear);
        for (i, near) in (0..).zip(&self.near) {
            self.kinds[usize::from(near.kind == ProximityKind::EdgeEdge)].push(i);
        }
    }

    /// What is near, and what it came to.
    #[cfg(test)]
    pub(super) fn all(&self) -> impl Iterator<Item = (&Near, &Found)> {
        self.near.iter().zip(&self.found)
    }

    /// What number `i` came to, when last [found](Self::find).
    #[inline]
    pub(super) fn found(&self, i: usize) -> &Found {
        &self.found[i]
    }

    /// Finds the closest points of all that is near, at `positions` `[m]`, and whether each pair may touch on its way `ahead`
    /// `[m]`.
    pub(super) fn find(&mut self, positions: &[Vec4], ahead: &[Vec3A]) {
        self.found.resize(self.found.len().max(self.near.len()), Found::NOTHING);
        for four in fours(&self.kinds[0]) {
            find_four::<false>(&self.near, four, &mut self.found, positions, ahead);
        }
        for four in fours(&self.kinds[1]) {
            find_four::<true>(&self.near, four, &mut self.found, positions, ahead);
        }
    }

    /// Finds how far apart `rest` `[m]` has what may touch, where that `matters`.
    pub(super) fn find_at_rest(&mut self, rest: &[Vec3], matters: impl Fn(&Found) -> bool) {
        let Self { kinds, found, .. } = self;
        for kind in kinds.iter_mut() {
            kind.retain(|&i| {
                let found = &mut found[i as usize];
                found.at_rest = f32::INFINITY;
                found.may_touch && matters(found)
            });
        }
        let at = |v: u32| rest[v as usize].extend(0.0);
        for (edges_too, four) in [false, true].into_iter().zip(&*kinds).flat_map(|(of, kind)| fours(kind).map(move |i| (of, i)))
        {
            let ids = each(|lane| found[four[lane]].pair.particles);
            let x = each(|k| Four::of(each(|lane| at(ids[lane][k]))));
            let distance = if edges_too { edges(&x, &x).distance } else { vertex_faces(&x).distance };
            (0..WIDE).for_each(|lane| found[four[lane]].at_rest = distance[lane]);
        }
    }
}

/// Numbers, four at a time; where there are fewer the last one again.
#[inline]
fn fours(of: &[u32]) -> impl Iterator<Item = [usize; WIDE]> + '_ {
    of.chunks(WIDE).map(|four| each(|k| four[k.min(four.len() - 1)] as usize))
}
