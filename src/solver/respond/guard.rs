//! No pair of a clean start passes through itself in a substep.
//!
//! ```text
//!   d0    separation along n at the start > 0        n: from the closest points of the start, which every plane between two convex sets has
//!   d1    separation along n at the end              d1 > 0: apart all the way, since both move on straight lines
//!   else  x1 ─► x0 + u + α (x1 - x0 - u)             u: mean motion of the pair by mass, α: the largest share that keeps them apart
//! ```
//!
//! Dividing planes as in the trust regions of Offset Geometric Contact (Chen et al. 2025), asked only of pairs that would pass. Keeping `u` conserves momentum and lets
//! a pile fall as fast as it likes; what is cut off is lost as in a plastic impact. Pairs share particles, so passes are repeated until none is left; the last ones
//! keep no `u` and only ever shorten ways, which ends. What is held can not be cut: between two that are held, cloth has nowhere to go.

use glam::{Vec3, Vec4};

use super::Contacts;
use super::contact::Contact;
use crate::solver::detect::ProximityKind;
use crate::solver::detect::proximity::{closest_edges, vertex_face};

/// Passes in which pairs keep their mean motion, and all passes.
const SHARED_PASSES: u8 = 6;
const MOST_PASSES: u8 = 12;

/// Share of the distance at the start that is kept, at least.
const KEPT: f32 = 0.2;

impl Contacts {
    /// Shortens the motion of pairs that would pass through each other; after [`Self::solve`].
    pub fn guard(&mut self) {
        let Self { pairs, start, now, cut, .. } = self;
        cut.clear();
        cut.resize(now.len(), 0);
        for pass in 1..=MOST_PASSES {
            let mut any = false;
            for pair in &*pairs {
                // Only what was moved since it was asked can have changed its mind.
                if pass == 1 || pair.slots.iter().any(|&s| cut[s as usize] + 1 >= pass) {
                    any |= pair.guard(start, now, cut, pass);
                }
            }
            if !any {
                // Nothing went through.
                pairs.iter_mut().for_each(|pair| pair.behind &= pair.was_behind);
                return;
            }
        }
    }
}

impl Contact {
    /// Whether something had to be shortened.
    #[inline]
    fn guard(&self, start: &[Vec4], now: &mut [Vec4], cut: &mut [u8], pass: u8) -> bool {
        if self.was_behind {
            return false;
        }
        let from = self.slots.map(|s| start[s as usize].truncate());
        let to = self.slots.map(|s| now[s as usize]);
        let split = if self.kind == ProximityKind::VertexFace { 1 } else { 2 };
        let apart = |n: Vec3| separation(n, &from, split) > 0.0 && separation(n, &to.map(Vec4::truncate), split) > 0.0;
        !apart(self.normal) && self.shorten(&from, &to, split, now, cut, pass)
    }

    #[cold]
    fn shorten(&self, from: &[Vec3; 4], to: &[Vec4; 4], split: usize, now: &mut [Vec4], cut: &mut [u8], pass: u8) -> bool {
        let near = match self.kind {
            ProximityKind::VertexFace => vertex_face([0, 1, 2, 3], |i| from[i as usize]),
            ProximityKind::EdgeEdge => closest_edges([0, 1, 2, 3], |i| from[i as usize]),
        };
        let delta: Vec3 = (0..4).map(|i| from[i] * near.weights[i]).sum();
        let n = delta / near.distance;
        let gap = separation(n, from, split);
        // What is not apart at the start, to the last digit, is none of this.
        if !(gap > 0.0) || separation(n, &to.map(Vec4::truncate), split) > 0.0 {
            return false;
        }
        let motion: [Vec3; 4] = std::array::from_fn(|i| to[i].truncate() - from[i]);
        let mean = if pass <= SHARED_PASSES { mean_motion(&motion, to) } else { Vec3::ZERO };
        let way: [f32; 4] = std::array::from_fn(|i| n.dot(motion[i] - mean));
        // The gap is shared out by how fast each side closes it.
        let closing = |i: usize| if i < split { -way[i] } else { way[i] };
        let first = (0..split).map(closing).fold(0.0, f32::max);
        let second = (split..4).map(closing).fold(0.0, f32::max);
        if !(first + second > 0.0) {
            return false;
        }
        let share = (1.0 - KEPT) * gap / (first + second);
        let mut any = false;
        for (i, &slot) in self.slots.iter().enumerate() {
            if to[i].w > 0.0 && share < 1.0 {
                let end = from[i] + mean + (motion[i] - mean) * share;
                if end != to[i].truncate() {
                    now[slot as usize] = end.extend(to[i].w);
                    cut[slot as usize] = pass;
                    any = true;
                }
            }
        }
        any
    }
}

/// Mean motion by mass [m]; of what is held if something is.
fn mean_motion(motion: &[Vec3; 4], to: &[Vec4; 4]) -> Vec3 {
    let held = to.iter().any(|x| x.w <= 0.0);
    let mass = |x: &Vec4| if held { f32::from(x.w <= 0.0) } else { 1.0 / x.w };
    let (mut sum, mut total) = (Vec3::ZERO, 0.0);
    for (motion, x) in motion.iter().zip(to) {
        sum += *motion * mass(x);
        total += mass(x);
    }
    sum / total
}

/// How far the first primitive lies beyond the second along `n` [m].
#[inline]
fn separation(n: Vec3, points: &[Vec3; 4], split: usize) -> f32 {
    let along = points.map(|p| n.dot(p));
    let low = along[..split].iter().copied().fold(f32::INFINITY, f32::min);
    low - along[split..].iter().copied().fold(f32::NEG_INFINITY, f32::max)
}
