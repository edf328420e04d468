//! Steps a scene without a window and prints what it cost, one line of JSON.
//!
//! ```text
//! cargo run --release --example stress -- --scene hang --size 64 --json
//! ```
//!
//! Where cloths can meet, crossings are looked for in every frame, between cloths and with `--self-collision` in each; elsewhere once at
//! the end, untimed, of everything with everything, and what would have needed a look at every frame is null.
//!
//! That is what the detector says of the shapes that are simulated. `--check` counts what every frame *shows*, with code that shares
//! nothing with the detector:
//!
//! ```text
//! for seed in $(seq 10); do
//!     cargo run --release --example stress -- --scene twist --size 28 --seed $seed --check --json
//! done
//! ```
//!
//! `--replay` steps a frame again that `ClothRecorderPlugin` wrote, and prints whether it had the same bits.
#![expect(clippy::print_stdout, reason = "a program speaks on its terminal")]

#[path = "../tests/detection/checker.rs"]
mod checker;
mod cli;
#[path = "../tests/scenes/shown.rs"]
mod shown;

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use bevy::tasks::{TaskPool, TaskPoolBuilder};
use bevy_drape::solver::evaluate::EvaluateSettings;
use bevy_drape::solver::island::UntangleSettings;
use bevy_drape::solver::recording::{Recording, RecordingError};
use bevy_drape::solver::resolve::{Method, ResolveSettings};
use bevy_drape::solver::step::FrameInput;
use clap::{Parser, ValueEnum};
use drape_scenes::{self as scenes, Scene, SceneCloth, StageTimes, Tangle};
use shown::Picture;

#[derive(Clone, Copy, Debug, ValueEnum)]
enum SceneName {
    /// A 1 m sheet pinned at two corners.
    Hang,
    /// A 1 m sheet dropped on a ball of radius 0.3 m.
    Ball,
    /// Flags in a gusty wind; `--cloths` says how many.
    Flags,
    /// Two 1 m sheets dropped crosswise on each other over a ball.
    Sheets,
    /// A stack of sheets dropped on a ball, each turned against the one below; `--cloths` says how many.
    Layers,
    /// A stack of sheets dropped on a ball, one above the other; `--cloths` says how many [default: 10].
    Stack,
    /// Two strips that fall crosswise on each other.
    Crosswise,
    /// A strip whose ends are turned against each other.
    Twist,
    /// A sheet that falls through a funnel.
    Funnel,
    /// A curtain into which a ball swings.
    Curtain,
    /// A skirt on a body that walks.
    Skirt,
    /// A corner pinched between two balls.
    Pinch,
    /// A sheet dropped on twenty needles.
    Needles,
    /// A skirt on a body that spins; `--garment` puts another one on it.
    Spin,
    /// Two sheets tangled: a shallow dent.
    Dent,
    /// A deep dent.
    DeepDent,
    /// A corner through the middle.
    Corner,
    /// Two sheets that overlap at their borders.
    BorderOverlap,
    /// A strip stabbed through a sheet.
    StripStab,
    /// The same at an angle.
    TiltedStrip,
    /// A sheet that cuts another in two.
    FullCut,
    /// Two wavy sheets.
    Waves,
}

/// How crossing cloths are taken apart; none: nothing is looked for.
#[derive(Clone, Copy, Debug)]
struct MethodChoice(Option<Method>);

fn method_choice(text: &str) -> Result<MethodChoice, String> {
    if text == "none" {
        return Ok(MethodChoice(None));
    }
    let known = cli::method(text).map(|method| MethodChoice(Some(method.into())));
    known.map_err(|line| line.replace(" or ", ", ") + " or none")
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
    /// Number of cloths in `hang`, `flags`, `layers` and `stack` [default: 1; stack: 10].
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    cloths: Option<u32>,
    /// Wavefront OBJ file of a garment around the y axis [m], for `spin`; `--size` does not change it.
    #[arg(long, value_name = "FILE")]
    garment: Option<PathBuf>,
    /// Frames of 1/60 s that are timed, after a tenth as many to warm up.
    #[arg(long, default_value_t = 600, value_parser = clap::value_parser!(u32).range(1..))]
    frames: u32,
    /// Threads that step cloths.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=256))]
    threads: u32,
    /// How crossing cloths are taken apart: history, local-gradient, global-gradient, by-end-type, or none to look for nothing
    /// [default: by-end-type where cloths can meet, none elsewhere].
    #[arg(long, value_parser = method_choice)]
    method: Option<MethodChoice>,
    /// Cloths keep off themselves, too; they do in the scenes from `stack` to `spin`.
    #[arg(long)]
    self_collision: bool,
    /// Cloths pass through each other and are untangled afterwards, instead of resting on each other.
    #[arg(long)]
    no_contact: bool,
    /// Moves every free particle of the start by up to a thousandth of an edge, another way for every number but 0.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Counts what crosses in what every frame shows, warming up included, without the detector. Frames are a little slower for it.
    #[arg(long)]
    check: bool,
    /// Steps this frame again, which `ClothRecorderPlugin` recorded, in place of a scene.
    #[arg(long, value_name = "FILE", exclusive = true)]
    replay: Option<PathBuf>,
    /// Prints one line of JSON instead of a table.
    #[arg(long)]
    json: bool,
}

