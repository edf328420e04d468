//! Evaluate: measure what is about to be shown, and decide what to show instead when it pokes through.
//!
//! Skipping a frame gates presentation only, never time: the physics goes on with its best state.
//!
//! ```text
//!           clean                        still tangled, clean shape known,      bound reached
//!   Live ◄──────── every state           not too often held                 ┌───────────────────┐
//!    │                                 ┌───────────────────────► Held ──────┘                   ▼
//!    └─ tangled ───────────────────────┤                                              Fading ─► Live, tangled
//!                                      └─ no clean shape, or held too often: Live, tangled
//! ```
//!
//! Held particles follow the anchor: `shown = (1 - α w) live + α w · now · then⁻¹ · clean`. `w` is 1 at the tangle and falls to
//! 0 over a few rings. `α` is 1 while held and falls to 0 while fading.

use glam::{Quat, Vec3, Vec4};

use crate::solver::verdict::{Escalation, Verdict};

/// What to do about frames that are still tangled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub enum SkipPolicy {
    /// Hold the tangled part for a few frames at most, then show the best there is.
    #[default]
    Bounded,
    /// As Wen et al. 2009: keep the whole last clean shape until the cloth is clean again, but no longer than `max` frames.
    UntilClean {
        /// Most frames held in a row.
        max: u32,
    },
    /// Always show the live shape.
    Off,
}

/// Tunables of evaluation.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct EvaluateSettings {
    /// What to do about tangled frames.
    pub policy: SkipPolicy,
    /// Most frames held in a row under [`SkipPolicy::Bounded`]. Default 2. More hides longer tangles, but the cloth visibly
    /// sticks.
    pub max_held_frames: u32,
    /// Most time held in any second under [`SkipPolicy::Bounded`] `[s]`. Default 0.1.
    pub max_held_time: f32,
    /// Time over which a held part fades into the live shape when the bound is reached `[s]`. Default 0.1.
    pub fade: f32,
    /// Time tangled after which stronger means are asked for `[s]`. Default 1.
    pub last_resort: f32,
}

impl Default for EvaluateSettings {
    fn default() -> Self {
        Self { policy: SkipPolicy::default(), max_held_frames: 2, max_held_time: 0.1, fade: 0.1, last_resort: 1.0 }
    }
}

/// Pose of the frame a cloth hangs in: its anchor or body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Pose {
    /// Translation `[m]`.
    pub translation: Vec3,
    /// Rotation.
    pub rotation: Quat,
}

impl Pose {
    /// Where a point goes that was fixed to `then` and is fixed to `self` now.
    #[must_use]
    pub fn carry(&self, then: &Self, point: Vec3) -> Vec3 {
        self.rotation * (then.rotation.inverse() * (point - then.translation)) + self.translation
    }
}

/// What a frame shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub enum Shown {
    /// The live shape, clean.
    #[default]
    Clean,
    /// The last clean shape where the cloth is tangled, the live one elsewhere.
    Held,
    /// Between held and live.
    Fading,
    /// The live shape, although it is tangled.
    Tangled,
}

/// The decision for one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Outcome {
    /// What the frame shows.
    pub shown: Shown,
    /// Weight of the held shape, 0 to 1.
    pub hold: f32,
    /// Frames held in a row, this one included.
    pub held_frames: u32,
    /// Time since the cloth was last clean `[s]`.
    pub tangled_for: f32,
    /// The cloth has become tangled with this frame.
    pub became_tangled: bool,
    /// The cloth has become clean with this frame.
    pub became_clean: bool,
    /// Holding has begun with this frame.
    pub became_held: bool,
    /// Tangled for so long that the last resorts should be used.
    pub last_resort: bool,
    /// The last resort has begun with this frame.
    pub became_last_resort: bool,
    /// What to use against the tangle in the next frame.
    pub escalation: Escalation,
}

/// Clean shapes kept.
const SNAPSHOTS: usize = 2;
/// Runs of held frames remembered for the bound per second; a clean frame lies between two.
const LOG: usize = 32;

#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
struct Snapshot {
    positions: Vec<Vec3>,
    pose: Pose,
    time: f64,
}

/// Decides, for one cloth, what each frame shows. Allocates only when the first clean shapes are kept.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Evaluator {
    ring: [Snapshot; SNAPSHOTS],
    newest: usize,
    kept: usize,
    /// `(end, duration)` of runs of held frames `[s]`, a ring.
    log: [(f64, f32); LOG],
    logged: usize,
    time: f64,
    last: Outcome,
    held_frames: u32,
    fading: f32,
    spent: bool,
}

impl Evaluator {
    /// Forgets clean shapes and history; for a cloth that was teleported or rebuilt.
    pub fn reset(&mut self) {
        self.kept = 0;
        self.logged = 0;
        self.log = [(0.0, 0.0); LOG];
        self.last = Outcome::default();
        self.held_frames = 0;
        self.fading = 0.0;
        self.spent = false;
    }

