//! Fabrics in files: loaded, reloaded, and refused with the place of what is wrong.

use std::path::{Path, PathBuf};

use bevy::mesh::MeshPlugin;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_drape::prelude::*;
use bevy_drape::{ClothPreset, ClothPresetHandle};

use crate::common::*;
use crate::warnings::warnings;

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("bevy_drape_presets_{}_{name}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for files");
    folder
}

fn write(folder: &Path, text: &str) {
    std::fs::write(folder.join("fabric.cloth.ron"), text).expect("a file");
}

/// An app that loads from a folder, and a cloth of its fabric.
fn start(folder: &Path) -> (App, Entity) {
    let mut app = App::new();
    let files = AssetPlugin { file_path: folder.display().to_string(), ..default() };
    app.add_plugins((MinimalPlugins, TransformPlugin, files, MeshPlugin, ClothPlugin::default()));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(core::time::Duration::from_secs_f32(FRAME)));
    app.finish();
    app.cleanup();
    app.update();
    let handle = app.world().resource::<AssetServer>().load("fabric.cloth.ron");
    let cloth = spawn(&mut app, sheet(5), ClothPresetHandle(handle));
    (app, cloth)
}

/// Runs until something holds, 10 s at most.
fn until(app: &mut App, mut holds: impl FnMut(&App) -> bool) -> bool {
    for _ in 0..2000 {
        app.update();
        if holds(app) {
            return true;
        }
        std::thread::sleep(core::time::Duration::from_millis(5));
    }
    false
}

fn density(app: &App, cloth: Entity) -> f32 {
    app.world().get::<ClothMaterial>(cloth).expect("a material").density
}