fn main() -> ExitCode {
    let arguments: Arguments = cli::parse("stress");
    if let Some(path) = &arguments.replay {
        return replay(path);
    }
    let many = matches!(arguments.scene, SceneName::Hang | SceneName::Flags | SceneName::Layers | SceneName::Stack);
    if arguments.cloths.is_some_and(|k| k > 1) && !many {
        cli::complain("stress", "--cloths is for the scenes hang, flags, layers and stack");
        return ExitCode::from(2);
    }
    let mut scene = match scene(&arguments) {
        Ok(scene) => scene,
        Err(line) => {
            cli::complain("stress", &line);
            return ExitCode::from(2);
        }
    };
    if arguments.seed != 0 {
        scene = scene.jittered(arguments.seed);
    }
    if let Some(method) = method(&arguments) {
        let settings =
            UntangleSettings { resolve: ResolveSettings { method, ..Default::default() }, ..UntangleSettings::default() };
        scene = match scene.untangled(settings, EvaluateSettings::default(), arguments.self_collision || folds(&arguments)) {
            Ok(scene) => scene,
            Err(error) => {
                cli::complain("stress", &error.to_string());
                return ExitCode::from(2);
            }
        };
    }
    if arguments.no_contact {
        scene = scene.without_contact();
    }
    // The calling thread works too.
    let pool = (arguments.threads > 1).then(|| TaskPoolBuilder::new().num_threads(arguments.threads as usize - 1).build());
    // A tangle is what its first frames are about.
    let warm_up = if scene.gravity == glam::Vec3::ZERO { 0 } else { arguments.frames / 10 };
    let mut run = Run::default();
    for _ in 0..warm_up {
        step(&mut scene, pool.as_ref());
        run.check(&arguments, &scene);
    }
    for frame in 1..=arguments.frames {
        let start = Instant::now();
        step(&mut scene, pool.as_ref());
        run.frames.push(start.elapsed().as_secs_f64() * 1.0e3);
        run.note(frame, &scene);
        run.check(&arguments, &scene);
    }
    let crossings = if scene.untangle.is_some() { Some(scene.crossings()) } else { look(&mut scene) };
    print(&arguments, &scene, &mut run, crossings);
    ExitCode::SUCCESS
}

