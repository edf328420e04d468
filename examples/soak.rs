//! Runs cloth in one app for simulated hours: a flag in gusts, a curtain that a ball swings into, a skirt that walks, and a
//! pile that is shaken once a minute.
//!
//! ```text
//! cargo run --release --example soak -- --hours 10
//! ```
//!
//! For each tenth of the time: memory of the process, its time on processors for a frame, and of each cloth the stretch that
//! its worst edge keeps within in 99 of 100 frames, and the frames that crossed or were held. It fails where memory has grown
//! by more than 2 % since the second tenth of half an hour or more, a cloth is stretched by more than a tenth or does not go
//! on, or more frames are held in the last tenth than in the first.

#![expect(clippy::print_stdout, reason = "a program speaks on its terminal")]

#[path = "cli/mod.rs"]
mod cli;

use core::f64::consts::TAU;
use core::time::Duration;
use std::process::ExitCode;

use bevy::asset::{AssetPlugin, RenderAssetUsages};
use bevy::mesh::{Indices, MeshPlugin, PrimitiveTopology};
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_drape::prelude::*;
use bevy_drape::solver::rest::SourceMesh;
use clap::Parser;
use drape_scenes::{curtain, skirt};

/// Frames per second of simulated time [Hz].
const RATE: f64 = 60.0;
/// Distance between scenes [m]: they never touch.
const APART: f32 = 10.0;
/// The walk of the skirt as far as it repeats itself to a quarter of a milliradian: 113 rounds, 568 strides [s]. It begins at
/// full speed.
const WALK: (f64, f64) = (10.0, 631.1111);
/// How far up a ball under the pile goes [m], how long that takes, and how often [s].
const SHAKE: (f64, f64, f64) = (0.05, 1.0, 60.0);
/// Simulated time from which on memory is judged [h]: before, every thread takes its first.
const SETTLED: f64 = 0.5;
/// Memory that is given back late or early is no leak (dimensionless).
const GROWTH: f64 = 0.02;
/// Stretch that the worst edge keeps within in 99 of 100 frames (dimensionless).
const STRETCH: f64 = 1.1;

/// Runs cloth for simulated hours, and tells whether memory or cloth drift, and what frames cost.
#[derive(Parser)]
struct Arguments {
    /// Simulated time [h].
    #[arg(long, default_value_t = 10.0)]
    hours: f64,
    /// Vertices along each side of a sheet; other meshes are about as coarse.
    #[arg(long, default_value_t = 12, value_parser = clap::value_parser!(u32).range(4..=128))]
    size: u32,
}

fn main() -> ExitCode {
    let arguments: Arguments = cli::parse("soak");
    let frames = (arguments.hours.clamp(0.0, 1.0e4) * 3600.0 * RATE).ceil().max(10.0) as u64;
    let mut app = app(arguments.size);
    let cloths = cloths(&mut app);
    let mut tenths = Vec::new();
    for tenth in 0..10 {
        let (from, to) = (frames * tenth / 10, frames * (tenth + 1) / 10);
        let mut seen = Tenth::new(cloths.len());
        for _ in from..to {
            app.update();
            cloths.iter().zip(&mut seen.cloths).for_each(|((cloth, _), seen)| seen.note(app.world().get(*cloth)));
        }
        seen.end(to - from);
        println!("{:>6.2} h: {}", to as f64 / RATE / 3600.0, seen.describe(&cloths));
        tenths.push(seen);
    }
    let failures = failures(&tenths, &cloths, arguments.hours >= SETTLED);
    failures.iter().for_each(|failure| println!("FAILED {failure}"));
    if failures.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// What is not as it was.
fn failures(tenths: &[Tenth], cloths: &[(Entity, Name)], settled: bool) -> Vec<String> {
    let [first, second, .., last] = tenths else { return vec!["no time passed".into()] };
    let mut failures = Vec::new();
    if let (Some(before), Some(after)) = (second.memory, last.memory)
        && settled
        && after > before * (1.0 + GROWTH)
    {
        failures.push(format!("memory grew from {:.1} to {:.1} MiB", before / MIB, after / MIB));
    }
    for (i, (_, name)) in cloths.iter().enumerate() {
        let worst = tenths.iter().map(|tenth| tenth.cloths[i].stretch()).fold(0.0, f64::max);
        if tenths.iter().any(|tenth| tenth.cloths[i].simulated < tenth.frames) && !name.starts_with("sheet") {
            failures.push(format!("{name} is not simulated in every frame"));
        }
        if worst > STRETCH {
            failures.push(format!("{name}: edges of {worst:.3}"));
        }
        let [before, after] = [first, last].map(|tenth| tenth.cloths[i].held);
        if after > before {
            failures.push(format!("{name}: {before} frames held at first, {after} at last"));
        }
    }
    failures
}

/// What is driven, by scene.
#[derive(Component)]
enum Driven {
    Ball,
    Waist,
    Limb(usize),
    Shaker,
}

/// An app without a window in which the four scenes stand apart.
fn app(size: u32) -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default(), MeshPlugin, ClothPlugin::default()));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(1.0 / RATE)));
    app.insert_resource(ClothLoading::AT_ONCE);
    app.add_systems(Startup, move |commands: Commands, meshes: ResMut<Assets<Mesh>>| spawn(size, commands, meshes));
    app.add_systems(Update, drive);
    app.finish();
    app.cleanup();
    // The first update of a manual clock has no length.
    app.update();
    app
}