#[test]
fn the_fabrics_in_files_are_those_in_code() {
    let fabrics = drape_tests::root().join("assets/fabrics");
    for (name, material) in ClothMaterial::PRESETS {
        let file = fabrics.join(format!("{name}.cloth.ron"));
        let text = std::fs::read_to_string(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        let preset = ClothPreset::from_ron(&text, name).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(preset, ClothPreset::from(material), "{name}");
    }
    let count = std::fs::read_dir(&fabrics).expect("a folder of fabrics").count();
    assert_eq!(count, ClothMaterial::PRESETS.len());
}

#[test]
fn a_cloth_takes_over_what_its_file_holds_and_again_when_the_file_changes() {
    let folder = folder("reload");
    let all = "(material: (density: 0.7), solver: (substep_rate: 500), collision: (garment_layer: 3), untangle: (iterations: 9), \
               skip_frame: (max_held_frames: 5), limits: (max_distance: Uniform(9), scale: 0.5), drive: (frequency: Uniform(0.1)), \
               wind: (velocity: (0, 0, 2)))";
    write(&folder, all);
    let (mut app, cloth) = start(&folder);
    assert!(until(&mut app, |app| density(app, cloth) == 0.7), "{}", density(&app, cloth));
    app.update();
    let world = app.world();
    assert_eq!(world.get::<ClothSolver>(cloth).map(|s| s.substep_rate), Some(500.0));
    assert_eq!(world.get::<ClothCollision>(cloth), Some(&ClothCollision { garment_layer: 3, ..default() }));
    assert_eq!(world.get::<ClothUntangling>(cloth).map(|u| u.iterations), Some(9));
    assert_eq!(world.get::<ClothSkipFrame>(cloth).map(|s| s.max_held_frames), Some(5));
    let limits = ClothLimits { max_distance: ClothMap::Uniform(9.0), scale: 0.5, ..default() };
    assert_eq!(world.get::<ClothLimits>(cloth), Some(&limits));
    assert_eq!(world.get::<ClothDrive>(cloth), Some(&ClothDrive { frequency: ClothMap::Uniform(0.1), ..default() }));
    assert_eq!(world.get::<ClothWind>(cloth).map(|w| w.0.velocity), Some(Vec3::new(0.0, 0.0, 2.0)));
    // A file without solver leaves it alone, and the state goes on.
    run(&mut app, 20);
    let (time, height) = (report(&app, cloth).time, lowest(&particles(&app, cloth)));
    write(&folder, "(density: 0.3)");
    app.world().resource::<AssetServer>().reload("fabric.cloth.ron");
    assert!(until(&mut app, |app| density(app, cloth) == 0.3), "{}", density(&app, cloth));
    assert_eq!(app.world().get::<ClothSolver>(cloth).map(|s| s.substep_rate), Some(500.0));
    assert!(report(&app, cloth).time > time && lowest(&particles(&app, cloth)) < height);
    std::fs::remove_dir_all(&folder).expect("a folder to remove");
}

#[test]
fn settings_changed_by_hand_stay_until_the_file_changes_and_another_handle_counts_at_once() {
    let folder = folder("hand");
    write(&folder, "(density: 0.7)");
    let (mut app, cloth) = start(&folder);
    assert!(until(&mut app, |app| density(app, cloth) == 0.7));
    // The news of the file may come a frame after the file.
    run(&mut app, 10);
    app.world_mut().get_mut::<ClothMaterial>(cloth).expect("a material").density = 0.5;
    run(&mut app, 10);
    assert_eq!(density(&app, cloth), 0.5);
    let silk = app.world_mut().resource_mut::<Assets<ClothPreset>>().add(ClothPreset::from(ClothMaterial::SILK));
    app.world_mut().entity_mut(cloth).insert(ClothPresetHandle(silk.clone()));
    run(&mut app, 1);
    assert_eq!(app.world().get::<ClothMaterial>(cloth), Some(&ClothMaterial::SILK));
    // Edited as an asset, as an inspector does.
    app.world_mut().resource_mut::<Assets<ClothPreset>>().get_mut(&silk).expect("an asset").material.density = 0.08;
    run(&mut app, 2);
    assert_eq!(density(&app, cloth), 0.08);
    std::fs::remove_dir_all(&folder).expect("a folder to remove");
}

#[test]
fn a_file_that_is_wrong_is_one_warning_with_its_place_and_changes_nothing() {
    let folder = folder("wrong");
    write(&folder, "(\n    density: 0.7,\n    frition: 1.0,\n)");
    let (app, cloth) = start(&folder);
    let mut density_after = 0.0;
    let lines = warnings(app, |app| {
        app.world_mut().entity_mut(cloth).insert(Name::new("curtain"));
        run(app, 20);
        std::thread::sleep(core::time::Duration::from_millis(300));
        run(app, 100);
        density_after = density(app, cloth);
        assert_eq!(status(app, cloth), ClothStatus::Active);
    });
    assert_eq!(density_after, ClothMaterial::default().density);
    let ours: Vec<&String> = lines.iter().filter(|line| line.contains("`curtain`")).collect();
    assert_eq!(ours.len(), 1, "{lines:#?}");
    for words in ["fabric.cloth.ron:3:5", "`frition` is not known", "known are density"] {
        assert!(ours[0].contains(words), "{words} in {lines:#?}");
    }
    std::fs::remove_dir_all(&folder).expect("a folder to remove");
}

#[test]
fn a_file_that_becomes_wrong_keeps_what_it_held_and_counts_again_when_mended() {
    let folder = folder("mended");
    write(&folder, "(density: 0.7)");
    let (mut app, cloth) = start(&folder);
    assert!(until(&mut app, |app| density(app, cloth) == 0.7));
    write(&folder, "(density: 0.8");
    app.world().resource::<AssetServer>().reload("fabric.cloth.ron");
    run(&mut app, 20);
    std::thread::sleep(core::time::Duration::from_millis(200));
    run(&mut app, 20);
    assert_eq!(density(&app, cloth), 0.7);
    write(&folder, "(density: 0.9)");
    app.world().resource::<AssetServer>().reload("fabric.cloth.ron");
    assert!(until(&mut app, |app| density(app, cloth) == 0.9), "{}", density(&app, cloth));
    std::fs::remove_dir_all(&folder).expect("a folder to remove");
}
