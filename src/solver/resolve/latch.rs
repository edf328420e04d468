//! What was decided for a contour, kept until that contour dies.
//!
//! Choosing anew every time flips between strategies halfway and never ends. A contour is recognized by the crossings it shares with
//! the time before: an equal pair counts 4, an equal edge 1, the largest sum wins; without any, the nearest centre within reach.

use glam::Vec3;

use crate::solver::detect::Crossing;
use crate::solver::rest::NONE;
use crate::solver::verdict::Resort;

use super::contour::{Contour, ContourGraph, ContourKind};

/// How a contour is being taken apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub enum Strategy {
    /// Summed gradient and exact vertex gradient.
    #[default]
    Shrink,
    /// The region the contour cuts off is pushed back through it.
    Push,
    /// Both sides go apart along the cheapest of a few directions.
    Separate,
    /// Each stretch of the contour follows the gradient summed over its neighbourhood along the curve, not over the whole curve.
    Peel,
}

/// One contour's memory.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Latch {
    /// How the contour ends now.
    pub kind: ContourKind,
    /// The choice.
    pub strategy: Strategy,
    /// Particle inside the region being pushed, [`NONE`] before the first push.
    pub seed: u32,
    /// Side being pushed, 0 or 1; 2 before the first push.
    pub side: u8,
    /// Mean direction of the last motions of side 0, at most of length 1.
    pub heading: Vec3,
    /// Step, as a multiple of the first one.
    pub pace: f32,
    /// Iterations since the contour appeared.
    pub age: u32,
    /// Iterations without progress.
    pub stale: u32,
    /// The means for which the strategy was chosen.
    pub resort: Resort,
    /// How often the strategy was given up.
    pub turns: u32,
    /// Smallest measure of progress so far: length `[m]`, or area of the region that is pushed `[m²]`.
    pub best: f32,
    /// Largest length so far `[m]`.
    pub longest: f32,
    /// Plan being carried out; 0: none yet.
    pub plan: u32,
    /// How far the region that is pushed reached through at most `[m]`.
    pub depth: f32,
    centre: Vec3,
}

impl Latch {
    fn new() -> Self {
        Self { seed: NONE, side: 2, best: f32::INFINITY, pace: 1.0, ..Self::default() }
    }

    /// Notes a measure that should fall.
    pub fn progress(&mut self, measure: f32) {
        self.stale += 1;
        if measure < 0.9 * self.best {
            self.best = measure;
            self.stale = 0;
        }
    }

    /// Takes up another strategy.
    pub fn turn_to(&mut self, strategy: Strategy) {
        let Self { age, longest, centre, resort, .. } = *self;
        *self = Self { strategy, turns: self.turns + 1, age, longest, centre, resort, ..Self::new() };
    }

    /// Smooths the direction of motion, and adapts the step to how steady it is: longer while the direction stays, shorter when it turns.
    /// Returns the motion as a multiple of the first step.
    pub fn steer(&mut self, direction: Vec3, fastest: f32, inertia: f32) -> Vec3 {
        let turn = direction.normalize_or_zero().dot(self.heading.normalize_or_zero());
        if turn > 0.7 {
            self.pace = (self.pace * GROWTH).min(fastest);
        } else if turn < 0.0 {
            self.pace = (self.pace / GROWTH).max(1.0);
        }
        let keep = if self.heading == Vec3::ZERO { 0.0 } else { inertia };
        self.heading = self.heading * keep + direction * (1.0 - keep);
        self.heading * self.pace
    }
}

/// Growth of the step per iteration in one direction.
const GROWTH: f32 = 1.15;
/// How far a contour can have gone when it is recognized by its centre alone, in edges.
const REACH: f32 = 2.0;
/// How much of the former direction a shrinking contour keeps. Without it, contours that leave sideways over a border swing from side
/// to side for ever.
pub const INERTIA: f32 = 0.8;

/// Memories of all contours, in their order.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Latches {
    /// Parallel to [`ContourGraph::contours`].
    pub now: Vec<Latch>,
    before: Vec<Latch>,
    /// Sorted `(edge, face, contour, side)` of the time before.
    keys: Vec<(u32, u32, u32, u8)>,
    /// `(contour, contour before, weight, weight of equal sides)`
    votes: Vec<(u32, u32, i32, i32)>,
}

impl Latches {
    /// Forgets everything.
    pub fn clear(&mut self) {
        self.now.clear();
        self.keys.clear();
    }

    /// Carries memories over to the contours found now. `fresh` decides for a contour that is new.
    pub fn carry(&mut self, crossings: &[Crossing], graph: &ContourGraph, fresh: impl Fn(usize) -> Strategy) {
        core::mem::swap(&mut self.now, &mut self.before);
        self.vote(crossings, graph);
        self.now.clear();
        let mut votes = self.votes.iter().copied().peekable();
        for (k, contour) in graph.contours.iter().enumerate() {
            let mut best = (0, NONE, 0);
            while let Some((new, old, mut sum, mut same)) = votes.next_if(|v| v.0 == k as u32) {
                while let Some(more) = votes.next_if(|v| v.0 == new && v.1 == old) {
                    sum += more.2;
                    same += more.3;
                }
                if sum > best.0 {
                    best = (sum, old, same);
                }
            }
            let mut old = self.before.get(best.1 as usize).copied().or_else(|| self.nearest(contour));
            if let Some(old) = &mut old
                && 2 * best.2 < best.0
            {
                if old.strategy != Strategy::Push {
                    old.heading = -old.heading;
                }
                if old.side < 2 {
                    old.side = 1 - old.side;
                }
            }
            let mut latch = old.unwrap_or_else(|| Latch { strategy: fresh(k), ..Latch::new() });
            latch.age += 1;
            if !matches!(latch.strategy, Strategy::Push | Strategy::Separate) {
                latch.progress(contour.length);
            }
            latch.longest = latch.longest.max(contour.length);
            latch.centre = contour.centre;
            latch.kind = contour.kind;
            self.now.push(latch);
        }
        self.keys.clear();
        let sides = graph.contour_of.iter().zip(&graph.side);
        self.keys.extend(crossings.iter().zip(sides).map(|(c, (&k, &side))| (c.edge, c.face, k, side)));
    }

    /// Joins two lists sorted by edge.
    fn vote(&mut self, crossings: &[Crossing], graph: &ContourGraph) {
        self.votes.clear();
        let mut low = 0;
        for ((c, &contour), &side) in crossings.iter().zip(&graph.contour_of).zip(&graph.side) {
            while self.keys.get(low).is_some_and(|k| k.0 < c.edge) {
                low += 1;
            }
            for key in self.keys[low..].iter().take_while(|k| k.0 == c.edge) {
                let weight = if key.1 == c.face { 4 } else { 1 };
                self.votes.push((contour, key.2, weight, if key.3 == side { weight } else { 0 }));
            }
        }
        self.votes.sort_unstable();
    }

    fn nearest(&self, contour: &Contour) -> Option<Latch> {
        let reach = REACH * contour.edge;
        let distance = |l: &Latch| l.centre.distance_squared(contour.centre);
        let best = self.before.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        (distance(best) < reach * reach).then_some(*best)
    }
}
