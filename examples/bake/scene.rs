//! The scene: loaded, made of cloth, and set in motion.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};

use bevy::asset::{AssetPlugin, LoadState, RecursiveDependencyLoadState};
use bevy::ecs::system::RunSystemOnce;
use bevy::gltf::{Gltf, GltfAssetLabel, GltfExtras, GltfPlugin};
use bevy::log::LogPlugin;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy::world_serialization::WorldSerializationPlugin;
use bevy_drape::prelude::*;

use crate::{Arguments, cli};

/// How long loading may take [s].
const PATIENCE: Duration = Duration::from_secs(60);

/// Updates that a loaded scene gets to become cloth.
const SETTLE: u32 = 20;

/// Nodes whose cloth is simulated.
#[derive(Resource)]
struct Only(Vec<String>);

/// The animation that plays.
#[derive(Resource)]
struct Motion(Handle<AnimationGraph>, AnimationNodeIndex);

/// Updates in a written frame: none is longer than 0.05 s, so that no time is lost.
pub fn updates(fps: f64) -> u32 {
    (1.0 / (fps * 0.05)).ceil().max(1.0) as u32
}

/// An app that loads and animates glTF scenes but draws nothing. Only one of a program can log.
pub fn app(arguments: &Arguments, logs: bool) -> Result<App, String> {
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
    if logs {
        // What goes wrong while loading is told once, by this program.
        app.add_plugins(LogPlugin { filter: "warn,bevy_asset=off,bevy_gltf=off".into(), ..default() });
    }
    app.add_plugins((
        MinimalPlugins,
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
    // The first frame is the same on every machine.
    .insert_resource(ClothLoading::AT_ONCE)
    .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(
        1.0 / arguments.fps / f64::from(updates(arguments.fps)),
    )));
    if !arguments.only.is_empty() {
        app.insert_resource(Only(arguments.only.clone())).add_systems(PostUpdate, leave_out.before(ClothSystems::Prepare));
    }
    app.finish();
    app.cleanup();
    app.world_mut().resource_mut::<Time<Virtual>>().pause();
    Ok(app)
}

/// Takes away the nodes of other cloths, before their extras make cloth of them.
fn leave_out(mut commands: Commands, only: Res<Only>, nodes: Query<(Entity, &Name, &GltfExtras), Added<GltfExtras>>) {
    for (node, name, extras) in &nodes {
        if extras.value.contains("\"cloth") && !only.0.iter().any(|kept| kept == name.as_str()) {
            commands.entity(node).despawn();
        }
    }
}

/// The JSON of a glTF file; null where there is none.
fn json(bytes: &[u8]) -> serde_json::Value {
    // A .glb holds its JSON in the first chunk, after two headers of 12 and 8 bytes.
    let text = match bytes.get(..20) {
        Some(header) if header.starts_with(b"glTF") => {
            let length = u32::from_le_bytes([header[12], header[13], header[14], header[15]]) as usize;
            bytes.get(20..20usize.saturating_add(length)).unwrap_or(&[])
        }
        _ => bytes,
    };
    serde_json::from_slice(text).unwrap_or_default()
}

/// Names of the vertex attributes of a glTF file that begin with an underscore.
fn custom_attributes(bytes: &[u8]) -> Vec<&'static str> {
    let json = json(bytes);
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

/// Loads the scene and waits until each of its cloths is simulated. It will play the clip of that name, or the first one.
pub fn load(app: &mut App, scene: &Path, clip: Option<&str>) -> Result<(), String> {
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
    let named = clip.map(|clip| asset.and_then(|g| g.named_animations.get(clip)).ok_or(clip));
    let named = named.transpose().map_err(|clip| format!("{} has no clip `{clip}`", scene.display()))?.cloned();
    if asset.is_none_or(|g| g.scenes.is_empty()) {
        return Err(format!("{} has no scene", scene.display()));
    }
    if let Some(clip) = named.as_ref().or(animations.first()) {
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

/// Cloths with the rate of a game get another one, and all the method that was asked for.
pub fn refine(app: &mut App, substep_rate: f32, method: Option<ClothUntanglingMethod>) {
    let game = ClothSolver::default().substep_rate;
    let mut solvers = app.world_mut().query::<&mut ClothSolver>();
    for mut solver in solvers.iter_mut(app.world_mut()).filter(|solver| solver.substep_rate == game) {
        solver.substep_rate = substep_rate;
    }
    if let Some(method) = method {
        let mut cloths = app.world_mut().query::<&mut ClothUntangling>();
        cloths.iter_mut(app.world_mut()).for_each(|mut untangle| untangle.method = method);
    }
}

/// Names of the clips of a glTF file, in its order. Clips without a name are left out.
pub fn clips(arguments: &Arguments) -> Vec<String> {
    let json = std::fs::read(&arguments.scene).map(|bytes| json(&bytes)).unwrap_or_default();
    let names = json["animations"].as_array().into_iter().flatten().filter_map(|clip| clip["name"].as_str());
    names.map(String::from).collect()
}

fn one_line(error: &impl ToString) -> String {
    // A backtrace may follow.
    error.to_string().lines().next().unwrap_or_default().trim().to_string()
}

/// Starts the clock and the animation.
pub fn start(app: &mut App) {
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
pub fn names(app: &mut App) -> BTreeMap<Entity, String> {
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
