//! What is derived from the rest shape, the fabric and the pins of one cloth.

use crate::solver::integrate::{bend, coarse, follow_the_leader, spring, tether};
use crate::solver::rest::RestShape;

/// Factors of constraints. [`prepare`](super::prepare) derives them before the first frame; what depends on the length of a
/// substep follows in the frame.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Factors {
    pub(super) springs: spring::SpringFactors,
    /// Whether triangles hold it together in its plane, in place of springs.
    pub(super) triangles: bool,
    pub(super) bends: bend::BendFactors,
    pub(super) tethers: tether::Tethers,
    pub(super) coarse: coarse::CoarseLevel,
    pub(super) follow_the_leader: follow_the_leader::FollowTheLeader,
    /// Particles that nothing moves.
    pub(super) rigid: Vec<u32>,
    /// Area at rest `[m²]`.
    pub(super) area: f32,
    /// Longest edge at rest `[m]`.
    pub(super) longest_edge: f32,
    /// Whether springs run along the threads of the fabric, as far as anything tells those.
    pub(super) along_threads: bool,
    /// Step that springs, triangles and the coarse level are for `[s]`; 0: none yet.
    pub(super) substep: f32,
    /// Sizes of the rest shape that they are derived from; none yet.
    pub(super) sizes: Option<[usize; 3]>,
}

impl Factors {
    /// Numbers of particles, and of batches of springs and bending elements. Factors index these.
    pub(super) fn sizes_of(rest: &RestShape) -> [usize; 3] {
        [rest.positions.len(), rest.springs.a.len(), rest.bends.hinges.len()]
    }

    /// Heap that they hold `[B]`.
    pub(super) fn bytes(&self) -> usize {
        self.springs.bytes() + self.bends.bytes() + self.tethers.bytes() + self.coarse.bytes() + self.follow_the_leader.bytes()
    }
}
