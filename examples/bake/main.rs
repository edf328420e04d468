//! Simulates the cloths of a glTF scene without a window and writes each as one OBJ file per frame.
//!
//! ```text
//! cargo run --example bake -- assets/drape.glb --frames 240 --out bake
//! ```
//!
//! `OUT/<node>_<frame>.obj` holds the welded mesh in world space [m], frame 0 as authored; `OUT/report.json` what each frame did. The exit
//! code is 0 only if all was written; a file that cannot be simulated is one line on stderr and exit code 2.

mod cli;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use bevy::asset::{AssetPlugin, LoadState, RecursiveDependencyLoadState};
use bevy::ecs::system::RunSystemOnce;
use bevy::gltf::{Gltf, GltfAssetLabel, GltfPlugin};
use bevy::log::LogPlugin;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy::world_serialization::WorldSerializationPlugin;
use bevy_drape::prelude::*;
use bevy_drape::{ClothError, ClothParticles, ClothRest};
use clap::Parser;
use serde_json::json;

/// Simulates the cloths of a glTF scene and writes each as one OBJ file per frame.
#[derive(Parser)]
struct Arguments {
    /// The scene, a .glb or .gltf file.
    scene: PathBuf,
    /// Frames to simulate.
    #[arg(long, default_value_t = 240)]
    frames: u32,
    /// Frames per second of simulated time.
    #[arg(long, default_value_t = 60.0, value_parser = rate)]
    fps: f64,
    /// Substeps per second [Hz] of cloths that have the default rate; more than in a game, since nobody waits.
    #[arg(long, default_value_t = 2400.0, value_parser = substeps)]
    substep_rate: f32,
    /// How crossing cloths are taken apart; the default is what each cloth asks for.
    #[arg(long, value_parser = cli::method)]
    method: Option<ClothUntanglingMethod>,
    /// Folder to write to; made if it is not there.
    #[arg(long, default_value = "bake")]
    out: PathBuf,
}

fn rate(text: &str) -> Result<f64, String> {
    let fps: f64 = text.parse().map_err(|_| "not a number".to_string())?;
    if (1.0..=10_000.0).contains(&fps) { Ok(fps) } else { Err("must be between 1 and 10000".into()) }
}

fn substeps(text: &str) -> Result<f32, String> {
    let rate: f32 = text.parse().map_err(|_| "not a number".to_string())?;
    if (30.0..=10_000.0).contains(&rate) { Ok(rate) } else { Err("must be between 30 and 10000".into()) }
}

fn main() -> ExitCode {
    match bake(&cli::parse("bake")) {
        Ok(()) => ExitCode::SUCCESS,
        Err(line) => {
            cli::complain("bake", &line);
            ExitCode::from(2)
        }
    }
}

/// How long loading may take [s].
const PATIENCE: Duration = Duration::from_secs(60);

/// Updates that a loaded scene gets to become cloth.
const SETTLE: u32 = 20;

fn bake(arguments: &Arguments) -> Result<(), String> {
    let mut app = app(arguments)?;
    load(&mut app, &arguments.scene)?;
    refine(&mut app, arguments.substep_rate);
    if let Some(method) = arguments.method {
        let mut cloths = app.world_mut().query::<&mut ClothUntangling>();
        cloths.iter_mut(app.world_mut()).for_each(|mut untangle| untangle.method = method);
    }
    std::fs::create_dir_all(&arguments.out).map_err(|error| unwritable(&arguments.out, &error))?;

    let names = names(&mut app);
    let mut report = Vec::new();
    write_frame(&mut app, &names, 0, &arguments.out)?;
    start(&mut app);
    for frame in 1..=arguments.frames {
        let begin = Instant::now();
        (0..updates(arguments.fps)).for_each(|_| app.update());
        let elapsed = begin.elapsed().as_secs_f64() * 1.0e3;
        report.push(describe(&mut app, &names, frame, elapsed));
        write_frame(&mut app, &names, frame, &arguments.out)?;
    }
    let path = arguments.out.join("report.json");
    let report = json!({ "fps": arguments.fps, "frames": report });
    std::fs::write(&path, format!("{report:#}\n")).map_err(|error| unwritable(&path, &error))
}

/// Updates in a written frame: none is longer than 0.05 s, so that no time is lost.
fn updates(fps: f64) -> u32 {
    (1.0 / (fps * 0.05)).ceil().max(1.0) as u32
}

fn unwritable(path: &Path, error: &std::io::Error) -> String {
    format!("{} cannot be written: {error}", path.display())
}

