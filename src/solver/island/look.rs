//! What an island knows, to be looked at.

#[cfg(feature = "debug")]
use glam::Vec3;
use glam::Vec4;

use super::Island;
use crate::solver::detect::tree::Bounds;
#[cfg(feature = "debug")]
use crate::solver::resolve::ContourKind;
use crate::solver::resolve::region::Flood;

impl Island {
    /// Positions `[m]` in the frame of the island, `w` inverse mass `[1/kg]`, as gathered last and moved since.
    #[must_use]
    pub fn particles(&self) -> &[Vec4] {
        &self.positions
    }

    /// The points `[m]` where edges cross faces, in the frame of the island, each with the kind of its contour.
    #[cfg(feature = "debug")]
    pub(crate) fn crossing_points(&self) -> impl Iterator<Item = (ContourKind, Vec3)> + '_ {
        let resolver = &self.untangler.resolver;
        let graph = resolver.graph();
        let kind = |i: usize| graph.contours[graph.contour_of[i] as usize].kind;
        resolver.points().iter().enumerate().map(move |(i, &point)| (kind(i), point))
    }

    /// The boxes of the search tree `[m]` down to a `depth`, each with its own depth, as of the last look. They are around
    /// where particles are and are foreseen to be, less the motion that all share.
    pub fn boxes(&self, depth: u32) -> impl Iterator<Item = (u32, Bounds)> + '_ {
        self.untangler.detector.tree_ref().boxes(depth)
    }

    /// Calls `found` with the number of each contour that cuts a piece off a cloth, and with the particles of that piece.
    pub fn regions(&self, flood: &mut Flood, found: impl FnMut(usize, &[u32])) {
        self.untangler.resolver.regions(&self.surface, self.crossings(), &self.positions, flood, found);
    }
}
