//! What to do when a state is no longer physical.
//!
//! ```text
//!  good frame ──> remember it
//!  bad frame  ──> last good state without velocity   (at most 15 in a row)
//!             ──> pose at rest                       (at most 2 in 10 s)
//!             ──> pose at rest, frozen
//! ```
//!
//! Every gate is written as `!(x <= limit)`, so that a number that is not a number does not slip through.

use std::collections::VecDeque;

use glam::{Vec3, Vec4};

use super::state::ClothState;

/// Restores in a row before a reset.
const RESTORES: u32 = 15;
/// Restores after which good frames in between do not help any more, and how many of them one good frame forgives.
const WEARY: f32 = 30.0;
const FORGIVEN: f32 = 0.1;
/// A reset this soon after the ones before counts towards freezing `[s]`.
const WINDOW: f64 = 10.0;
/// Resets within [`WINDOW`] that freeze the cloth.
const RESETS: usize = 3;

/// What a state may not exceed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Limits {
    /// Edge length over rest length (dimensionless). Default 5.
    pub edge_ratio: f32,
    /// Speed of a particle `[m/s]`. Default 1000.
    pub speed: f32,
}

impl Default for Limits {
    fn default() -> Self {
        Self { edge_ratio: 5.0, speed: 1000.0 }
    }
}

/// What is wrong with a state, worst first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub enum Cause {
    /// A position or velocity is not finite.
    NotFinite,
    /// A particle is too fast.
    TooFast,
    /// An edge is too long.
    Overstretched,
}

/// How far a state was taken back, mildest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub enum Level {
    /// To the last good state.
    LastGood,
    /// To the pose at rest.
    Rest,
    /// To the pose at rest, for good.
    Frozen,
}

/// Remembers the last good state and how often it was needed.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Recovery {
    good: Vec<Vec3>,
    /// What [`ClothState::folds`] were with it.
    folds: Vec<Vec4>,
    restores: u32,
    /// Restores, less what good frames since have forgiven.
    weary: f32,
    resets: VecDeque<f64>,
    frozen: bool,
    /// How far [`Self::judge`] took the state back in this frame, and why.
    taken_back: Option<(Level, Cause)>,
}

impl Recovery {
    /// Starts from `state`, which is taken to be good.
    pub fn start(&mut self, state: &ClothState) {
        self.remember(state);
        (self.restores, self.weary) = (0, 0.0);
        self.resets.clear();
        (self.frozen, self.taken_back) = (false, None);
    }

    /// Whether the cloth was stopped.
    #[must_use]
    pub fn is_frozen(&self) -> bool {
        self.frozen
    }

    /// The last good positions `[m]`.
    #[must_use]
    pub fn good(&self) -> &[Vec3] {
        &self.good
    }

    /// Moves the remembered state along when the cloth is carried.
    pub fn carry(&mut self, motion: impl Fn(Vec3) -> Vec3) {
        for x in &mut self.good {
            *x = motion(*x);
        }
    }

    /// How far [`Self::judge`] took the state back in this frame, and why; the last time if twice.
    #[must_use]
    pub fn taken_back(&self) -> Option<(Level, Cause)> {
        self.taken_back
    }

    /// Ends the frame: forgets what [`Self::judge`] did in it.
    pub fn end_frame(&mut self) {
        self.taken_back = None;
    }

    /// Judges a state before or after it was stepped, and takes it back if it is bad. `pose` writes the pose at rest `[m]` into
    /// its argument.
    ///
    /// `worst_edge` is the largest edge length over rest length, as `StepReport` tells it. From a bad state until
    /// [`Self::end_frame`], a good one is neither remembered nor forgives.
    pub fn judge(
        &mut self,
        state: &mut ClothState,
        worst_edge: f32,
        limits: &Limits,
        pose: impl FnOnce(&mut Vec<Vec3>),
    ) -> Option<(Level, Cause)> {
        let Some(cause) = diagnose(state, worst_edge, limits) else {
            if self.taken_back.is_some() {
                // One that was taken back before the step forgives nothing for being good after it.
                return None;
            }
            self.remember(state);
            self.restores = 0;
            self.weary = (self.weary - FORGIVEN).max(0.0);
            return None;
        };
        let level = self.take_back(state, pose);
        self.taken_back = Some((level, cause));
        self.taken_back
    }

    /// Takes a bad state back.
    fn take_back(&mut self, state: &mut ClothState, pose: impl FnOnce(&mut Vec<Vec3>)) -> Level {
        if self.restores < RESTORES && self.weary < WEARY && self.good.len() == state.positions.len() {
            self.restores += 1;
            self.weary += 1.0;
            self.put_back(state);
            return Level::LastGood;
        }
        (self.restores, self.weary) = (0, 0.0);
        self.folds.clear();
        let now = state.time;
        self.resets.retain(|&at| now - at <= WINDOW);
        self.resets.push_back(now);
        pose(&mut self.good);
        self.put_back(state);
        if self.resets.len() < RESETS {
            return Level::Rest;
        }
        self.frozen = true;
        Level::Frozen
    }

    fn remember(&mut self, state: &ClothState) {
        self.good.clear();
        self.good.extend(state.positions.iter().map(|x| x.truncate()));
        self.folds.clone_from(&state.folds);
    }