    /// The decision of the last frame.
    #[must_use]
    pub fn outcome(&self) -> Outcome {
        self.last
    }

    /// The last clean shape `[m]` and how long ago it was shown `[s]`.
    #[cfg(feature = "inspector")]
    #[must_use]
    pub(crate) fn clean_shape(&self) -> Option<(&[Vec3], f64)> {
        let snapshot = &self.ring[self.newest];
        (self.kept > 0).then_some((snapshot.positions.as_slice(), self.time - snapshot.time))
    }

    /// Decides one frame of length `dt` `[s]` from the verdict on the shape about to be shown.
    pub fn judge(&mut self, verdict: &Verdict, dt: f32, settings: &EvaluateSettings) -> Outcome {
        self.time += f64::from(dt);
        let before = self.last;
        let mut out = Outcome::default();
        if verdict.is_clean() {
            out.became_clean = before.shown != Shown::Clean;
            self.held_frames = 0;
            self.fading = 0.0;
            self.spent = false;
            self.last = out;
            return out;
        }
        out.became_tangled = before.shown == Shown::Clean;
        out.tangled_for = before.tangled_for + dt;
        out.escalation = Escalation::after(out.tangled_for, settings.last_resort);
        out.last_resort = out.escalation != Escalation::None;
        out.became_last_resort = out.last_resort && !before.last_resort;
        if self.may_hold(dt, settings) {
            self.held_frames += 1;
            // Frames held in a row are one entry, which counts until all of it is a second old.
            if self.held_frames > 1 {
                let (time, held) = &mut self.log[(self.logged + LOG - 1) % LOG];
                (*time, *held) = (self.time, *held + dt);
            } else {
                self.log[self.logged % LOG] = (self.time, dt);
                self.logged += 1;
            }
            self.fading = 1.0;
            out.shown = Shown::Held;
            out.hold = 1.0;
            out.held_frames = self.held_frames;
            out.became_held = self.held_frames == 1;
        } else {
            self.spent = true;
            self.held_frames = 0;
            self.fading -= if settings.fade > 0.0 { dt / settings.fade } else { 1.0 };
            out.hold = self.fading.clamp(0.0, 1.0);
            out.shown = if out.hold > 0.0 { Shown::Fading } else { Shown::Tangled };
        }
        self.last = out;
        out
    }

    fn may_hold(&self, dt: f32, settings: &EvaluateSettings) -> bool {
        if self.kept == 0 || self.spent {
            return false;
        }
        match settings.policy {
            SkipPolicy::Off => false,
            SkipPolicy::UntilClean { max } => self.held_frames < max,
            SkipPolicy::Bounded => {
                let recent = |&&(time, _): &&(f64, f32)| time > self.time - 1.0;
                let held: f32 = self.log[..self.logged.min(LOG)].iter().filter(recent).map(|l| l.1).sum();
                self.held_frames < settings.max_held_frames && held + dt <= settings.max_held_time * (1.0 + 1.0e-5)
            }
        }
    }

    /// Keeps a shape that was judged clean. Call it after [`Self::judge`] on clean frames.
    pub fn keep(&mut self, positions: &[Vec4], pose: Pose) {
        self.newest = (self.newest + 1) % SNAPSHOTS;
        self.kept = (self.kept + 1).min(SNAPSHOTS);
        let snapshot = &mut self.ring[self.newest];
        snapshot.positions.clear();
        snapshot.positions.extend(positions.iter().map(|p| p.truncate()));
        snapshot.pose = pose;
        snapshot.time = self.time;
    }

    /// Moves the last clean shape to where the skin of a character has gone in a frame. `place` tells where particle `i` is
    /// now, which was at `x` `[m]`. Where it does not know, the particle goes along with `pose`. Call it before
    /// [`Self::judge`], in every frame since the shape was kept.
    pub fn follow(&mut self, pose: Pose, place: impl Fn(usize, Vec3) -> Option<Vec3>) {
        let snapshot = &mut self.ring[self.newest];
        for (i, x) in snapshot.positions.iter_mut().enumerate() {
            *x = place(i, *x).unwrap_or_else(|| pose.carry(&snapshot.pose, *x));
        }
        snapshot.pose = pose;
    }

