//! Faces of cloth against bodies that are finer than the mesh: a needle between particles, a corner, a ball smaller than a
//! face.
//!
//! ```text
//!      o-----------o      particles at the distance kept: enough while an edge e over a radius R has a small sagitta e² / 8 R
//!     /     .-.     \
//!    /    .'   '.    \    n: normal of the part at the point p = Σ wᵢ xᵢ of the face that is nearest to it, d: distance there
//!   o----/-------\----o
//!       /  body   \       Δxᵢ = wᵢ mᵢ⁻¹ Δp / Σ wⱼ² mⱼ⁻¹
//! ```
//!
//! *Edges* that cross the edge of a box meet it at a point that stays where it is. The nearest point of a face there jumps from
//! one edge to the other. So the edges of faces are looked at by themselves, and their nearest points pushed. Faces follow,
//! only where they are touched between their edges. Two sheets over a box come to rest with it, and shook without
//! **`[measured]`**. Balls, capsules and feature edges meet whole faces, where it is no better.
//!
//! Parts that are round enough for the mesh have no faces listed and cost nothing. For the others a face keeps [`SHARE`] of the
//! distance that particles keep, so that cloth that lies flat is carried by its particles alone. One sample at the middle
//! dismisses most faces. A convex part lies behind its tangent plane, and a face that begins and ends in front of that never
//! met the part.
//!
//! *Nothing passes.* A face that was outside and may have gone through is stopped where it first touches, whatever its speed
//! ([`first_touch`](super::advance::first_touch)). It starts each substep outside, hence stays there. Faces share particles, so
//! the push of one face may lead another into a part. Such a face is stopped again, and at last kept in front of the plane that
//! divided face and part when the substep began. *A side is kept.* Other causes may move a face onto the part: cloth that
//! pushes cloth, overlong edges, tangles taken apart. Its last normal then tells where it belongs, and it is brought back along
//! that, at the speed of particles that start inside. The shortest way out of a needle is sideways, and cloth with a needle in
//! it cannot go there.
//!
//! *Surfaces* of triangles: particles meet the triangles; faces meet only the sharp edges ([`FeatureEdges`]), each as a convex
//! part of its own.
//!
//! *Between two parts* that leave no room for twice the distance kept, a face goes to the middle, instead of being pushed to
//! and fro.
//!
//! The nearest point of a face and a distance field: Macklin et al. 2020, "Local optimization for robust signed distance field
//! collision".

mod friction;
mod gather;
mod list;
mod meet;
mod memory;
mod pass;
mod piece;
mod project;
mod push;
mod setting;
mod stop;
#[cfg(test)]
mod tests;

use glam::{Vec3, Vec3A, Vec4};
use parry3d::math::Pose;

pub(crate) use list::Sheet;

use crate::solver::buffer::Buffer;

use super::feature_edges::{FeatureEdge, FeatureEdges};
use super::nearest;
use super::pierce::{Pair, Pierced};
use super::renumber;
use super::respond::Plane;
use super::squeeze::Squeezes;
use piece::Piece;

/// Distance that faces keep, as a share of what particles keep (dimensionless). Nearer 1 cloth lies more evenly on fine bodies
/// and more faces have to be asked for.
const SHARE: f32 = 0.5;

/// A face, or a piece of one, that may meet a part of a body in this frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
struct Candidate {
    face: u32,
    piece: Piece,
    /// Which of the feature edges of a surface; of no meaning for a convex part.
    feature_edge: u32,
    /// Corner nearest to the touch.
    corner: u32,
    particles: [u32; 3],
    /// Running mean of the push per substep `[m]`; 0 out of contact.
    load: f32,
    /// What the push would be if that corner alone bore it (dimensionless).
    share: f32,
    /// The plane on which it was put when it last touched, in the space of the part, and weights of its point there.
    plane: Plane,
    weights: [f32; 3],
    /// Height over the plane at which that was put `[m]`: 0, or less in an overlap.
    floor: f32,
    /// Normal of the part where the face was last outside, in its own space; zero: not known.
    side: Vec3,
    /// On which side of the part it lay when last touched within it, by its own normal: 1, -1, or 0 when it did not.
    over: f32,
    /// Corners when a tangent plane was last found, in the part's own space `[m]`. `clear`: how far they may go until one has
    /// to be looked for again `[m]`.
    corners: [Vec3; 3],
    clear: f32,
    /// Whether a corner is pinned to a body.
    left_out: bool,
}

impl Candidate {
    /// Whether it touched when last projected.
    fn is_touching(&self) -> bool {
        self.load > 0.0
    }