    fn put_back(&self, state: &mut ClothState) {
        for ((x, old), good) in state.positions.iter_mut().zip(&mut state.previous).zip(&self.good) {
            // `prepare` knows the inverse mass again; until then a bad one holds the particle.
            *x = good.extend(if x.w.is_finite() { x.w } else { 0.0 });
            *old = *x;
        }
        state.folds.clone_from(&self.folds);
    }
}

/// What is wrong with a state, if anything.
#[must_use]
pub(crate) fn diagnose(state: &ClothState, worst_edge: f32, limits: &Limits) -> Option<Cause> {
    // `0 * x` is not a number exactly when x is not finite.
    let sum: Vec4 = state.positions.iter().zip(&state.previous).map(|(x, old)| *x * 0.0 + *old * 0.0).sum();
    if sum != Vec4::ZERO {
        return Some(Cause::NotFinite);
    }
    if state.substep > 0.0 {
        let limit = limits.speed * state.substep;
        let fastest = state
            .positions
            .iter()
            .zip(&state.previous)
            .map(|(x, old)| (*x - *old).truncate().length_squared())
            .fold(0.0, f32::max);
        if !(fastest <= limit * limit) {
            return Some(Cause::TooFast);
        }
    }
    if !(worst_edge <= limits.edge_ratio) {
        return Some(Cause::Overstretched);
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(x: f32) -> ClothState {
        ClothState {
            positions: vec![Vec4::new(x, 0.0, 0.0, 1.0); 4],
            previous: vec![Vec4::new(x, 0.0, 0.0, 1.0); 4],
            substep: 0.01,
            ..ClothState::default()
        }
    }

    fn at_rest(out: &mut Vec<Vec3>) {
        out.clear();
        out.resize(4, Vec3::ZERO);
    }

    #[test]
    fn a_state_that_is_not_a_number_does_not_pass_any_gate() {
        let limits = Limits::default();
        let mut bad = state(1.0);
        bad.positions[2].y = f32::NAN;
        assert_eq!(diagnose(&bad, 1.0, &limits), Some(Cause::NotFinite));
        bad = state(1.0);
        bad.previous[0].x = f32::INFINITY;
        assert_eq!(diagnose(&bad, 1.0, &limits), Some(Cause::NotFinite));
        assert_eq!(diagnose(&state(1.0), f32::NAN, &limits), Some(Cause::Overstretched));
        assert_eq!(diagnose(&state(1.0), 1.0, &Limits { speed: f32::NAN, ..limits }), Some(Cause::TooFast));
        assert_eq!(diagnose(&state(1.0), 1.0, &limits), None);
    }

    #[test]
    fn a_bad_state_is_restored_fifteen_times_then_reset_and_frozen_at_the_third_reset() {
        let mut recovery = Recovery::default();
        let mut now = state(3.0);
        recovery.start(&now);
        let mut levels = Vec::new();
        for _ in 0..48 {
            now.positions[0] = Vec4::NAN;
            now.time += 0.1;
            levels.extend(recovery.judge(&mut now, 1.0, &Limits::default(), at_rest).map(|(level, _)| level));
            recovery.end_frame();
            assert!(now.positions.iter().all(|x| x.truncate().is_finite()), "{:?}", now.positions);
        }
        let count = |level| levels.iter().filter(|l| **l == level).count();
        assert_eq!(levels[..15], [Level::LastGood; 15]);
        assert_eq!((count(Level::Rest), count(Level::Frozen)), (2, 1), "{levels:?}");
        assert!(recovery.is_frozen());
    }

    #[test]
    fn one_good_frame_forgives_restores_in_a_row_but_not_for_ever() {
        let mut recovery = Recovery::default();
        let mut now = state(3.0);
        recovery.start(&now);
        let mut levels = Vec::new();
        for _ in 0..200 {
            now.positions[0] = Vec4::NAN;
            levels.extend(recovery.judge(&mut now, 1.0, &Limits::default(), at_rest).map(|(level, _)| level));
            if recovery.is_frozen() {
                break;
            }
            recovery.end_frame();
            assert_eq!(recovery.judge(&mut now, 1.0, &Limits::default(), at_rest), None);
        }
        assert_eq!(levels[..30], [Level::LastGood; 30]);
        assert_eq!(levels.last(), Some(&Level::Frozen));
    }

    #[test]
    fn a_state_that_was_taken_back_before_the_step_forgives_nothing_after_it() {
        let mut recovery = Recovery::default();
        let mut now = state(3.0);
        recovery.start(&now);
        for _ in 0..RESTORES {
            now.positions[0] = Vec4::NAN;
            assert_eq!(recovery.judge(&mut now, 1.0, &Limits::default(), at_rest), Some((Level::LastGood, Cause::NotFinite)));
            assert_eq!(recovery.judge(&mut now, 1.0, &Limits::default(), at_rest), None);
            recovery.end_frame();
        }
        now.positions[0] = Vec4::NAN;
        assert_eq!(recovery.judge(&mut now, 1.0, &Limits::default(), at_rest), Some((Level::Rest, Cause::NotFinite)));
    }
}
