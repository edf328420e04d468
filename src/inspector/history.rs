//! What one cloth did in the last ten seconds, a sample for every sixtieth: a ring, filled without allocating.

use crate::components::{ClothReport, ClothSkipFrame, ClothSkipPolicy};
use crate::simulation::ClothParticles;
use crate::solver::evaluate::Shown;
use crate::solver::state::ClothState;

/// Time that is kept `[s]`.
pub const SPAN: f64 = 10.0;
/// Samples per second at most; faster frames are merged, the worst of them stays `[Hz]`.
const RATE: f64 = 60.0;
/// A frame joins the last sample within this share of the time for one (dimensionless). It is a little less than all, so that
/// frames of just that length are never merged.
const MERGES: f64 = 0.9;
/// Samples that are kept: the span is full at every frame rate.
const KEPT: usize = (SPAN * RATE / MERGES) as usize + 1;

/// The stages whose times are kept, in the order of [`Sample::stages`].
pub const STAGES: [&str; 6] = ["integrate", "detect", "resolve", "evaluate", "respond", "sync"];

/// What a frame showed, and why.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Verdict {
    /// The live shape: nothing crosses.
    #[default]
    Clean,
    /// The last clean shape where it is tangled.
    Held,
    /// From the held shape into the live one: it was held for as long as allowed.
    Fading,
    /// The live shape although it crosses: it was held for as long as allowed.
    Spent,
    /// The live shape although it crosses: it never was clean, or started anew.
    NeverClean,
    /// The live shape although it crosses: holding is switched off.
    NotAsked,
}

impl Verdict {
    /// A sentence for the user.
    #[must_use]
    pub const fn why(self) -> &'static str {
        match self {
            Self::Clean => "live: nothing crosses",
            Self::Held => "held: the last clean shape is shown where it crosses",
            Self::Fading => "fading: it was held for as long as ClothSkipFrame allows",
            Self::Spent => "crossing is shown: it was held for as long as ClothSkipFrame allows",
            Self::NeverClean => "crossing is shown: there is no clean shape to hold",
            Self::NotAsked => "crossing is shown: ClothSkipFrame is off",
        }
    }

    fn of(particles: &ClothParticles, skip: &ClothSkipFrame) -> Self {
        let never = particles.sim.display.clean_shape().is_none();
        let idle = match skip.policy {
            ClothSkipPolicy::Off => true,
            ClothSkipPolicy::UntilClean { max } => max == 0,
            ClothSkipPolicy::Bounded => skip.max_held_frames == 0 || skip.max_held_time <= 0.0,
        };
        match particles.sim.display.outcome().shown {
            Shown::Clean => Self::Clean,
            Shown::Held => Self::Held,
            Shown::Fading => Self::Fading,
            Shown::Tangled if idle => Self::NotAsked,
            Shown::Tangled if never => Self::NeverClean,
            Shown::Tangled => Self::Spent,
        }
    }
}

/// A frame, or the worst of several that were faster than the samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Time of the clock of the cloth at its end `[s]`.
    pub time: f64,
    /// Time spent on each of the [`STAGES`] `[ms]`.
    pub stages: [f32; STAGES.len()],
    /// Edges that cross faces.
    pub crossings: u32,
    /// Length of all intersection curves `[m]`.
    pub contour_length: f32,
    /// Longest edge over its rest length (dimensionless).
    pub worst_edge: f32,
    /// Mean edge over its rest length (dimensionless).
    pub mean_edge: f32,
    /// Kinetic energy of the particles that are not pinned `[J]`.
    pub kinetic: f32,
    /// What was shown.
    pub verdict: Verdict,
    /// Frames held in a row.
    pub held_frames: u32,
}

impl Sample {
    /// What a cloth did in the frame that ended at `time` `[s]`.
    pub(crate) fn of(time: f64, report: &ClothReport, particles: &ClothParticles, skip: &ClothSkipFrame) -> Self {
        Self {
            time,
            stages: [
                report.integrate_ms,
                report.detect_ms,
                report.resolve_ms,
                report.evaluate_ms,
                report.respond_ms,
                report.sync_ms,
            ],
            crossings: report.crossings,
            contour_length: report.contour_length,
            worst_edge: report.worst_edge,
            mean_edge: report.mean_edge,
            kinetic: kinetic_energy(&particles.sim.state),
            verdict: Verdict::of(particles, skip),
            held_frames: report.held_frames,
        }
    }