/// Steps a recorded frame again; the exit code is 1 when a bit differs.
fn replay(path: &Path) -> ExitCode {
    let read = File::open(path).map_err(RecordingError::from).and_then(|file| Recording::read(BufReader::new(file)));
    let mut recording = match read {
        Ok(recording) => recording,
        Err(error) => {
            cli::complain("stress", &format!("{}: {error}", path.display()));
            return ExitCode::from(2);
        }
    };
    let start = Instant::now();
    let replay = recording.replay();
    let particles: usize = recording.cloths.iter().map(|cloth| cloth.after.len()).sum();
    let line = serde_json::json!({
        "reason": recording.reason,
        "cloths": recording.cloths.iter().map(|cloth| &cloth.name).collect::<Vec<_>>(),
        "particles": particles,
        "frame_ms": start.elapsed().as_secs_f64() * 1.0e3,
        "same_bits": replay.differ == 0,
        "particles_that_differ": replay.differ,
        "farthest": replay.farthest,
        "crossings": replay.crossings,
        "held": replay.held,
        "recovered": replay.recovered,
        "worst_edge": replay.worst_edge,
    });
    println!("{line}");
    if replay.differ == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// The scene asked for.
fn scene(arguments: &Arguments) -> Result<Scene, String> {
    let &Arguments { size, cloths, .. } = arguments;
    let k = cloths.unwrap_or(1);
    if arguments.garment.is_some() && !matches!(arguments.scene, SceneName::Spin) {
        return Err("--garment is for the scene spin".into());
    }
    Ok(match arguments.scene {
        SceneName::Hang => scenes::curtains(k, size),
        SceneName::Ball => scenes::ball(size),
        SceneName::Flags => scenes::flags(k, size),
        SceneName::Sheets => scenes::sheets(size),
        SceneName::Layers => scenes::layers(k.max(2), size),
        SceneName::Stack => scenes::stack(cloths.unwrap_or(10), size),
        SceneName::Crosswise => scenes::crosswise(size),
        SceneName::Twist => scenes::twist(size),
        SceneName::Funnel => scenes::funnel(size),
        SceneName::Curtain => scenes::curtain(size),
        SceneName::Skirt => scenes::skirt(size),
        SceneName::Pinch => scenes::pinch(size),
        SceneName::Needles => scenes::needles(size),
        SceneName::Spin => match &arguments.garment {
            Some(path) => {
                let text = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
                let mesh = scenes::obj(&text);
                if mesh.triangles.is_empty() {
                    return Err(format!("{} has no faces: --garment wants a Wavefront OBJ file", path.display()));
                }
                scenes::spin_of(&mesh)
            }
            None => scenes::spin(size),
        },
        SceneName::Dent => scenes::tangle(Tangle::Dent, size),
        SceneName::DeepDent => scenes::tangle(Tangle::DeepDent, size),
        SceneName::Corner => scenes::tangle(Tangle::Corner, size),
        SceneName::BorderOverlap => scenes::tangle(Tangle::BorderOverlap, size),
        SceneName::StripStab => scenes::tangle(Tangle::StripStab, size),
        SceneName::TiltedStrip => scenes::tangle(Tangle::TiltedStrip, size),
        SceneName::FullCut => scenes::tangle(Tangle::FullCut, size),
        SceneName::Waves => scenes::tangle(Tangle::Waves, size),
    })
}

/// Crossings of all cloths with each other and with themselves in a scene in which nobody looked for them; none if there are too many
/// cloths to look at.
fn look(scene: &mut Scene) -> Option<u32> {
    let only = UntangleSettings { iterations: 0, ..UntangleSettings::default() };
    *scene = scene.clone().untangled(only, EvaluateSettings::default(), true).ok()?;
    scene.settle(0.0);
    let crossings = scene.crossings();
    scene.untangle = None;
    Some(crossings)
}

/// Whether a scene is about cloth that meets itself.
fn folds(arguments: &Arguments) -> bool {
    use SceneName::{Crosswise, Curtain, Funnel, Needles, Pinch, Skirt, Spin, Stack, Twist};
    matches!(arguments.scene, Stack | Crosswise | Twist | Funnel | Curtain | Skirt | Pinch | Needles | Spin)
}

/// The method asked for, or the one that suits the scene.
fn method(arguments: &Arguments) -> Option<Method> {
    use SceneName::{Ball, Flags, Hang};
    let meets = arguments.self_collision || !matches!(arguments.scene, Hang | Ball | Flags);
    match arguments.method {
        Some(MethodChoice(method)) => method,
        None => meets.then_some(Method::ByEndType),
    }
}

/// What all frames did.
#[derive(Default)]
struct Run {
    /// Time of every frame [ms].
    frames: Vec<f64>,
    /// Time of every stage and frame [ms].
    stages: [Vec<f64>; 5],
    held_frames: u32,
    tangled_frames: u32,
    /// First frame after which nothing crossed any more.
    clean_after: u32,
    most_crossings: u32,
    /// Frames that were checked, those that show something crossing, and the most in one of them.
    checked_frames: u32,
    crossing_frames: u32,
    shown_crossings: usize,
}

impl Run {
    /// Looks at what a frame shows, if that is asked for.
    fn check(&mut self, arguments: &Arguments, scene: &Scene) {
        if !arguments.check {
            return;
        }
        let crossings = Picture::of(scene).crossings();
        self.checked_frames += 1;
        self.crossing_frames += u32::from(crossings > 0);
        self.shown_crossings = self.shown_crossings.max(crossings);
    }

    fn note(&mut self, frame: u32, scene: &Scene) {
        let StageTimes { integrate, detect, resolve, evaluate, respond } = scene.times;
        for (times, time) in self.stages.iter_mut().zip([integrate, detect, resolve, evaluate, respond]) {
            times.push(time);
        }
        self.held_frames += u32::from(scene.is_held());
        self.most_crossings = self.most_crossings.max(scene.crossings());
        if scene.crossings() > 0 {
            self.tangled_frames += 1;
            self.clean_after = frame;
        }
    }
}

/// Sorts the times and takes one at a percentile.
fn percentile(times: &mut [f64], p: usize) -> f64 {
    times.sort_by(f64::total_cmp);
    times.get((times.len() * p / 100).min(times.len().saturating_sub(1))).copied().unwrap_or_default()
}

/// One frame of 1/60 s; cloths are dealt to the threads.
fn step(scene: &mut Scene, pool: Option<&TaskPool>) {
    let dt = 1.0 / 60.0;
    // Cloths that touch each other are stepped side by side.
    let touch = scene.untangle.as_ref().is_some_and(|u| u.contact);
    let Some(pool) = pool.filter(|_| !touch) else {
        scene.step(dt);
        return;
    };
    let start = Instant::now();
    scene.steer(dt);
    let input = FrameInput { dt, gravity: scene.gravity, bodies: &scene.bodies, wind: &scene.wind, skinned: None };
    // Equal shares, five for each thread: larger ones leave a thread idle at the end.
    let share = scene.cloths.len().div_ceil(5 * (pool.thread_num() + 1));
    pool.scope(|scope| {
        for cloths in scene.cloths.chunks_mut(share) {
            let input = &input;
            scope.spawn(async move { cloths.iter_mut().for_each(|cloth| cloth.step(input)) });
        }
    });
    scene.wind.advance(dt);
    scene.times = StageTimes { integrate: start.elapsed().as_secs_f64() * 1.0e3, ..StageTimes::default() };
    scene.settle(dt);
}

fn print(arguments: &Arguments, scene: &Scene, run: &mut Run, crossings: Option<u32>) {
    let [integrate, detect, resolve, evaluate, respond] = &mut run.stages;
    let particles: usize = scene.cloths.iter().map(|c| c.state.positions.len()).sum();
    let springs: usize = scene.cloths.iter().map(|c| c.rest.constraints()).sum();
    let substeps = scene.cloths.first().map_or(0, |c| c.report.substeps);
    // Equal cloths share one rest shape.
    let shared = scene.cloths.first().map_or(0, |c| c.rest.bytes());
    let own: usize = scene.cloths.iter().map(|c| c.scratch.bytes() + 32 * c.state.positions.len()).sum();
    let worst = scene.cloths.iter().map(|c| c.report.worst_edge).fold(0.0, f32::max);
    let mean = scene.cloths.iter().map(|c| c.report.mean_edge).fold(0.0, f32::max);
    let lowest = scene.cloths.iter().map(SceneCloth::lowest).fold(f32::INFINITY, f32::min);
    let seen = |count: u32| scene.untangle.is_some().then_some(count);
    let line = serde_json::json!({
        "scene": arguments.scene.to_possible_value().map(|value| value.get_name().to_string()),
        "size": arguments.size,
        "cloths": scene.cloths.len(),
        "threads": arguments.threads,
        "frames": run.frames.len(),
        "particles": particles,
        "springs": springs,
        "substeps": substeps,
        "frame_ms_p50": percentile(&mut run.frames, 50),
        "frame_ms_p95": percentile(&mut run.frames, 95),
        "stage_ms": {
            "integrate": percentile(integrate, 50),
            "detect": percentile(detect, 50),
            "resolve": percentile(resolve, 50),
            "evaluate": percentile(evaluate, 50),
            "respond": percentile(respond, 50),
        },
        "crossings": crossings,
        "most_crossings": seen(run.most_crossings),
        "tangled_frames": seen(run.tangled_frames),
        "clean_after": seen(run.clean_after),
        "held_frames": run.held_frames,
        "checked_frames": arguments.check.then_some(run.checked_frames),
        "crossing_frames": arguments.check.then_some(run.crossing_frames),
        "shown_crossings": arguments.check.then_some(run.shown_crossings),
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
