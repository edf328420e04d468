//! A plan is played, and every frame is checked.

use std::time::Instant;

use super::check;
use super::headless::Options;
use super::log::Told;
use super::panics::{self, Panic};
use super::plan::{Plan, Step};
use super::stage::Stage;
use super::watch;
use crate::common::log::Log;

/// What was seen.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Frames.
    pub frames: u64,
    /// Of every position of every frame.
    pub hash: u64,
    /// The longest frame `[s]`.
    pub slowest: f32,
    /// Whether the clock of the machine decided something.
    pub by_clock: bool,
    /// Panics of others that others caught, by their place.
    pub others: Vec<String>,
    /// Frames of single cloths that were simulated.
    pub simulated: u64,
    /// Of these, with crossings.
    pub tangled: u64,
    /// Warnings.
    pub warnings: u64,
}

/// What does not hold.
#[derive(Clone, Debug)]
pub struct Failure {
    /// The same for the same failure.
    pub kind: String,
    /// What it was.
    pub what: String,
    /// In this frame.
    pub frame: u32,
    /// What was done.
    pub told: Vec<String>,
}

impl Failure {
    /// Of a panic.
    pub fn panic(panic: Panic, frame: u32) -> Self {
        Self { kind: format!("panic at {}", panic.place), what: panic.says, frame, told: Vec::new() }
    }

    /// Of something that does not hold.
    pub fn broken((kind, what): check::Broken, frame: u32) -> Self {
        Self { kind, what, frame, told: Vec::new() }
    }
}

/// Plays the steps whose numbers are kept; all, if none is said.
///
/// # Errors
/// The first thing that does not hold.
pub fn play(plan: &Plan, keep: Option<&[usize]>, options: &Options) -> Result<Tally, Failure> {
    let log = Log::default();
    log.listen(|| {
        let mut stage = panics::caught(|| Stage::new(plan, options)).map_err(|panic| Failure::panic(panic, 0))?;
        let mut told = Vec::new();
        let kept = plan.steps.iter().enumerate().filter(|(i, _)| keep.is_none_or(|keep| keep.contains(i)));
        let steps: Vec<(usize, &Step)> = kept.collect();
        let result = frames(&mut stage, plan.frames, &steps, &log, options, &mut told);
        // What is broken may panic again when it is dropped.
        panics::caught(move || drop(stage)).ok();
        result.map_err(|failure| Failure { told, ..failure })
    })
}

fn frames(
    stage: &mut Stage,
    count: u32,
    steps: &[(usize, &Step)],
    log: &Log,
    options: &Options,
    told: &mut Vec<String>,
) -> Result<Tally, Failure> {
    let mut tally = Tally { hash: 0xcbf2_9ce4_8422_2325, ..Tally::default() };
    let mut warned = Told::default();
    let mut next = 0;
    for frame in 0..count {
        while let Some((number, step)) = steps.get(next).filter(|(_, step)| step.frame == frame) {
            next += 1;
            warned.clear();
            let done = panics::caught(|| stage.perform(step)).map_err(|panic| {
                told.push(format!("frame {frame}, {number}: {:?} {}", step.action, step.slot));
                Failure::panic(panic, frame)
            })?;
            told.push(format!("frame {frame}, {number}: {done}"));
        }
        update(stage, frame, options, &mut tally)?;
        let lines = log.read();
        tally.warnings += lines.len() as u64;
        if let Some(line) = warned.again(&lines) {
            let kind: String = line
                .split_once("bevy_drape::")
                .map_or(line, |(_, said)| said)
                .chars()
                .filter(|c| !c.is_ascii_digit())
                .take(60)
                .collect();
            return Err(Failure::broken((format!("warned again: {kind}"), line.to_owned()), frame));
        }
    }
    tally.by_clock = stage.by_clock;
    let left = panics::caught(|| stage.left()).map_err(|panic| Failure::panic(panic, count))?;
    if let Some(left) = left {
        return Err(Failure::broken(("something is left".into(), left), count));
    }
    Ok(tally)
}

/// One frame, and what must hold after it.
///
/// # Errors
/// What does not.
pub fn update(stage: &mut Stage, frame: u32, options: &Options, tally: &mut Tally) -> Result<(), Failure> {
    watch::alive();
    let begin = Instant::now();
    panics::caught(|| stage.app.update()).map_err(|panic| Failure::panic(panic, frame))?;
    let took = begin.elapsed().as_secs_f32();
    tally.frames += 1;
    tally.slowest = tally.slowest.max(took);
    if let Some(broken) = check::after_frame(stage) {
        return Err(Failure::broken(broken, frame));
    }
    check::hash(stage, &mut tally.hash);
    let [simulated, tangled] = check::busy(stage);
    tally.simulated += simulated;
    tally.tangled += tangled;
    let allowed = options.patience.map(|patience| patience + check::work(stage));
    if let Some(allowed) = allowed.filter(|allowed| took > *allowed) {
        let what = format!("{took} s, and {allowed} s are for what was to be done");
        return Err(Failure::broken(("a frame that takes too long".into(), what), frame));
    }
    Ok(())
}