    /// The worst of two.
    fn merge(&mut self, other: &Self) {
        for (a, b) in self.stages.iter_mut().zip(other.stages) {
            *a = a.max(b);
        }
        self.crossings = self.crossings.max(other.crossings);
        self.contour_length = self.contour_length.max(other.contour_length);
        self.worst_edge = self.worst_edge.max(other.worst_edge);
        self.mean_edge = self.mean_edge.max(other.mean_edge);
        self.kinetic = self.kinetic.max(other.kinetic);
        self.verdict = self.verdict.max(other.verdict);
        self.held_frames = self.held_frames.max(other.held_frames);
    }
}

/// `½ Σ m v²` over the particles that are not pinned `[J]`.
fn kinetic_energy(state: &ClothState) -> f32 {
    if !(state.substep > 0.0) {
        return 0.0;
    }
    let of = |(x, old): (&bevy::math::Vec4, &bevy::math::Vec4)| {
        if x.w > 0.0 { (x.truncate() - old.truncate()).length_squared() / x.w } else { 0.0 }
    };
    let sum: f32 = state.positions.iter().zip(&state.previous).map(of).sum();
    0.5 * sum / (state.substep * state.substep)
}

/// The samples of one cloth, oldest first.
#[derive(Clone, Debug, Default)]
pub struct History {
    ring: Vec<Sample>,
    /// Place of the oldest, once the ring is full.
    oldest: usize,
    /// Start of the newest sample `[s]`.
    since: f64,
}

impl History {
    /// Forgets everything, and keeps the allocation.
    pub fn clear(&mut self) {
        self.ring.clear();
        self.oldest = 0;
    }

    /// Adds a frame. Allocates only in the first.
    pub fn record(&mut self, sample: Sample) {
        // A clock that was set back starts anew.
        if self.newest().is_some_and(|newest| sample.time < newest.time) {
            self.clear();
        }
        self.ring.reserve_exact(KEPT - self.ring.len());
        if self.ring.is_empty() || sample.time - self.since > MERGES / RATE {
            self.since = sample.time;
            if self.ring.len() < KEPT {
                self.ring.push(sample);
            } else {
                self.ring[self.oldest] = sample;
                self.oldest = (self.oldest + 1) % KEPT;
            }
        } else if let Some(newest) = self.newest_mut() {
            newest.merge(&sample);
            newest.time = sample.time;
        }
    }

    fn newest_place(&self) -> Option<usize> {
        (self.oldest + self.ring.len()).checked_sub(1).filter(|_| !self.ring.is_empty()).map(|i| i % self.ring.len())
    }

    fn newest_mut(&mut self) -> Option<&mut Sample> {
        let place = self.newest_place()?;
        self.ring.get_mut(place)
    }

    /// The last sample.
    #[must_use]
    pub fn newest(&self) -> Option<&Sample> {
        self.ring.get(self.newest_place()?)
    }

    /// All samples of the last [`SPAN`], oldest first.
    pub fn samples(&self) -> impl Iterator<Item = &Sample> {
        let (late, early) = self.ring.split_at(self.oldest.min(self.ring.len()));
        let from = self.newest().map_or(0.0, |newest| newest.time - SPAN);
        early.iter().chain(late).filter(move |sample| sample.time >= from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(time: f64, crossings: u32) -> Sample {
        Sample { time, crossings, ..Sample::default() }
    }

    #[test]
    fn the_last_ten_seconds_are_kept_in_order() {
        let mut history = History::default();
        for frame in 0..2000 {
            history.record(at(f64::from(frame) / 60.0, frame));
        }
        let kept: Vec<u32> = history.samples().map(|s| s.crossings).collect();
        assert_eq!((kept.len(), kept.first(), kept.last()), (600, Some(&1400), Some(&1999)));
        assert!(kept.is_sorted(), "{kept:?}");
    }

    #[test]
    fn frames_faster_than_the_samples_are_merged_and_the_worst_stays() {
        let mut history = History::default();
        for frame in 0..480 {
            history.record(at(f64::from(frame) / 240.0, u32::from(frame % 4 == 2)));
        }
        let n = history.samples().count();
        assert!((100..=140).contains(&n), "{n} samples for two seconds");
        let worst = history.samples().filter(|s| s.crossings == 1).count();
        assert!(worst + 2 >= n, "{worst} of {n} kept the worst of their frames");
    }

    #[test]
    fn the_kinetic_energy_is_that_of_the_free_particles() {
        use bevy::math::Vec4;
        let positions = vec![Vec4::new(0.1, 0.0, 0.0, 0.5), Vec4::new(0.0, 0.2, 0.0, 0.0)];
        let state = ClothState { previous: vec![Vec4::ZERO; 2], positions, substep: 0.1, ..ClothState::default() };
        // 2 kg at 1 m/s; the other is pinned.
        let energy = kinetic_energy(&state);
        assert!((energy - 1.0).abs() < 1.0e-6, "{energy} J");
    }
}