    /// Its corners among `positions`; not numbers for those that are not there.
    fn corners(&self, positions: &[Vec4]) -> [Vec4; 3] {
        self.particles.map(|p| positions.get(p as usize).copied().unwrap_or(Vec4::NAN))
    }

    /// The particles that move with its point, whose [mobility](push::mobility) is `mobility` `[1/kg]`, and by which share of
    /// its way (dimensionless).
    fn shares(&self, corners: &[Vec4; 3], mobility: f32) -> impl Iterator<Item = (u32, f32)> {
        let shares = self.weights.iter().zip(*corners).map(move |(weight, x)| weight * x.w / mobility);
        self.piece.of(&self.particles).iter().copied().zip(shares)
    }
}

/// The point of a face with these `corners` that `weights` tell `[m]`.
fn point(weights: &[f32; 3], corners: [Vec4; 3]) -> Vec3A {
    nearest::at(&corners.map(Vec3A::from_vec4), weights)
}

/// One convex shape or surface of a body, with the faces near it.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
struct Part {
    body: u32,
    index: u32,
    local: Pose,
    planes: (u32, u32),
    candidates: (u32, u32),
    radius: f32,
    /// Whether it could go through a face, being smaller.
    pierces: bool,
}

/// Faces of one cloth near bodies that are finer than its mesh. Buffers are reused: nothing is allocated once they are warm.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct FaceContacts {
    parts: Vec<Part>,
    planes: Vec<Vec4>,
    candidates: Vec<Candidate>,
    /// Numbers of those that touched when last projected, in ascending order; empty until they are asked for.
    touching: Vec<u32>,
    is_listed: bool,
    /// Sharp edges of surfaces, in their own space; the first is that of convex parts, which have none.
    feature_edges: Vec<FeatureEdge>,
    edge_cache: Buffer<FeatureEdges>,
    parts_before: Buffer<Vec<Part>>,
    candidates_before: Buffer<Vec<Candidate>>,
    feature_edges_before: Buffer<Vec<FeatureEdge>>,
    /// Boxes around faces, [`list::BLOCK`] at a time.
    blocks: Vec<(Vec3, Vec3)>,
    squeezes: Squeezes,
    dt: f32,
}

impl FaceContacts {
    /// Number of pairs that are looked at in each substep of this frame. A pair is a face, or an edge of one, and a part of a
    /// body.
    #[must_use]
    pub(crate) fn candidates(&self) -> usize {
        self.candidates.len()
    }

    /// Number of the body, particle and mean push per substep `[m]` of every touch when last projected, as if the nearest
    /// corner bore it alone.
    pub(crate) fn loads(&self) -> impl Iterator<Item = (usize, u32, f32)> + '_ {
        self.parts.iter().flat_map(|part| {
            let candidates = self.candidates.get(part.candidates.0 as usize..part.candidates.1 as usize).unwrap_or(&[]);
            candidates.iter().filter(|c| c.is_touching()).map(|c| (part.body as usize, c.corner, c.load * c.share))
        })
    }

    /// Particles of faces that touched when last projected.
    pub(crate) fn touching(&self) -> impl Iterator<Item = u32> + '_ {
        self.candidates.iter().filter(|c| c.is_touching()).flat_map(|c| c.particles)
    }

    /// Bodies have other numbers now, in the same order, or none.
    pub(crate) fn renumber(&mut self, number: impl Fn(u32) -> Option<u32>) {
        renumber(&mut self.parts, |part| &mut part.body, number);
    }

    /// Takes out the faces of particles that are pinned to bodies, in ascending order.
    pub(crate) fn leave_out(&mut self, particles: &[u32]) {
        debug_assert!(particles.is_sorted());
        if particles.is_empty() {
            return;
        }
        self.is_listed = false;
        for candidate in &mut self.candidates {
            if candidate.particles.iter().any(|p| particles.binary_search(p).is_ok()) {
                (candidate.left_out, candidate.load) = (true, 0.0);
            }
        }
    }

    /// Takes out the faces of particles that bones go through, or that their skin holds.
    pub(crate) fn let_through(&mut self, pierced: &Pierced) {
        let held = pierced.held().iter().map(|held| held.pair);
        for Pair { body, part, particle } in held.chain(pierced.pairs().iter().copied()) {
            let Some(part) = self.parts.iter().find(|p| (p.body, p.index) == (body, part)) else { continue };
            let (first, end) = part.candidates;
            for candidate in &mut self.candidates[first as usize..end as usize] {
                if candidate.particles.contains(&particle) {
                    (candidate.left_out, candidate.load) = (true, 0.0);
                }
            }
        }
    }
}
