//! What was decided for a contour, kept until that contour dies.
//!
//! Choosing anew every time flips between strategies halfway and never ends. A contour is recognized by the crossings it shares
//! with the time before, as these vote (`votes`); without any, the nearest centre within reach.

use glam::Vec3;

use crate::solver::detect::Crossing;
use crate::solver::rigid::Rigid;
use crate::solver::topology::NONE;
use crate::solver::verdict::Escalation;

use super::contour::{ContourGraph, ContourKind};
use super::nearest::Nearest;
use super::votes::Votes;

/// How a contour is being taken apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub enum Strategy {
    /// Summed gradient and exact vertex gradient.
    #[default]
    GlobalGradient,
    /// The region the contour cuts off is pushed back through it.
    RegionPush,
    /// Both sides go apart along the cheapest of a few directions.
    Translate,
    /// Each stretch of the contour follows the gradient summed over its neighbourhood along the curve, not over the whole
    /// curve.
    StretchGradient,
}

/// One contour's memory.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct TrackedContour {
    /// How the contour ends now.
    pub kind: ContourKind,
    /// The choice.
    pub strategy: Strategy,
    /// Particle inside the region being pushed, [`NONE`] before the first push.
    pub seed: u32,
    /// Side being pushed, 0 or 1; 2 before the first push.
    pub side: u8,
    /// Mean direction of the last motions of side 0, at most of length 1.
    pub mean_direction: Vec3,
    /// Step, as a multiple of the first one.
    pub step_scale: f32,
    /// Iterations since the contour appeared.
    pub age: u32,
    /// Iterations without progress.
    pub stalled: u32,
    /// The means for which the strategy was chosen.
    pub escalation: Escalation,
    /// How often the strategy was given up.
    pub switches: u32,
    /// Smallest measure of progress so far: length `[m]`, or area of the region that is pushed `[m²]`.
    pub best: f32,
    /// Largest length so far `[m]`.
    pub longest: f32,
    /// Whether nothing was done about it in the last iteration, since there was too much work for a frame.
    pub waits: bool,
    /// Plan being carried out; 0: none yet.
    pub plan: u32,
    /// How far the region that is pushed reached through at most `[m]`.
    pub depth: f32,
    centre: Vec3,
}

/// Share of the least measure so far below which there is progress (dimensionless).
const PROGRESS: f32 = 0.9;

/// Cosine of the angle between two directions up to which a contour keeps its course (dimensionless): 45°.
const STEADY: f32 = 0.7;

impl TrackedContour {
    fn new() -> Self {
        Self { seed: NONE, side: 2, best: f32::INFINITY, step_scale: 1.0, ..Self::default() }
    }

    /// Notes a measure that should fall.
    pub(crate) fn progress(&mut self, measure: f32) {
        self.stalled += 1;
        if measure < PROGRESS * self.best {
            self.best = measure;
            self.stalled = 0;
        }
    }

    /// Takes up another strategy.
    pub(crate) fn switch_to(&mut self, strategy: Strategy) {
        let Self { kind, age, longest, centre, escalation, .. } = *self;
        *self = Self { strategy, switches: self.switches + 1, kind, age, longest, centre, escalation, ..Self::new() };
    }

    /// Smooths the direction of motion, and adapts the step to how steady it is: longer while the direction stays, shorter when
    /// it turns. Returns the motion as a multiple of the first step.
    pub(crate) fn steer(&mut self, direction: Vec3, fastest: f32, inertia: f32) -> Vec3 {
        let turn = direction.normalize_or_zero().dot(self.mean_direction.normalize_or_zero());
        if turn > STEADY {
            self.step_scale = (self.step_scale * GROWTH).min(fastest);
        } else if turn < 0.0 {
            self.step_scale = (self.step_scale / GROWTH).max(1.0);
        }
        let keep = if self.mean_direction == Vec3::ZERO { 0.0 } else { inertia };
        self.mean_direction = self.mean_direction * keep + direction * (1.0 - keep);
        self.mean_direction * self.step_scale
    }
}

/// Growth of the step per iteration in one direction.
const GROWTH: f32 = 1.15;
/// How far a contour can have gone when it is recognized by its centre alone, in edges.
const REACH: f32 = 2.0;
/// How much of the former direction a shrinking contour keeps. Without it, contours that leave sideways over a border swing
/// from side to side for ever.
pub(crate) const INERTIA: f32 = 0.8;

/// Memories of all contours, in their order.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct TrackedContours {
    /// Parallel to [`ContourGraph::contours`].
    pub now: Vec<TrackedContour>,
    before: Vec<TrackedContour>,
    votes: Votes,
    /// Centres of contours of the time before.
    nearest: Nearest,
}

impl TrackedContours {
    /// Forgets everything.
    pub(crate) fn clear(&mut self) {
        self.now.clear();
        self.votes.clear();
    }

    /// All cloths were carried as one.
    pub(crate) fn follow(&mut self, motion: &Rigid) {
        for contour in &mut self.now {
            contour.mean_direction = motion.turn * contour.mean_direction;
            contour.centre = motion.point(contour.centre);
        }
    }

    /// Carries memories over to the contours found now. `fresh` decides for a contour that is new.
    pub(crate) fn carry(&mut self, crossings: &[Crossing], graph: &ContourGraph, fresh: impl Fn(usize) -> Strategy) {
        core::mem::swap(&mut self.now, &mut self.before);
        self.now.clear();
        self.nearest.take_in(self.before.iter().map(|l| l.centre));
        let mut votes = self.votes.cast(crossings, graph).iter().peekable();
        for (k, contour) in graph.contours.iter().enumerate() {
            let mut best = (0, NONE, 0);
            while let Some(vote) = votes.next_if(|v| v.contour == k as u32) {
                let (mut sum, mut same) = (vote.weight, vote.same);
                while let Some(more) = votes.next_if(|v| v.contour == vote.contour && v.before == vote.before) {
                    sum += more.weight;
                    same += more.same;
                }
                if sum > best.0 {
                    best = (sum, vote.before, same);
                }
            }
            let nearest = &mut self.nearest;
            let before = if best.1 == NONE { nearest.find(contour.centre, REACH * contour.edge) } else { Some(best.1) };
            let mut old = before.and_then(|i| self.before.get(i as usize)).copied();
            if let Some(old) = &mut old
                && 2 * best.2 < best.0
            {
                if old.strategy != Strategy::RegionPush {
                    old.mean_direction = -old.mean_direction;
                }
                if old.side < 2 {
                    old.side = 1 - old.side;
                }
            }
            let mut tracked = old.unwrap_or_else(|| TrackedContour { strategy: fresh(k), ..TrackedContour::new() });
            tracked.age += 1;
            if !matches!(tracked.strategy, Strategy::RegionPush | Strategy::Translate) && !tracked.waits {
                tracked.progress(contour.length);
            }
            tracked.waits = false;
            tracked.longest = tracked.longest.max(contour.length);
            tracked.centre = contour.centre;
            tracked.kind = contour.kind;
            self.now.push(tracked);
        }
        self.votes.take_in(crossings, graph);
    }
}