    /// Writes the positions to show `[m]`. `tangled` weighs each particle, 1 at a tangle and 0 away from it;
    /// [`SkipPolicy::UntilClean`] holds the whole cloth instead.
    pub fn present(&self, positions: &[Vec4], tangled: &[f32], pose: Pose, settings: &EvaluateSettings, shown: &mut Vec<Vec3>) {
        shown.clear();
        shown.extend(positions.iter().map(|p| p.truncate()));
        let snapshot = &self.ring[self.newest];
        if self.last.hold <= 0.0 || snapshot.positions.len() != positions.len() {
            return;
        }
        let whole = matches!(settings.policy, SkipPolicy::UntilClean { .. });
        for (i, live) in shown.iter_mut().enumerate() {
            let weight = if whole { 1.0 } else { tangled.get(i).copied().unwrap_or(0.0) };
            if weight > 0.0 {
                let clean = pose.carry(&snapshot.pose, snapshot.positions[i]);
                *live = live.lerp(clean, (self.last.hold * weight).min(1.0));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT: f32 = 1.0 / 60.0;
    const DIRTY: Verdict = Verdict { crossings: 3, contours: 1, contour_length: 0.1, regions: 0, elsewhere: 0 };

    fn run(settings: EvaluateSettings, frames: &[bool]) -> Vec<Shown> {
        let mut evaluator = Evaluator::default();
        frames
            .iter()
            .map(|&clean| {
                let out = evaluator.judge(&if clean { Verdict::default() } else { DIRTY }, DT, &settings);
                if out.shown == Shown::Clean {
                    evaluator.keep(&[Vec4::ZERO; 4], Pose::default());
                }
                out.shown
            })
            .collect()
    }

    #[test]
    fn a_short_tangle_is_held_and_a_long_one_is_shown_in_the_end() {
        let mut frames = vec![true, false, false, true];
        frames.extend([false; 20]);
        let shown = run(EvaluateSettings::default(), &frames);
        assert_eq!(shown[..4], [Shown::Clean, Shown::Held, Shown::Held, Shown::Clean]);
        assert_eq!(shown[4..7], [Shown::Held, Shown::Held, Shown::Fading]);
        assert_eq!(*shown.last().unwrap_or(&Shown::Clean), Shown::Tangled);
    }

    #[test]
    fn held_frames_never_exceed_two_in_a_row_nor_a_tenth_of_any_second() {
        let mut rng = fastrand::Rng::with_seed(3);
        let frames: Vec<bool> = (0..5000).map(|_| rng.f32() < 0.4).collect();
        let shown = run(EvaluateSettings::default(), &frames);
        let held: Vec<bool> = shown.iter().map(|&s| s == Shown::Held).collect();
        assert!(held.windows(3).all(|w| w != [true; 3]), "three held in a row");
        let most = held.windows(60).map(|w| w.iter().filter(|&&h| h).count()).max().unwrap_or(0);
        assert!((1..=6).contains(&most), "{most} of 60 frames held");
    }

    #[test]
    fn without_a_clean_shape_nothing_is_held() {
        let shown = run(EvaluateSettings::default(), &[false; 5]);
        assert_eq!(shown, [Shown::Tangled; 5]);
    }

    #[test]
    fn until_clean_holds_for_its_own_maximum_and_off_never_holds() {
        let frames = [true, false, false, false, false, false];
        let until = EvaluateSettings { policy: SkipPolicy::UntilClean { max: 4 }, ..EvaluateSettings::default() };
        assert_eq!(run(until, &frames).iter().filter(|&&s| s == Shown::Held).count(), 4);
        let off = EvaluateSettings { policy: SkipPolicy::Off, ..EvaluateSettings::default() };
        assert_eq!(run(off, &frames)[1..], [Shown::Tangled; 5]);
    }

    #[test]
    fn stronger_means_follow_each_other_and_the_first_is_announced_once() {
        let mut evaluator = Evaluator::default();
        let settings = EvaluateSettings::default();
        let outcomes: Vec<Outcome> = (0..240).map(|_| evaluator.judge(&DIRTY, DT, &settings)).collect();
        let announced: Vec<usize> = (0..240).filter(|&i| outcomes[i].became_last_resort).collect();
        assert!(announced.len() == 1 && (59..=60).contains(&announced[0]), "announced in frames {announced:?}");
        let escalations = [30, 90, 150, 210].map(|i| outcomes[i].escalation);
        assert_eq!(escalations, [Escalation::None, Escalation::Regions, Escalation::Candidates, Escalation::Blend]);
        assert_eq!(evaluator.judge(&Verdict::default(), DT, &settings).escalation, Escalation::None);
    }

    #[test]
    fn a_held_shape_follows_its_anchor() {
        let mut evaluator = Evaluator::default();
        let settings = EvaluateSettings::default();
        let then = Pose { translation: Vec3::X, rotation: Quat::IDENTITY };
        evaluator.judge(&Verdict::default(), DT, &settings);
        evaluator.keep(&[Vec4::new(2.0, 0.0, 0.0, 1.0); 2], then);
        evaluator.judge(&DIRTY, DT, &settings);
        let now = Pose { translation: Vec3::Y, rotation: Quat::from_rotation_z(core::f32::consts::FRAC_PI_2) };
        let mut shown = Vec::new();
        evaluator.present(&[Vec4::splat(9.0); 2], &[1.0, 0.0], now, &settings, &mut shown);
        assert!(shown[0].abs_diff_eq(Vec3::new(0.0, 2.0, 0.0), 1e-6), "{}", shown[0]);
        assert_eq!(shown[1], Vec3::splat(9.0));
    }
}
