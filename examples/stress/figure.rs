//! An app with the woman of `assets/character.glb`, once or many times: no window, and nothing drawn.

use std::sync::mpsc;
use std::time::{Duration, Instant};

use bevy::animation::RepeatAnimation;
use bevy::asset::{AssetPlugin, LoadState};
use bevy::ecs::schedule::SingleThreadedExecutor;
use bevy::gltf::{Gltf, GltfExtras, GltfPlugin};
use bevy::log::LogPlugin;
use bevy::mesh::MeshPlugin;
use bevy::prelude::*;
use bevy::tasks::{ComputeTaskPool, TaskPoolBuilder};
use bevy::time::TimeUpdateStrategy;
use bevy::world_serialization::WorldSerializationPlugin;
use bevy_drape::prelude::*;

use crate::arguments::Arguments;
use crate::stages;

/// Frames per second of simulated time.
pub const RATE: f32 = 60.0;

/// How long loading and binding may take.
const PATIENCE: Duration = Duration::from_secs(300);

/// Clips that end where they would not begin again: who sits down does so once.
const ONCE: [&str; 2] = ["Sit", "LieDown"];

/// What is left of a character's clothes: the nodes of its outfit.
#[derive(Resource)]
struct Outfit(Vec<String>);

/// Characters at these places, dressed and in motion, each in another phase. Also the time that it took to bind their clothes
/// [s].
pub fn cast(arguments: &Arguments, places: impl Iterator<Item = Transform>) -> Result<(App, f64), String> {
    let mut app = app(arguments);
    let file = load(&mut app)?;
    let (scene, clips) = choose(&app, &file, arguments)?;
    for place in places {
        app.world_mut().spawn((WorldAssetRoot(scene.clone()), place, ClothCharacter));
    }
    let begin = Instant::now();
    wait(&mut app)?;
    let bound = begin.elapsed().as_secs_f64();
    settle(&mut app, arguments);
    play(&mut app, &clips, &arguments.clip);
    Ok((app, bound))
}

/// Makes the pool that cloths are stepped on. The calling thread works too, and Bevy asks for a pool of at least one: one of
/// its threads only waits.
fn pool(threads: u32) {
    let pool = ComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(threads as usize).build());
    let (tell, told) = mpsc::channel();
    let wait = async move {
        if tell.send(()).is_ok() {
            loop {
                std::thread::park();
            }
        }
    };
    pool.spawn(wait).detach();
    // Until one of them has taken it: nothing else runs before.
    let _ = told.recv();
}

fn app(arguments: &Arguments) -> App {
    pool(arguments.threads);
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        // What goes wrong while loading is told once, by this program.
        LogPlugin { filter: "warn,bevy_asset=off,bevy_gltf=off".into(), ..default() },
        TransformPlugin,
        AssetPlugin::default(),
        ImagePlugin::default(),
        MeshPlugin,
        WorldSerializationPlugin,
        AnimationPlugin,
        bevy_drape::gltf::cloth_attributes(GltfPlugin::default()),
        ClothPlugin::default(),
    ))
    .register_type::<MeshMaterial3d<StandardMaterial>>()
    .init_asset::<StandardMaterial>()
    // The first frame is the same on every machine.
    .insert_resource(ClothLoading::AT_ONCE)
    .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f32(1.0 / RATE)))
    .insert_resource(Outfit(arguments.outfit.clone()))
    .add_systems(PostUpdate, undress.before(ClothSystems::Prepare));
    stages::watch(&mut app);
    app.finish();
    app.cleanup();
    // Systems run one after another, on the calling thread: nothing else is between two stages.
    let mut schedules = app.world_mut().resource_mut::<Schedules>();
    schedules.iter_mut().for_each(|(_, schedule)| {
        schedule.set_executor(SingleThreadedExecutor::new());
    });
    app
}

/// Takes away what is not worn, before the file's extras make cloth of it.
fn undress(mut commands: Commands, outfit: Res<Outfit>, nodes: Query<(Entity, &Name, &GltfExtras), Added<GltfExtras>>) {
    for (node, name, extras) in &nodes {
        if extras.value.contains("\"cloth\"") && !outfit.0.iter().any(|worn| worn == name.as_str()) {
            commands.entity(node).despawn();
        }
    }
}

fn load(app: &mut App) -> Result<Handle<Gltf>, String> {
    let server = app.world().resource::<AssetServer>().clone();
    let file: Handle<Gltf> = server.load("character.glb");
    let begin = Instant::now();
    while !server.is_loaded_with_dependencies(&file) {
        if let LoadState::Failed(error) = server.load_state(&file) {
            let reason = error.to_string();
            return Err(format!("assets/character.glb cannot be loaded: {}", reason.lines().next().unwrap_or_default()));
        }
        if begin.elapsed() > PATIENCE {
            return Err("assets/character.glb does not load".into());
        }
        app.update();
        std::thread::sleep(Duration::from_millis(1));
    }
    Ok(file)
}

