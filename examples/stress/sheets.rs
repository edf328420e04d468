//! Scenes of the solver alone, without an app.

use std::sync::{Arc, LazyLock};
use std::time::Instant;

use bevy::tasks::{TaskPool, TaskPoolBuilder};
use bevy_drape::solver::evaluate::EvaluateSettings;
use bevy_drape::solver::island::UntangleSettings;
use bevy_drape::solver::jobs::JobSystem;
use bevy_drape::solver::resolve::{Method, ResolveSettings};
use bevy_drape::solver::step::FrameInput;
use clap::ValueEnum;
use drape_scenes::{self as scenes, Scene, SceneCloth, StageTimes, Tangle};
use serde_json::Value;

use crate::arguments::{Arguments, MethodChoice, SceneName};
use crate::table::percentile;
use drape_scenes::shown::Picture;

/// Steps a scene; what it cost.
pub fn run(arguments: &Arguments) -> Result<Value, String> {
    let mut scene = scene(arguments)?;
    scene.clock = clock;
    if arguments.seed != 0 {
        scene = scene.jittered(arguments.seed);
    }
    if let Some(method) = method(arguments) {
        let settings =
            UntangleSettings { resolve: ResolveSettings { method, ..Default::default() }, ..UntangleSettings::default() };
        let folds = arguments.self_collision || folds(arguments);
        scene = scene.untangled(settings, EvaluateSettings::default(), folds).map_err(|error| error.to_string())?;
    }
    if arguments.no_contact {
        scene = scene.without_contact();
    }
    let pool = (arguments.threads > 1).then(|| Arc::new(Pool::new(arguments.threads as usize)));
    if let (Some(pool), Some(untangling)) = (&pool, &mut scene.untangle) {
        untangling.island.share(Some(pool.clone()));
    }
    // A tangle is what its first frames are about.
    let warm_up = if scene.gravity == glam::Vec3::ZERO { 0 } else { arguments.warm_up() };
    let mut run = Run::default();
    for _ in 0..warm_up {
        step(&mut scene, pool.as_deref());
        run.check(arguments, &scene);
    }
    for frame in 1..=arguments.frames {
        let start = Instant::now();
        step(&mut scene, pool.as_deref());
        run.frames.push(start.elapsed().as_secs_f64() * 1.0e3);
        run.note(frame, &scene);
        run.check(arguments, &scene);
    }
    let crossings = if scene.untangle.is_some() { Some(scene.crossings()) } else { look(&mut scene) };
    Ok(describe(arguments, &scene, &mut run, crossings))
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
        SceneName::TwistedTube => scenes::twisted_tube(size),
        SceneName::ReefKnot => scenes::reef_knot(size),
        SceneName::Funnel => scenes::funnel(size),
        SceneName::Curtain => scenes::curtain(size),
        SceneName::Skirt => scenes::skirt(size),
        SceneName::Pinch => scenes::pinch(size),
        SceneName::Pressed => scenes::pressed(size),
        SceneName::Needles => scenes::needles(size),
        SceneName::Heap => scenes::heap(size, 0),
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
        SceneName::TurningBall => scenes::turning_ball(size),
        SceneName::Tablecloth => scenes::tablecloth(size),
        SceneName::Dent => scenes::tangle(Tangle::Dent, size),
        SceneName::DeepDent => scenes::tangle(Tangle::DeepDent, size),
        SceneName::Corner => scenes::tangle(Tangle::Corner, size),
        SceneName::BorderOverlap => scenes::tangle(Tangle::BorderOverlap, size),
        SceneName::StripStab => scenes::tangle(Tangle::StripStab, size),
        SceneName::TiltedStrip => scenes::tangle(Tangle::TiltedStrip, size),
        SceneName::FullCut => scenes::tangle(Tangle::FullCut, size),
        SceneName::Waves => scenes::tangle(Tangle::Waves, size),
        SceneName::Character | SceneName::Crowd => return Err("a character is no scene of the solver alone".into()),
    })
}

