//! Steps a scene without a window and prints what it cost, one line of JSON.
//!
//! ```text
//! cargo run --release --example stress -- --scene hang --size 64 --json
//! ```
#![expect(clippy::print_stdout, reason = "a program speaks on its terminal")]

use std::process::ExitCode;
use std::time::Instant;

use bevy::tasks::{TaskPool, TaskPoolBuilder};
use bevy_drape::scenes::{self, Scene, SceneCloth};
use bevy_drape::solver::step::FrameInput;
use clap::{Parser, ValueEnum};

#[derive(Clone, Copy, Debug, ValueEnum)]
enum SceneName {
    /// A 1 m sheet pinned at two corners.
    Hang,
    /// A 1 m sheet dropped on a ball of radius 0.3 m.
    Ball,
    /// Flags in a gusty wind; `--cloths` says how many.
    Flags,
}

/// Steps a scene without a window and prints what it cost.
#[derive(Parser)]
struct Arguments {
    /// What to step.
    #[arg(long, value_enum, default_value_t = SceneName::Hang)]
    scene: SceneName,
    /// Vertices along each side of a cloth.
    #[arg(long, default_value_t = 64, value_parser = clap::value_parser!(u32).range(2..=1024))]
    size: u32,
    /// Number of cloths in `flags`.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    cloths: u32,
    /// Frames of 1/60 s that are timed, after a tenth as many to warm up.
    #[arg(long, default_value_t = 600, value_parser = clap::value_parser!(u32).range(1..))]
    frames: u32,
    /// Threads that step cloths.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=256))]
    threads: u32,
    /// Prints one line of JSON instead of a table.
    #[arg(long)]
    json: bool,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let mut scene = match arguments.scene {
        SceneName::Hang => scenes::hang(arguments.size),
        SceneName::Ball => scenes::ball(arguments.size),
        SceneName::Flags => scenes::flags(arguments.cloths, arguments.size),
    };
    // The calling thread works too.
    let pool = (arguments.threads > 1).then(|| TaskPoolBuilder::new().num_threads(arguments.threads as usize - 1).build());
    for _ in 0..arguments.frames / 10 {
        step(&mut scene, pool.as_ref());
    }
    let mut times: Vec<f64> = (0..arguments.frames)
        .map(|_| {
            let start = Instant::now();
            step(&mut scene, pool.as_ref());
            start.elapsed().as_secs_f64() * 1.0e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    print(&arguments, &scene, &times);
    ExitCode::SUCCESS
}

/// One frame of 1/60 s; cloths are dealt to the threads.
fn step(scene: &mut Scene, pool: Option<&TaskPool>) {
    let dt = 1.0 / 60.0;
    let Some(pool) = pool else {
        scene.step(dt);
        return;
    };
    let input = FrameInput { dt, gravity: scene.gravity, bodies: &scene.bodies, wind: &scene.wind };
    let share = scene.cloths.len().div_ceil(4 * (pool.thread_num() + 1));
    pool.scope(|scope| {
        for cloths in scene.cloths.chunks_mut(share) {
            let input = &input;
            scope.spawn(async move { cloths.iter_mut().for_each(|cloth| cloth.step(input)) });
        }
    });
    scene.wind.advance(dt);
}

fn print(arguments: &Arguments, scene: &Scene, times: &[f64]) {
    let percentile = |p: usize| times[(times.len() * p / 100).min(times.len() - 1)];
    let particles: usize = scene.cloths.iter().map(|c| c.state.positions.len()).sum();
    let springs: usize = scene.cloths.iter().map(|c| c.rest.constraints()).sum();
    let substeps = scene.cloths.first().map_or(0, |c| c.report.substeps);
    // Equal cloths share one rest shape.
    let shared = scene.cloths.first().map_or(0, |c| c.rest.bytes());
    let own: usize = scene.cloths.iter().map(|c| c.scratch.bytes() + 32 * c.state.positions.len()).sum();
    let worst = scene.cloths.iter().map(|c| c.report.worst_edge).fold(0.0, f32::max);
    let mean = scene.cloths.iter().map(|c| c.report.mean_edge).fold(0.0, f32::max);
    let lowest = scene.cloths.iter().map(SceneCloth::lowest).fold(f32::INFINITY, f32::min);
    let line = serde_json::json!({
        "scene": format!("{:?}", arguments.scene).to_lowercase(),
        "size": arguments.size,
        "cloths": scene.cloths.len(),
        "threads": arguments.threads,
        "frames": times.len(),
        "particles": particles,
        "springs": springs,
        "substeps": substeps,
        "frame_ms_p50": percentile(50),
        "frame_ms_p95": percentile(95),
        "stage_ms": { "integrate": percentile(50) },
        "crossings": 0,
        "held_frames": 0,
        "bytes_per_particle": (shared + own) / particles.max(1),
        "worst_edge": worst,
        "mean_edge": mean,
        "lowest": lowest,
    });
    if arguments.json {
        println!("{line}");
    } else if let Some(table) = line.as_object() {
        table.iter().for_each(|(name, value)| println!("{name:>20}  {value}"));
    }
}
