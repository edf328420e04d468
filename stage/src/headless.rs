//! Runs an example without a window: steps of 1/60 s, pictures, a report, the end.

use super::{
    picture::{Picture, PictureKind},
    report, shutter,
};
use bevy::{app::PluginsState, ecs::system::SystemId, prelude::*, tasks, time::TimeUpdateStrategy};
use image::RgbImage;
use std::time::{Duration, Instant};

/// What to do without a window.
pub struct Job {
    /// Name of the example.
    pub title: String,
    /// Steps to simulate.
    pub frames: u32,
    /// What to write, if anything can be drawn.
    pub picture: Option<Picture>,
    /// Lines the example adds to the report.
    pub report: Option<SystemId<(), String>>,
    /// The first step waits for this.
    pub ready: Option<SystemId<(), bool>>,
}

/// Time step of the simulation.
const STEP: Duration = Duration::from_nanos(1_000_000_000 / 60);
/// How long the first step waits for what the example loads.
const PATIENCE: Duration = Duration::from_secs(30);
/// An animation has at most this many frames ...
const SHOTS: u32 = 61;
/// ... and at least this many steps between two of them.
const STEPS_PER_SHOT: u32 = 4;

/// The runner of an app without a window.
pub fn run(mut app: App, job: &Job) -> AppExit {
    while app.plugins_state() == PluginsState::Adding {
        tasks::tick_global_task_pools_on_main_thread();
    }
    app.finish();
    app.cleanup();
    advance(&mut app, Duration::ZERO);
    if let Err(line) = wait(&mut app, job) {
        report::complain(&job.title, &line);
        return AppExit::error();
    }
    let every = steps_between_shots(job.frames);
    let mut shots = Vec::new();
    let (mut simulating, mut drawing) = (Duration::ZERO, Duration::ZERO);
    for frame in 0..=job.frames {
        let start = Instant::now();
        if frame > 0 {
            advance(&mut app, STEP);
            simulating += start.elapsed();
        }
        if let Some(exit) = app.should_exit() {
            return exit;
        }
        if wants_shot(job, frame, every) {
            let start = Instant::now();
            match shutter::shoot(&mut app, |app| advance(app, Duration::ZERO)) {
                Ok(shot) => shots.push(shot),
                Err(line) => {
                    report::complain(&job.title, &format!("no picture: {line}"));
                    return AppExit::error();
                }
            }
            drawing += start.elapsed();
        }
    }
    report::say(&job.title, &time_of("simulated", job.frames, simulating));
    if let Some(lines) = job.report.and_then(|system| app.world_mut().run_system(system).ok()) {
        lines.lines().for_each(|line| report::say(&job.title, line));
    }
    match &job.picture {
        Some(picture) => deliver(job, picture, &shots, every, drawing),
        None => AppExit::Success,
    }
}

/// One update of the app.
fn advance(app: &mut App, step: Duration) {
    app.insert_resource(TimeUpdateStrategy::ManualDuration(step));
    app.update();
}

/// Lets assets load, without letting time pass, until the example is ready.
fn wait(app: &mut App, job: &Job) -> Result<(), String> {
    let start = Instant::now();
    while let Some(ready) = job.ready {
        match app.world_mut().run_system(ready) {
            Ok(true) => break,
            Ok(false) if start.elapsed() < PATIENCE => {}
            Ok(false) => return Err("what the scene needs did not load".into()),
            Err(error) => return Err(error.to_string()),
        }
        std::thread::sleep(Duration::from_millis(2));
        advance(app, Duration::ZERO);
    }
    Ok(())
}

/// How many steps an animation goes on between two of its frames.
fn steps_between_shots(frames: u32) -> u32 {
    frames.div_ceil(SHOTS - 1).max(STEPS_PER_SHOT)
}

/// Whether this frame belongs into the picture.
fn wants_shot(job: &Job, frame: u32, every: u32) -> bool {
    match job.picture.as_ref().map(|picture| picture.kind) {
        Some(PictureKind::Png) => frame == job.frames,
        Some(PictureKind::Gif) => frame.is_multiple_of(every),
        None => false,
    }
}

/// Writes the picture and says so.
fn deliver(job: &Job, picture: &Picture, shots: &[RgbImage], every: u32, drawing: Duration) -> AppExit {
    match picture.write(shots, every) {
        Ok(()) => {
            report::say(&job.title, &time_of("drawn", shots.len() as u32, drawing));
            report::say(&job.title, &format!("wrote {}", picture.path.display()));
            AppExit::Success
        }
        Err(line) => {
            report::complain(&job.title, &line);
            AppExit::error()
        }
    }
}

/// A line about how long something took.
fn time_of(what: &str, frames: u32, total: Duration) -> String {
    let each = 1e3 * total.as_secs_f64() / f64::from(frames.max(1));
    format!("{frames} frames {what} in {:.2} s ({each:.2} ms each)", total.as_secs_f64())
}