/// Crossings of all cloths with each other and with themselves in a scene in which nobody looked for them; none if there are
/// too many cloths to look at.
fn look(scene: &mut Scene) -> Option<u32> {
    let only = UntangleSettings { iterations: 0, ..UntangleSettings::default() };
    *scene = scene.clone().untangled(only, EvaluateSettings::default(), true).ok()?;
    scene.finish_frame(0.0);
    let crossings = scene.crossings();
    scene.untangle = None;
    Some(crossings)
}

/// Whether a scene is about cloth that meets itself.
fn folds(arguments: &Arguments) -> bool {
    use SceneName::{Crosswise, Curtain, Funnel, Heap, Needles, Pinch, Pressed, ReefKnot, Skirt, Spin, Stack, TwistedTube};
    use SceneName::{Tablecloth, TurningBall, Twist};
    let driven = matches!(arguments.scene, Curtain | Skirt | Pinch | Pressed | Spin | TurningBall | Tablecloth);
    let tight = matches!(arguments.scene, Twist | TwistedTube | ReefKnot | Funnel);
    driven || tight || matches!(arguments.scene, Stack | Crosswise | Needles | Heap)
}

/// The method asked for, or the one that suits the scene.
fn method(arguments: &Arguments) -> Option<Method> {
    use SceneName::{Ball, Flags, Hang};
    let meets = arguments.self_collision || !matches!(arguments.scene, Hang | Ball | Flags);
    match arguments.method {
        Some(MethodChoice(method)) => method.map(Into::into),
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

/// One frame of 1/60 s; cloths are dealt to the threads.
fn step(scene: &mut Scene, pool: Option<&Pool>) {
    let dt = 1.0 / 60.0;
    // Cloths that touch each other are stepped side by side.
    let touch = scene.untangle.as_ref().is_some_and(|u| u.contact);
    let Some(Pool(pool)) = pool.filter(|_| !touch) else {
        scene.step(dt);
        return;
    };
    let start = clock();
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
    scene.times = StageTimes { integrate: 1.0e3 * (clock() - start), ..StageTimes::default() };
    scene.finish_frame(dt);
}

/// Threads that step cloths beside the calling one, which works, too.
#[derive(Debug)]
struct Pool(TaskPool);

impl Pool {
    fn new(threads: usize) -> Self {
        Self(TaskPoolBuilder::new().num_threads(threads - 1).build())
    }
}

impl JobSystem for Pool {
    fn concurrency(&self) -> usize {
        self.0.thread_num() + 1
    }

    fn run(&self, count: usize, job: &(dyn Fn(usize) + Sync)) {
        self.0.scope(|scope| {
            for number in 1..count {
                scope.spawn(async move { job(number) });
            }
            job(0);
        });
    }
}

/// Time since it was first asked [s].
fn clock() -> f64 {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed().as_secs_f64()
}

fn describe(arguments: &Arguments, scene: &Scene, run: &mut Run, crossings: Option<u32>) -> Value {
    let [integrate, detect, resolve, evaluate, respond] = &mut run.stages;
    let particles: usize = scene.cloths.iter().map(|c| c.sim.state.positions.len()).sum();
    let springs: usize = scene.cloths.iter().map(|c| c.rest.constraints()).sum();
    let substeps = scene.cloths.first().map_or(0, |c| c.report.substeps);
    // Equal cloths share one rest shape.
    let shared = scene.cloths.first().map_or(0, |c| c.rest.bytes());
    let own: usize = scene.cloths.iter().map(|c| c.sim.memory.bytes() + 32 * c.sim.state.positions.len()).sum();
    let worst = scene.cloths.iter().map(|c| c.report.worst_edge).fold(0.0, f32::max);
    let mean = scene.cloths.iter().map(|c| c.report.mean_edge).fold(0.0, f32::max);
    let lowest = scene.cloths.iter().map(SceneCloth::lowest).fold(f32::INFINITY, f32::min);
    let seen = |count: u32| scene.untangle.is_some().then_some(count);
    serde_json::json!({
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
    })
}
