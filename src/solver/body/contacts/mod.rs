//! Which particles may meet which body in this frame, and their contacts in each substep.

mod friction;
mod gather;
mod meet;
mod memory;
mod part;
mod project;
#[cfg(test)]
mod tests;

use glam::{Vec3, Vec4};
use parry3d::math::Pose;

pub(crate) use gather::Approach;

use super::pierce::{Pair, Pierced};
use super::renumber;
use super::respond::Plane;
use super::squeeze::Squeezes;
use crate::solver::buffer::Buffer;

/// One particle that may meet one part of a body in this frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
struct Candidate {
    particle: u32,
    /// Running mean of the push per substep `[m]`; 0 out of contact.
    load: f32,
    /// The plane on which it was put when it last touched, in the space of the part.
    plane: Plane,
    /// Height over the plane at which it was put `[m]`: 0; less in an overlap, more after a bounce.
    floor: f32,
    /// Where it began the substep in which it touched, in the space of the part `[m]`. Recovery rounds the previous position.
    /// With that as the start, particles on a ball of 0.3 m creep by 1.8e-7 m in a second; with this, by 0.7e-7
    /// **`[measured]`**.
    start: Vec3,
    /// Its previous position by then, in the cloth's frame `[m]`. What moves it afterwards is recovery, too.
    previous: Vec3,
    /// A point of body space and a radius without any surface around it `[m]`: no query while the path stays inside.
    clear_at: Vec3,
    clear: f32,
    /// By how much nearer it may be than others, as it was made `[m]`.
    inset: f32,
    /// Whether it is pinned to a body, and so touches none.
    left_out: bool,
}

impl Candidate {
    /// Whether it touched when last projected.
    fn is_touching(&self) -> bool {
        self.load > 0.0
    }
}

/// One simple shape of a body, with its candidates.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
struct Part {
    body: u32,
    index: u32,
    local: Pose,
    planes: (u32, u32),
    candidates: (u32, u32),
    /// Where the last known places of its candidates begin; none except for surfaces, which have no inside to tell a wrong side
    /// by.
    places: Option<u32>,
    /// Farthest point of the part from its own origin `[m]`; infinite for a half-space.
    radius: f32,
}

/// Contacts of one cloth with all bodies. Buffers are reused: nothing is allocated once they are warm.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct BodyContacts {
    parts: Vec<Part>,
    planes: Vec<Vec4>,
    candidates: Vec<Candidate>,
    /// Those of the frame before: a contact that stays keeps its load, or friction would give way at the start of each frame.
    parts_before: Buffer<Vec<Part>>,
    candidates_before: Buffer<Vec<Candidate>>,
    /// Where candidates of surfaces were when last projected, in the surface's own space `[m]`; infinite: not known.
    places: Vec<Vec3>,
    places_before: Buffer<Vec<Vec3>>,
    squeezes: Squeezes,
    /// Length of the frame `[s]`.
    dt: f32,
    /// How far a particle can get in it by itself `[m]`.
    way: f32,
}

impl BodyContacts {
    /// Number of pairs of a particle and a part of a body that are tested in each substep of this frame.
    #[must_use]
    pub(crate) fn candidates(&self) -> usize {
        self.candidates.len()
    }

    /// Particles that touched a body when last projected, by part of a body.
    pub(crate) fn touching(&self) -> impl Iterator<Item = u32> + '_ {
        self.candidates.iter().filter(|c| c.is_touching()).map(|c| c.particle)
    }

    /// Number of the body, particle and mean push per substep `[m]` of every contact when last projected, by body.
    pub(crate) fn loads(&self) -> impl Iterator<Item = (usize, u32, f32)> + '_ {
        self.parts.iter().flat_map(|part| {
            let candidates = self.candidates.get(part.candidates.0 as usize..part.candidates.1 as usize).unwrap_or(&[]);
            candidates.iter().filter(|c| c.is_touching()).map(|c| (part.body as usize, c.particle, c.load))
        })
    }

    /// Bodies have other numbers now, in the same order, or none.
    pub(crate) fn renumber(&mut self, number: impl Fn(u32) -> Option<u32>) {
        renumber(&mut self.parts, |part| &mut part.body, number);
    }

    /// Whether particles could have met a body in the last frame.
    pub(crate) fn is_near(&self, body: usize) -> bool {
        self.parts.iter().any(|part| part.body as usize == body)
    }

    /// Bound on how far a particle can get in this frame by itself `[m]`, as of the last [`Self::gather`] that had bodies.
    pub(crate) fn way(&self) -> f32 {
        self.way
    }

    #[cfg(test)]
    pub(super) fn capacities(&self) -> [usize; 3] {
        [self.parts.capacity(), self.planes.capacity(), self.candidates.capacity()]
    }

    /// Takes out particles that are pinned to bodies, in ascending order.
    pub(crate) fn leave_out(&mut self, particles: &[u32]) {
        debug_assert!(particles.is_sorted());
        if particles.is_empty() {
            return;
        }
        for candidate in &mut self.candidates {
            if particles.binary_search(&candidate.particle).is_ok() {
                (candidate.left_out, candidate.load) = (true, 0.0);
            }
        }
    }

    /// Takes out the particles that bones go through, and keeps those that their skin holds only as far away as that lets them.
    pub(crate) fn let_through(&mut self, pierced: &Pierced) {
        for held in pierced.held() {
            if let Some(candidate) = self.candidate(held.pair) {
                candidate.inset = candidate.inset.max(held.inset);
            }
        }
        for &pair in pierced.pairs() {
            if let Some(candidate) = self.candidate(pair) {
                (candidate.left_out, candidate.load) = (true, 0.0);
            }
        }
    }

    fn candidate(&mut self, Pair { body, part, particle }: Pair) -> Option<&mut Candidate> {
        let at = self.parts.binary_search_by_key(&(body, part), |part| (part.body, part.index)).ok()?;
        let (first, end) = self.parts[at].candidates;
        let candidates = &mut self.candidates[first as usize..end as usize];
        let at = candidates.binary_search_by_key(&particle, |candidate| candidate.particle).ok()?;
        Some(&mut candidates[at])
    }
}