fn spawn(size: u32, mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>) {
    let folds = ClothCollision { self_collision: true, ..default() };
    let sheet = meshes.add(Plane3d::default().mesh().size(1.0, 1.0).subdivisions(size - 2).build());
    let per_metre = (2 * size / 3).max(4);
    let at = |i: f32| Transform::from_xyz(APART * i, 1.0, 0.0);

    let gusts = ClothWind(ClothGlobalWind { turbulence: 0.3, ..ClothGlobalWind::new(Vec3::new(0.0, 0.0, 6.0)) });
    let pole = ClothPins::where_position(|p| p.z < -0.499);
    commands.spawn((Name::new("flag"), Mesh3d(sheet), at(0.0), Cloth, folds, pole, gusts));

    let mesh = meshes.add(mesh_of(&curtain::mesh(per_metre)));
    let rail = ClothPins::where_position(|p| p.y > -1.0e-4);
    commands.spawn((Name::new("curtain"), Mesh3d(mesh), at(1.0), Cloth, folds, rail.clone()));
    commands.spawn((
        at(1.0),
        Visibility::default(),
        children![(Transform::default(), Driven::Ball, ClothCollider::ball(curtain::BALL))],
    ));

    let mesh = meshes.add(mesh_of(&skirt::mesh(per_metre)));
    let walker = commands.spawn((at(2.0), Visibility::default())).id();
    commands.spawn((
        Name::new("skirt"),
        ChildOf(walker),
        Mesh3d(mesh),
        place(skirt::waist(0.0)),
        Driven::Waist,
        Cloth,
        folds,
        rail,
    ));
    for (i, skirt::Limb { ends: [a, b], radius }) in skirt::LIMBS.into_iter().enumerate() {
        let axis =
            Transform::from_translation(a.midpoint(b)).with_rotation(Quat::from_rotation_arc(Vec3::Y, (b - a).normalize()));
        let capsule = (axis, ClothCollider::capsule(radius, a.distance(b)));
        commands.spawn((
            ChildOf(walker),
            place(skirt::limbs(0.0)[i]),
            Visibility::default(),
            Driven::Limb(i),
            children![capsule],
        ));
    }

    let ground = Transform::from_xyz(APART * 3.0, 0.0, 0.0);
    commands.spawn((ground, ClothCollider::ground()));
    commands.spawn((
        ground,
        Visibility::default(),
        children![(Transform::default(), Driven::Shaker, ClothCollider::ball(0.3))],
    ));
    let small = meshes.add(Plane3d::default().mesh().size(1.0, 1.0).subdivisions((size / 2).max(4) - 2).build());
    for i in 0..3 {
        let turn = Quat::from_rotation_y(0.35 * i as f32);
        let above = Transform::from_xyz(APART * 3.0 + 0.02 * i as f32, 0.4 + 0.03 * i as f32, 0.0).with_rotation(turn);
        commands.spawn((Name::new(format!("sheet {i}")), Mesh3d(small.clone()), above, Cloth, folds));
    }
}

fn place(pose: bevy_drape::solver::body::Pose) -> Transform {
    Transform::from_translation(pose.translation).with_rotation(pose.rotation)
}