/// An app that loads and animates glTF scenes but draws nothing.
fn app(arguments: &Arguments) -> Result<App, String> {
    let scene = &arguments.scene;
    let folder = scene
        .canonicalize()
        .ok()
        .and_then(|path| path.parent().map(Path::to_path_buf))
        .ok_or_else(|| format!("{} is not there", scene.display()))?;
    let bytes = std::fs::read(scene).map_err(|error| format!("{} cannot be read: {error}", scene.display()))?;
    let mut gltf = GltfPlugin::default();
    for name in custom_attributes(&bytes) {
        gltf = bevy_drape::gltf::pin_attribute(gltf, name);
    }
    // Last: `_CLOTH_PAINT` is a colour and no single float.
    gltf = bevy_drape::gltf::cloth_attributes(gltf);
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        // What goes wrong while loading is told once, by this program.
        LogPlugin { filter: "warn,bevy_asset=off,bevy_gltf=off".into(), ..default() },
        TransformPlugin,
        AssetPlugin { file_path: folder.to_string_lossy().into_owned(), ..default() },
        ImagePlugin::default(),
        bevy::mesh::MeshPlugin,
        WorldSerializationPlugin,
        AnimationPlugin,
        gltf,
        ClothPlugin::default(),
    ))
    .register_type::<MeshMaterial3d<StandardMaterial>>()
    .register_type::<Visibility>()
    .init_asset::<StandardMaterial>()
    .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(
        1.0 / arguments.fps / f64::from(updates(arguments.fps)),
    )));
    app.finish();
    app.cleanup();
    app.world_mut().resource_mut::<Time<Virtual>>().pause();
    Ok(app)
}

/// Names of the vertex attributes of a glTF file that begin with an underscore.
fn custom_attributes(bytes: &[u8]) -> Vec<&'static str> {
    // A .glb holds its JSON in the first chunk, after two headers of 12 and 8 bytes.
    let text = match bytes.get(..20) {
        Some(header) if header.starts_with(b"glTF") => {
            let length = u32::from_le_bytes([header[12], header[13], header[14], header[15]]) as usize;
            bytes.get(20..20usize.saturating_add(length)).unwrap_or(&[])
        }
        _ => bytes,
    };
    let json: serde_json::Value = serde_json::from_slice(text).unwrap_or_default();
    let mut names: Vec<&str> = json["meshes"]
        .as_array()
        .into_iter()
        .flatten()
        .flat_map(|mesh| mesh["primitives"].as_array().into_iter().flatten())
        .filter_map(|primitive| primitive["attributes"].as_object())
        .flat_map(|attributes| attributes.keys().map(String::as_str))
        .filter(|name| name.starts_with('_'))
        .collect();
    names.sort_unstable();
    names.dedup();
    // The loader keeps names for as long as it lives, and it lives as long as this program.
    names.into_iter().map(|name| &*String::from(name).leak()).collect()
}

/// Loads the scene and waits until each of its cloths is simulated.
fn load(app: &mut App, scene: &Path) -> Result<(), String> {
    let file = scene.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let server = app.world().resource::<AssetServer>().clone();
    let gltf: Handle<Gltf> = server.load(file.clone());
    let begin = Instant::now();
    loop {
        app.update();
        match (server.load_state(&gltf), server.recursive_dependency_load_state(&gltf)) {
            (LoadState::Failed(error), _) => return Err(format!("{} cannot be loaded: {}", scene.display(), one_line(&error))),
            (_, RecursiveDependencyLoadState::Loaded | RecursiveDependencyLoadState::Failed(_)) => break,
            _ if begin.elapsed() > PATIENCE => return Err(format!("{} does not load within a minute", scene.display())),
            _ => std::thread::sleep(Duration::from_millis(1)),
        }
    }
    let asset = app.world().resource::<Assets<Gltf>>().get(&gltf);
    let animations = asset.map(|g| g.animations.clone()).unwrap_or_default();
    if asset.is_none_or(|g| g.scenes.is_empty()) {
        return Err(format!("{} has no scene", scene.display()));
    }
    if let Some(clip) = animations.first() {
        let (graph, node) = AnimationGraph::from_clip(clip.clone());
        let graph = app.world_mut().resource_mut::<Assets<AnimationGraph>>().add(graph);
        app.insert_resource(Motion(graph, node));
    }
    let root = server.load(GltfAssetLabel::Scene(0).from_asset(file));
    app.world_mut().spawn((WorldAssetRoot(root), Transform::default(), Visibility::default()));
    for _ in 0..SETTLE {
        app.update();
    }
    ready(app, scene)
}