/// The scene and the clips of the file; every name must be there.
fn choose(
    app: &App,
    file: &Handle<Gltf>,
    arguments: &Arguments,
) -> Result<(Handle<WorldAsset>, Vec<Handle<AnimationClip>>), String> {
    let gltf = app.world().resource::<Assets<Gltf>>().get(file).ok_or("assets/character.glb is gone")?;
    let scene = gltf.scenes.first().cloned().ok_or("assets/character.glb has no scene")?;
    fn known<'a>(names: impl Iterator<Item = &'a str>) -> String {
        let mut names: Vec<&str> = names.collect();
        names.sort_unstable();
        names.join(", ")
    }
    for worn in &arguments.outfit {
        if !gltf.named_nodes.contains_key(worn.as_str()) {
            return Err(format!("there is no `{worn}` to wear, only {}", known(gltf.named_nodes.keys().map(AsRef::as_ref))));
        }
    }
    let clip = |name: &String| {
        let known = || known(gltf.named_animations.keys().map(AsRef::as_ref));
        gltf.named_animations.get(name.as_str()).cloned().ok_or_else(|| format!("there is no clip `{name}`, only {}", known()))
    };
    Ok((scene, arguments.clip.iter().map(clip).collect::<Result<_, _>>()?))
}

/// Until every character is there and its clothes are simulated.
fn wait(app: &mut App) -> Result<(), String> {
    let mut cloths = app.world_mut().query_filtered::<&ClothStatus, With<Cloth>>();
    let mut roots = app.world_mut().query_filtered::<(), With<WorldAssetRoot>>();
    let mut players = app.world_mut().query_filtered::<(), With<AnimationPlayer>>();
    let begin = Instant::now();
    loop {
        app.update();
        let world = app.world();
        let all_there = players.iter(world).count() == roots.iter(world).count();
        if all_there && cloths.iter(world).len() > 0 && cloths.iter(world).all(|status| *status == ClothStatus::Active) {
            return Ok(());
        }
        if cloths.iter(world).any(|status| *status == ClothStatus::Failed) {
            return Err("a piece of clothing cannot be simulated".into());
        }
        if begin.elapsed() > PATIENCE {
            return Err("the clothes wait for something that does not come: does the outfit have a cloth?".into());
        }
    }
}

/// What the command line asks of cloths.
fn settle(app: &mut App, arguments: &Arguments) {
    let mut cloths = app.world_mut().query_filtered::<(Entity, &mut ClothCollision, &mut ClothUntangling), With<Cloth>>();
    let mut alone = Vec::new();
    for (cloth, mut collision, mut untangling) in cloths.iter_mut(app.world_mut()) {
        match arguments.method.map(|choice| choice.0) {
            Some(None) => {
                (collision.self_collision, collision.contact) = (false, false);
                alone.push(cloth);
            }
            Some(Some(method)) => untangling.method = method,
            None => {}
        }
        collision.contact &= !arguments.no_contact;
        collision.self_collision |= arguments.self_collision;
    }
    for cloth in alone {
        // It touches bodies, which are in layer 0, and no cloth.
        app.world_mut().entity_mut(cloth).insert(ClothCollisionLayers::new(2, 1));
    }
    if let Some(ms) = arguments.budget {
        app.insert_resource(ClothBudget { ms });
    }
}

/// Starts the clips, in turn and each a golden share of a second after the one before.
fn play(app: &mut App, clips: &[Handle<AnimationClip>], names: &[String]) {
    const GOLDEN: f32 = 0.618_034;
    let (graph, nodes) = AnimationGraph::from_clips(clips.iter().cloned());
    let graph = app.world_mut().resource_mut::<Assets<AnimationGraph>>().add(graph);
    let mut players = app.world_mut().query_filtered::<Entity, With<AnimationPlayer>>();
    let mut players: Vec<Entity> = players.iter(app.world()).collect();
    players.sort_unstable();
    for (i, player) in players.into_iter().enumerate() {
        let clip = i % clips.len();
        let repeats = if ONCE.contains(&names[clip].as_str()) { RepeatAnimation::Never } else { RepeatAnimation::Forever };
        let mut player = app.world_mut().entity_mut(player);
        player.insert(AnimationGraphHandle(graph.clone()));
        if let Some(mut player) = player.get_mut::<AnimationPlayer>() {
            player.play(nodes[clip]).set_repeat(repeats).seek_to((i as f32 * GOLDEN).fract());
        }
    }
}
