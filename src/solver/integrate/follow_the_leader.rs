//! Once per frame: edges that are still beyond the strain limit are shortened, from the pins outwards.
//!
//! ```text
//!  pin --- p1 --- p2 --- p3      each particle is drawn to its neighbours nearer to a pin, nearest particle first:
//!                                one pass reaches the end of the cloth (Müller, Kim and Chentanez 2012, "follow the leader")
//! ```

use glam::Vec4;

use crate::solver::rest::{RestShape, geodesic};

/// Edges from a particle to one farther from the pins, in the order of the second.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct FollowTheLeader {
    ends: Vec<[u32; 2]>,
}

impl FollowTheLeader {
    /// Memory held `[B]`.
    #[must_use]
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.ends[..])
    }

    /// Whether nothing hangs on a pin.
    #[must_use]
    pub(crate) fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// Edges of the parts of a cloth that hang on `pinned`.
    #[must_use]
    pub(crate) fn new(rest: &RestShape, pinned: &[u32]) -> Self {
        let mut front = geodesic::Front::new(rest.positions.len());
        let mut rank = vec![u32::MAX; rest.positions.len()];
        for (&(p, distance), n) in front.run(&rest.topology, &rest.positions, pinned, f32::INFINITY).iter().zip(1..) {
            rank[p as usize] = if distance > 0.0 { n } else { 0 };
        }
        let reached = |e: &&[u32; 2]| e.iter().all(|&p| rank[p as usize] < u32::MAX) && e.iter().any(|&p| rank[p as usize] > 0);
        let mut ends: Vec<[u32; 2]> = rest.topology.edges.iter().filter(reached).copied().collect();
        for e in &mut ends {
            e.sort_by_key(|&p| rank[p as usize]);
        }
        ends.sort_by_key(|e| (rank[e[1] as usize], rank[e[0] as usize]));
        Self { ends }
    }

    /// Shortens edges to `bound` times their length at rest (dimensionless).
    pub(crate) fn solve(&self, rest: &RestShape, bound: f32, positions: &mut [Vec4]) {
        for &[near, far] in &self.ends {
            let (near, far) = (near as usize, far as usize);
            let d = (positions[near] - positions[far]).with_w(0.0);
            let longest = bound * bound * rest.positions[near].distance_squared(rest.positions[far]);
            let square = d.length_squared();
            if square > longest {
                positions[far] += d * (1.0 - (longest / square).sqrt());
            }
        }
    }
}
