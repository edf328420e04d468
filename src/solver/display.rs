//! What one cloth shows.

use glam::Vec3;

use super::evaluate::{EvaluateSettings, Evaluator, Outcome, Pose, Shown};
use super::state::ClothState;
use super::verdict::Verdict;

/// What one cloth shows, and what it showed before.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Display {
    evaluator: Evaluator,
    decided: bool,
    /// Positions to show `[m]`; empty while the live ones are shown.
    shown: Vec<Vec3>,
}

impl Display {
    /// Forgets clean shapes and history; for a cloth that starts anew.
    pub fn reset(&mut self) {
        self.evaluator.reset();
        self.shown.clear();
    }

    /// Decides a frame of `dt` `[s]` from the verdict on one cloth. `weights` says how much each particle belongs to a tangle,
    /// `pose` where what carries the cloth is.
    pub fn decide(
        &mut self,
        verdict: &Verdict,
        state: &ClothState,
        weights: &[f32],
        pose: Pose,
        dt: f32,
        settings: &EvaluateSettings,
    ) -> Outcome {
        let outcome = self.evaluator.judge(verdict, dt, settings);
        self.decided = true;
        self.shown.clear();
        if outcome.shown == Shown::Clean {
            self.evaluator.keep(&state.positions, pose);
        } else if outcome.hold > 0.0 {
            self.evaluator.present(&state.positions, weights, pose, settings, &mut self.shown);
        }
        outcome
    }

    /// Moves the last clean shape along with the skin of a character: see [`Evaluator::follow`].
    pub fn follow(&mut self, pose: Pose, place: impl Fn(usize, Vec3) -> Option<Vec3>) {
        self.evaluator.follow(pose, place);
    }

    /// Whether no frame was decided yet.
    #[must_use]
    pub(crate) fn is_new(&self) -> bool {
        !self.decided
    }

    /// The decision of the last frame.
    #[must_use]
    pub fn outcome(&self) -> Outcome {
        self.evaluator.outcome()
    }

    /// Positions to show `[m]` instead of the live ones, while the cloth is held or fades.
    #[must_use]
    pub fn held(&self) -> Option<&[Vec3]> {
        (!self.shown.is_empty()).then_some(self.shown.as_slice())
    }

    /// The last clean shape `[m]`, in the place where it was.
    #[cfg(feature = "inspector")]
    #[must_use]
    pub(crate) fn clean_shape(&self) -> Option<&[Vec3]> {
        self.evaluator.clean_shape().map(|(shape, _)| shape)
    }

    /// Moves what is shown.
    pub fn carry(&mut self, motion: impl Fn(Vec3) -> Vec3) {
        for x in &mut self.shown {
            *x = motion(*x);
        }
    }
}