/// Moves balls and body. All of them repeat themselves, so that hours do not cost them precision.
fn drive(time: Res<Time>, mut driven: Query<(&Driven, &mut Transform)>) {
    let now = time.elapsed_secs_f64();
    let (swing, walk) =
        ((now % f64::from(curtain::SWING.2)) as f32, now.min(WALK.0 + (now - WALK.0).rem_euclid(WALK.1)) as f32);
    let (height, length, pause) = SHAKE;
    let shake = (now % pause / length).min(1.0);
    let limbs = skirt::limbs(walk);
    for (driven, mut transform) in &mut driven {
        match driven {
            Driven::Ball => *transform = place(curtain::ball(swing)),
            Driven::Waist => *transform = place(skirt::waist(walk)),
            Driven::Limb(i) => *transform = place(limbs[*i]),
            Driven::Shaker if shake < 1.0 => transform.translation.y = (0.5 * height * (1.0 - (TAU * shake).cos())) as f32,
            Driven::Shaker => {}
        }
    }
}

/// A mesh for Bevy from one for the solver.
fn mesh_of(source: &SourceMesh) -> Mesh {
    let positions: Vec<[f32; 3]> = source.positions.iter().map(Vec3::to_array).collect();
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_indices(Indices::U32(source.triangles.concat()))
}

/// All cloths, by name.
fn cloths(app: &mut App) -> Vec<(Entity, Name)> {
    let mut all: Vec<_> = app
        .world_mut()
        .query_filtered::<(Entity, &Name), With<Cloth>>()
        .iter(app.world())
        .map(|(e, n)| (e, n.clone()))
        .collect();
    all.sort_by(|(_, a), (_, b)| a.as_str().cmp(b.as_str()));
    all
}

/// Half hundredths of a stretch that are told apart, the last one for all beyond and for what is not a number.
const BINS: usize = 400;

/// One cloth in a tenth of the time.
#[derive(Clone)]
struct Seen {
    /// Frames by the stretch of the worst edge, in steps of half a hundredth.
    worst: [u64; BINS],
    crossing: u64,
    held: u64,
    /// Frames in which it was simulated: what lies still sleeps.
    simulated: u64,
}

impl Seen {
    fn note(&mut self, report: Option<&ClothReport>) {
        let Some(report) = report else { return };
        let bin = 200.0 * (report.worst_edge - 1.0);
        let bin = if bin < (BINS - 1) as f32 { bin.max(0.0) as usize } else { BINS - 1 };
        self.worst[bin] += 1;
        self.simulated += u64::from(report.substeps > 0);
        self.crossing += u64::from(report.crossings > 0);
        self.held += u64::from(report.held);
    }

    /// What the worst edge keeps within in 99 of 100 frames, over its length at rest.
    fn stretch(&self) -> f64 {
        let all: u64 = self.worst.iter().sum();
        let mut above = 0;
        let within = self.worst.iter().rposition(|count| {
            above += count;
            100 * above > all
        });
        1.0 + (within.unwrap_or(0) + 1) as f64 / 200.0
    }
}

/// A tenth of the time.
struct Tenth {
    cloths: Vec<Seen>,
    frames: u64,
    /// Memory at its end [B], and time on the processor at its start and for a frame [s]; none where nobody tells.
    memory: Option<f64>,
    start: Option<f64>,
    frame: Option<f64>,
}

const MIB: f64 = 1024.0 * 1024.0;

impl Tenth {
    fn new(cloths: usize) -> Self {
        let nothing = Seen { worst: [0; BINS], crossing: 0, held: 0, simulated: 0 };
        Self { cloths: vec![nothing; cloths], frames: 0, memory: None, start: processor_time(), frame: None }
    }

    fn end(&mut self, frames: u64) {
        self.frames = frames;
        self.memory = memory();
        self.frame = processor_time().zip(self.start).map(|(end, start)| (end - start) / frames as f64);
    }

    fn describe(&self, cloths: &[(Entity, Name)]) -> String {
        let number = |of: Option<f64>| of.map_or("unknown".into(), |x| format!("{x:.2}"));
        let mut line =
            format!("{} MiB, {} ms a frame", number(self.memory.map(|m| m / MIB)), number(self.frame.map(|s| 1.0e3 * s)));
        for ((_, name), seen) in cloths.iter().zip(&self.cloths) {
            line += &format!("; {name} {:.3}, {} crossed, {} held", seen.stretch(), seen.crossing, seen.held);
        }
        line
    }
}

/// Memory of this process that is in use [B].
fn memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    Some(1024.0 * line.trim().strip_suffix("kB")?.trim().parse::<f64>().ok()?)
}

/// Time that this process had on processors [s], by its scheduler.
fn processor_time() -> Option<f64> {
    let tasks = std::fs::read_dir("/proc/self/task").ok()?;
    let one = |task: std::fs::DirEntry| -> Option<f64> {
        let text = std::fs::read_to_string(task.path().join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse().ok()
    };
    Some(1.0e-9 * tasks.flatten().filter_map(one).sum::<f64>())
}
