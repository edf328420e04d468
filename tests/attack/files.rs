//! Files whose bytes were changed, read and spawned.

use std::path::{Path, PathBuf};

use bevy::asset::LoadState;
use bevy::asset::io::memory::{Dir, MemoryAssetReader};
use bevy::asset::io::{AssetSourceBuilder, AssetSourceId};
use bevy::gltf::GltfPlugin;
use bevy::mesh::MeshPlugin;
use bevy::prelude::*;
use bevy::world_serialization::{WorldAsset, WorldAssetRoot, WorldSerializationPlugin};
use bevy_drape::prelude::*;
use bevy_drape::{ClothPreset, ClothPresetHandle};
use fastrand::Rng;

use super::edits::{self, Edit};
use super::headless::{self, Options};
use super::panics;
use super::plan::Setup;
use super::play::{Failure, Tally, update};
use super::stage::Stage;
use super::{glb, shapes, texts};

/// Once in so many files, glTF in place of a preset.
const GLTF: u64 = 12;
/// Longest error that is shown to somebody [characters].
const LONGEST: usize = 600;

/// Changes of the file of a seed.
pub fn plan(seed: u64) -> Vec<Edit> {
    edits::edits(&mut Rng::with_seed(seed))
}

/// Reads the file of a seed with the changes whose numbers are kept, and plays some frames with what was in it.
///
/// # Errors
/// What does not hold.
pub fn play(seed: u64, keep: Option<&[usize]>, frames: u32, options: &Options) -> Result<Tally, Failure> {
    let edits: Vec<Edit> =
        plan(seed).into_iter().enumerate().filter(|(i, _)| keep.is_none_or(|keep| keep.contains(i))).map(|(_, e)| e).collect();
    let result =
        if seed.is_multiple_of(GLTF) { gltf(seed, &edits, frames, options) } else { preset(seed, &edits, frames, options) };
    result.map_err(|failure| Failure {
        told: edits.iter().map(|edit| format!("{edit:?}").chars().take(100).collect()).collect(),
        ..failure
    })
}

fn preset(seed: u64, edits: &[Edit], frames: u32, options: &Options) -> Result<Tally, Failure> {
    let mut bytes = texts::text(seed).as_bytes().to_vec();
    edits.iter().for_each(|edit| edits::apply(&mut bytes, edit));
    let Ok(text) = String::from_utf8(bytes) else { return Ok(Tally::default()) };
    let read = panics::caught(|| ClothPreset::from_ron(&text, "a.cloth.ron").map_err(|error| error.to_string()));
    let preset = match read.map_err(|panic| Failure::panic(panic, 0))? {
        Ok(preset) => preset,
        Err(error) if error.is_empty() || error.chars().count() > LONGEST => {
            return Err(Failure::broken(("an error nobody can read".into(), error), 0));
        }
        Err(_) => return Ok(Tally::default()),
    };
    if !seed.is_multiple_of(8) {
        return Ok(Tally::default());
    }
    let setup = Setup { fixed: false, draws: false, measures: false, physics: false };
    let mut stage = Stage::of(headless::app(&setup, options));
    let preset = stage.world().resource_mut::<Assets<ClothPreset>>().add(preset);
    let mesh = stage.add(shapes::sheet(6, 6, 1.0).mesh(false));
    let entity = stage.world().spawn((Mesh3d(mesh), Cloth, ClothPresetHandle(preset), ClothPins::vertices([0, 5]))).id();
    stage.enter(0, entity);
    finish(&mut stage, frames, options)
}

/// Plays some frames, and looks for what is left when everything is despawned.
fn finish(stage: &mut Stage, frames: u32, options: &Options) -> Result<Tally, Failure> {
    let mut tally = Tally::default();
    (0..frames).try_for_each(|frame| update(stage, frame, options, &mut tally))?;
    match panics::caught(|| stage.left()).map_err(|panic| Failure::panic(panic, frames))? {
        Some(left) => Err(Failure::broken(("something is left".into(), left), frames)),
        None => Ok(tally),
    }
}

/// JSON and data of the file of a seed: mostly the small one, rarely the large ones of the project.
fn file(seed: u64) -> (Vec<u8>, Vec<u8>) {
    let name = match seed / GLTF % 100 {
        0 => "character.glb",
        1..8 => "drape.glb",
        _ => return glb::small(),
    };
    let path = crate::root().join("assets").join(name);
    let bytes = std::fs::read(&path).unwrap_or_default();
    glb::split(&bytes).unwrap_or_else(glb::small)
}

fn gltf(seed: u64, edits: &[Edit], frames: u32, options: &Options) -> Result<Tally, Failure> {
    let (mut json, mut data) = file(seed);
    let (mut whole, mut rng) = (Vec::new(), Rng::with_seed(seed));
    for edit in edits {
        match rng.u32(0..10) {
            0 => whole.push(edit),
            1..3 if !matches!(edit, Edit::Number(..)) => edits::apply(&mut data, edit),
            _ => edits::apply(&mut json, edit),
        }
    }
    let mut bytes = glb::join(&json, &data);
    whole.into_iter().for_each(|edit| edits::apply(&mut bytes, edit));
    let files = Dir::new(PathBuf::new());
    files.insert_asset(Path::new("a.glb"), bytes);
    let mut stage = Stage::of(gltf_app(files, options));
    let loaded = panics::caught(|| load(&mut stage)).map_err(|panic| Failure::panic(panic, 0))?;
    // Where the engine's loader panics, the engine refuses the file.
    let others = panics::seen().map(|panic| panic.place).into_iter().collect();
    let Some(loaded) = loaded else {
        return Err(Failure::broken(("a file that is neither loaded nor refused".into(), String::new()), 0));
    };
    if let Some(scene) = loaded {
        // What the file holds is drawn as it is; what the plugin makes of it is not.
        let made: Vec<_> = stage.app.world().resource::<Assets<Mesh>>().ids().collect();
        stage.made.extend(made);
        let root = stage.world().spawn(WorldAssetRoot(scene)).id();
        stage.enter(0, root);
    }
    let tally = finish(&mut stage, frames, options)?;
    Ok(Tally { others, ..tally })
}

/// The scene, if the file has one; none if nothing comes of it within seconds.
fn load(stage: &mut Stage) -> Option<Option<Handle<WorldAsset>>> {
    let scene: Handle<WorldAsset> = stage.app.world().resource::<AssetServer>().load("a.glb#Scene0");
    for _ in 0..4000 {
        stage.app.update();
        match stage.app.world().resource::<AssetServer>().load_state(&scene) {
            LoadState::Loaded => return Some(Some(scene)),
            LoadState::Failed(_) => return Some(None),
            _ => std::thread::sleep(core::time::Duration::from_millis(1)),
        }
    }
    None
}

fn gltf_app(files: Dir, options: &Options) -> App {
    let mut app = App::new();
    let reader = AssetSourceBuilder::new(move || Box::new(MemoryAssetReader { root: files.clone() }));
    app.register_asset_source(AssetSourceId::Default, reader);
    app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default(), MeshPlugin, ImagePlugin::default()));
    let gltf = bevy_drape::gltf::cloth_attributes(GltfPlugin::default());
    app.add_plugins((WorldSerializationPlugin, gltf, ClothPlugin::default()));
    app.init_asset::<AnimationClip>().init_asset::<StandardMaterial>();
    headless::begin(&mut app, options);
    app
}
