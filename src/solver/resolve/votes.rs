//! Which contour a contour was: its crossings vote for those that were at the same places before.
//!
//! ```text
//!   an edge, with the faces it crosses:   before  ──g────────f─────h──        f votes 4 for f; else 1 for each of the two
//!                                         now     ──────f─────────h───        beside it along the edge, as g and h
//! ```
//!
//! So an edge that crosses thousands of faces casts no more than three votes for each.

use super::contour::ContourGraph;
use crate::solver::detect::Crossing;

/// A vote for an equal pair of edge and face, and for what is beside a crossing on its edge.
const EQUAL_PAIR: i32 = 4;
const BESIDE: i32 = 1;

/// A crossing of the time before.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
struct Key {
    edge: u32,
    face: u32,
    /// Where along the edge.
    t: f32,
    contour: u32,
    side: u8,
}

/// What one crossing says a contour was.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Vote {
    pub contour: u32,
    pub before: u32,
    pub weight: i32,
    /// The weight again if sides are equal, else 0.
    pub same: i32,
}

/// The crossings of the time before, and what those of now say. Buffers are reused.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Votes {
    /// Sorted by edge, then face.
    keys: Vec<Key>,
    /// Those of one edge, sorted along it.
    along: Vec<Key>,
    list: Vec<Vote>,
}

impl Votes {
    /// Forgets the time before.
    pub(super) fn clear(&mut self) {
        self.keys.clear();
    }

    /// Takes in the crossings of now, for the next time.
    pub(super) fn take_in(&mut self, crossings: &[Crossing], graph: &ContourGraph) {
        self.keys.clear();
        let of = crossings.iter().zip(graph.contour_of.iter().zip(&graph.side));
        self.keys.extend(of.map(|(c, (&contour, &side))| Key { edge: c.edge, face: c.face, t: c.t, contour, side }));
    }

    /// The votes of all crossings, sorted.
    pub(super) fn cast(&mut self, crossings: &[Crossing], graph: &ContourGraph) -> &[Vote] {
        let Self { keys, along, list } = self;
        list.clear();
        let (mut low, mut first) = (0, 0);
        // Joins two lists that are sorted by edge.
        for of_edge in crossings.chunk_by(|a, b| a.edge == b.edge) {
            let edge = of_edge.first().map_or(0, |c| c.edge);
            low += keys[low..].iter().take_while(|k| k.edge < edge).count();
            let count = keys[low..].iter().take_while(|k| k.edge == edge).count();
            let before = &keys[low..low + count];
            along.clear();
            along.extend_from_slice(before);
            // Of two both are beside everything.
            if count > 2 {
                along.sort_unstable_by(|a, b| a.t.total_cmp(&b.t).then(a.face.cmp(&b.face)));
            }
            for (c, i) in of_edge.iter().zip(first..) {
                let (contour, side) = (graph.contour_of[i], graph.side[i]);
                let mut vote = |key: &Key, weight: i32| {
                    list.push(Vote { contour, before: key.contour, weight, same: if key.side == side { weight } else { 0 } });
                };
                let equal = before.binary_search_by_key(&c.face, |k| k.face).ok().map(|i| &before[i]);
                equal.into_iter().for_each(|key| vote(key, EQUAL_PAIR));
                let at = if count > 2 { along.partition_point(|k| k.t < c.t) } else { 1 };
                let beside = along.get(at.saturating_sub(1)..count.min(at + 1)).unwrap_or_default();
                beside.iter().filter(|k| k.face != c.face).for_each(|key| vote(key, BESIDE));
            }
            first += of_edge.len();
            low += count;
        }
        list.sort_unstable();
        list
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_edge_through_a_thousand_faces_casts_three_votes_for_each() {
        const FACES: u32 = 1000;
        // Where the faces stand along the edge has nothing to do with their numbers.
        let t = |face: u32| (face * 389 % FACES) as f32 / FACES as f32;
        let crossing = |face: u32| Crossing { edge: 0, face, t: t(face), weights: [1.0, 0.0, 0.0], touching: false };
        let crossings: Vec<Crossing> = (0..FACES).map(crossing).collect();
        let mut graph = ContourGraph::default();
        graph.contour_of.extend(0..FACES);
        graph.side.resize(FACES as usize, 0);
        let mut votes = Votes::default();
        votes.take_in(&crossings, &graph);
        let cast = votes.cast(&crossings, &graph);
        assert!(cast.len() <= 3 * FACES as usize, "{} votes", cast.len());
        for face in 0..FACES {
            let best = cast.iter().filter(|v| v.contour == face).max_by_key(|v| v.weight);
            assert_eq!(best.map(|v| v.before), Some(face));
        }
    }
}