/// Every cloth must be simulated, and there must be one.
fn ready(app: &mut App, scene: &Path) -> Result<(), String> {
    let mut cloths = app.world_mut().query_filtered::<(Option<&Name>, &ClothStatus, Option<&ClothError>), With<Cloth>>();
    let mut count = 0;
    for (name, status, error) in cloths.iter(app.world()) {
        count += 1;
        let name = name.map_or("a cloth", Name::as_str);
        if let Some(error) = error {
            return Err(format!("{}: {name} cannot be simulated: {}", scene.display(), one_line(error)));
        }
        if *status != ClothStatus::Active {
            return Err(format!("{}: {name} is not ready: {status:?}", scene.display()));
        }
    }
    if count == 0 {
        return Err(format!("{} has no cloth: no node with a mesh has `cloth` in its extras", scene.display()));
    }
    Ok(())
}

/// Cloths with the rate of a game get that of a bake.
fn refine(app: &mut App, substep_rate: f32) {
    let game = ClothSolver::default().substep_rate;
    let mut solvers = app.world_mut().query::<&mut ClothSolver>();
    for mut solver in solvers.iter_mut(app.world_mut()).filter(|solver| solver.substep_rate == game) {
        solver.substep_rate = substep_rate;
    }
}

fn one_line(error: &impl ToString) -> String {
    // A backtrace may follow.
    error.to_string().lines().next().unwrap_or_default().trim().to_string()
}

/// The first animation of the file.
#[derive(Resource)]
struct Motion(Handle<AnimationGraph>, AnimationNodeIndex);

/// Starts the clock and the animation.
fn start(app: &mut App) {
    app.world_mut().resource_mut::<Time<Virtual>>().unpause();
    let started = app.world_mut().run_system_once(
        |mut commands: Commands, motion: Option<Res<Motion>>, players: Query<(Entity, &mut AnimationPlayer)>| {
            let Some(motion) = motion else { return };
            for (entity, mut player) in players {
                player.play(motion.1).repeat();
                commands.entity(entity).insert(AnimationGraphHandle(motion.0.clone()));
            }
        },
    );
    if let Err(error) = started {
        cli::complain("bake", &format!("the animation does not play: {error}"));
    }
}

/// A file name for each cloth: that of its node, made unique.
fn names(app: &mut App) -> BTreeMap<Entity, String> {
    let mut cloths = app.world_mut().query_filtered::<(Entity, Option<&ChildOf>, Option<&Name>), With<ClothParticles>>();
    let world = app.world();
    let mut names = BTreeMap::new();
    let mut taken: BTreeMap<String, u32> = BTreeMap::new();
    for (entity, parent, own) in cloths.iter(world) {
        let node = parent.and_then(|p| world.get::<Name>(p.0)).or(own).map_or("cloth", Name::as_str);
        let safe: String = node.chars().map(|c| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' }).collect();
        let count = taken.entry(safe.clone()).or_default();
        names.insert(entity, if *count == 0 { safe } else { format!("{safe}.{count}") });
        *count += 1;
    }
    names
}

/// Writes every cloth of this frame.
fn write_frame(app: &mut App, names: &BTreeMap<Entity, String>, frame: u32, out: &Path) -> Result<(), String> {
    for (&entity, name) in names {
        let (Some(rest), Some(particles)) = (app.world().get::<ClothRest>(entity), app.world().get::<ClothParticles>(entity))
        else {
            return Err(format!("{name} is gone in frame {frame}"));
        };
        let mut text = String::new();
        for p in particles.shown_positions() {
            if !p.is_finite() {
                return Err(format!("{name} has a position that is not finite in frame {frame}"));
            }
            // Writing to a string cannot fail.
            let _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z);
        }
        for [a, b, c] in &rest.shape().topology.faces {
            let _ = writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1);
        }
        let path = out.join(format!("{name}_{frame:05}.obj"));
        std::fs::write(&path, text).map_err(|error| unwritable(&path, &error))?;
    }
    Ok(())
}

/// What the frame did, per cloth.
fn describe(app: &mut App, names: &BTreeMap<Entity, String>, frame: u32, elapsed: f64) -> serde_json::Value {
    let cloths: Vec<serde_json::Value> = names
        .iter()
        .filter_map(|(&entity, name)| {
            let report = app.world().get::<ClothReport>(entity)?;
            Some(json!({
                "name": name,
                "worst_edge": report.worst_edge,
                "substeps": report.substeps,
                "body_contacts": report.body_contacts,
                "contacts": report.contacts,
                "crossings": report.crossings,
                "contours": report.contours,
                "contour_length": report.contour_length,
                "held": report.held,
                "stage_ms": {
                    "integrate": report.integrate_ms,
                    "detect": report.detect_ms,
                    "resolve": report.resolve_ms,
                    "evaluate": report.evaluate_ms,
                    "respond": report.respond_ms,
                },
                "restores": report.restores,
                "resets": report.resets,
            }))
        })
        .collect();
    json!({ "frame": frame, "frame_ms": elapsed, "cloths": cloths })
}
