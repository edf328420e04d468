//! Presets, A against B, copy, save and load.

use bevy_drape::ClothPreset;
use bevy_drape::inspector::ClothSettings;
use bevy_drape::prelude::*;
use bevy_egui::egui::accesskit::Role;
use egui_kittest::kittest::Queryable;

use crate::panel::Panel;

/// A folder of this test alone.
fn folder(name: &str) -> std::path::PathBuf {
    let folder = std::env::temp_dir().join(format!("bevy_drape_{name}_{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for temporary files");
    folder
}

#[test]
fn every_preset_is_one_click_away() {
    let mut panel = Panel::new();
    for (name, preset) in ClothMaterial::PRESETS {
        panel.click(&format!("preset {name}"));
        assert_eq!(panel.settings().material, preset, "{name}");
    }
    panel.click("preset default");
    assert_eq!(panel.settings().material, ClothMaterial::default());
}

#[test]
fn a_and_b_are_kept_listed_and_exchanged_and_pins_and_world_stay() {
    let mut panel = Panel::new();
    panel.click("preset silk");
    panel.click("keep as A");
    panel.click("preset denim");
    panel.type_into("material density", "0.5");
    panel.click("keep as B");
    panel.steps(3);
    assert!(panel.shows("0.06 kg/m²") && panel.shows("0.5 kg/m²"), "what differs is not listed");
    let b = panel.settings();
    panel.click("use A");
    assert_eq!(panel.settings().material, ClothMaterial::SILK);
    assert_eq!((panel.settings().pins, panel.settings().wind), (b.pins.clone(), b.wind));
    panel.click("use B");
    assert_eq!(panel.settings(), b);
}

#[test]
fn what_is_copied_says_what_differs_as_rust_and_comes_back_from_ron() {
    let mut panel = Panel::new();
    panel.click("preset silk");
    panel.type_into("material density", "0.1");
    panel.click("copy as Rust");
    let rust = "ClothMaterial {\n    density: 0.1,\n    ..ClothMaterial::SILK\n},\n";
    assert_eq!(panel.copied.as_deref(), Some(rust));
    panel.click("copy as RON");
    let preset = panel.settings().preset();
    let copied = panel.copied.clone().expect("a text");
    assert_eq!(ClothPreset::from_ron(&copied, "copied").expect("a preset"), preset, "{copied}");
}

#[test]
fn what_is_being_typed_is_taken_before_it_is_copied_kept_or_saved() {
    let folder = folder("typed");
    let file = folder.join("typed.cloth.ron");
    let mut panel = Panel::new();
    panel.type_into("file name", file.to_str().expect("a name"));
    panel.begin_typing("material density", "0.5");
    panel.click("copy as Rust");
    assert!(panel.copied.as_deref().is_some_and(|text| text.contains("density: 0.5")), "{:?}", panel.copied);
    panel.begin_typing("material density", "0.6");
    panel.click("keep as A");
    panel.begin_typing("material density", "0.7");
    panel.click("save to file");
    let text = std::fs::read_to_string(&file).expect("the file");
    assert!(text.contains("density: 0.7"), "{text}");
    panel.click("use A");
    assert_eq!(panel.settings().material.density, 0.6);
    std::fs::remove_dir_all(folder).expect("the folder of this test");
}

#[test]
fn a_long_list_of_what_differs_leaves_room_and_goes_when_a_and_b_are_cleared() {
    let mut panel = Panel::new();
    let below = |panel: &Panel| panel.harness.get_by_role_and_label(Role::TextInput, "file name").rect().top();
    let start = below(&panel);
    panel.click("preset silk");
    panel.click("keep as A");
    let cloth = panel.cloth;
    let solver = ClothSolver { substep_rate: 720.0, max_frame: 0.2, gravity_scale: 0.5, time_scale: 0.5, ..Default::default() };
    let wind = ClothWind(ClothGlobalWind::default());
    panel.app().world_mut().entity_mut(cloth).insert((ClothMaterial::LEATHER, solver, wind));
    panel.steps(2);
    panel.click("keep as B");
    assert!(panel.shows("own wind velocity.x"), "what differs is not listed");
    let more = below(&panel) - start;
    assert!((50.0..200.0).contains(&more), "the list takes {more} points");
    panel.click("clear A and B");
    assert!(!panel.shows("own wind velocity.x"), "the list is still there");
    assert_eq!(below(&panel), start);
}

/// What a file holds of the settings of a cloth.
fn held(settings: &ClothSettings) -> ClothSettings {
    ClothSettings { sleep: Default::default(), pins: Default::default(), ..settings.clone() }
}

#[test]
fn what_is_saved_is_read_by_the_loader_and_comes_back_in_another_cloth() {
    let folder = folder("saves");
    let file = folder.join("my fabric.v2");
    let mut panel = Panel::new();
    let cloth = panel.cloth;
    panel.app().world_mut().entity_mut(cloth).insert((
        ClothMaterial { thickness: 0.002, strain_limit: f32::INFINITY, ..ClothMaterial::LEATHER },
        ClothSolver { substep_rate: 720.0, ..Default::default() },
        ClothCollision { garment_layer: 3, contact: false, ..Default::default() },
        ClothUntangling { iterations: 9, ..Default::default() },
        ClothSkipFrame { policy: ClothSkipPolicy::UntilClean { max: 3 }, ..Default::default() },
        ClothLimits { max_distance: ClothMap::Uniform(0.3), scale: 0.5, ..Default::default() },
        ClothDrive { frequency: ClothMap::attribute("_CLOTH_PAINT.a", 0.0, 4.0), damping_ratio: 0.5 },
        ClothWind::new(bevy::math::Vec3::X),
    ));
    panel.steps(2);
    let saved = panel.settings();
    panel.type_into("file name", file.to_str().expect("a name"));
    panel.click("save to file");
    assert!(panel.shows("saved"), "nothing says that it was saved");
    let text = std::fs::read_to_string(folder.join("my fabric.v2.cloth.ron")).expect("the file");
    assert_eq!(ClothPreset::from_ron(&text, "saved").expect("a preset"), saved.preset(), "{text}");
    panel.click("second");
    panel.click("load from file");
    assert!(panel.shows("loaded"));
    assert_eq!(held(&panel.others()), held(&saved));
    std::fs::remove_dir_all(folder).expect("the folder of this test");
}

#[test]
fn the_fabrics_of_the_library_are_loaded_from_their_files_and_nothing_else_changes() {
    let fabrics = drape_tests::root().join("assets/fabrics");
    let mut panel = Panel::new().opened();
    panel.type_into("solver substep_rate", "600");
    for (name, material) in ClothMaterial::PRESETS {
        let before = panel.settings();
        panel.type_into("file name", fabrics.join(name).to_str().expect("a name"));
        panel.click("load from file");
        assert_eq!(panel.settings(), ClothSettings { material, ..before }, "{name}");
    }
}

#[test]
fn what_is_out_of_range_is_saved_and_loaded_as_it_is_and_told() {
    let folder = folder("clamped");
    let file = folder.join("light.cloth.ron");
    let mut panel = Panel::new();
    let cloth = panel.cloth;
    let light = ClothMaterial { density: 0.005, ..ClothMaterial::SILK };
    panel.app().world_mut().entity_mut(cloth).insert(light.clone());
    panel.type_into("file name", file.to_str().expect("a name"));
    panel.click("save to file");
    panel.click("preset wool");
    panel.click("load from file");
    assert!(panel.shows("out of range and used clamped: material density"), "nothing says that it is clamped");
    assert_eq!(panel.settings().material, light);
    std::fs::remove_dir_all(folder).expect("the folder of this test");
}

#[test]
fn files_that_are_missing_wrong_or_not_ours_are_told_of_and_left_alone() {
    let folder = folder("bad_files");
    let path = |name: &str| folder.join(name).to_str().expect("a name").to_string();
    std::fs::write(folder.join("notes.cloth.ron"), "buy silk").expect("a file");
    std::fs::write(folder.join("typo.cloth.ron"), "(densty: 0.3)").expect("a file");
    let mut panel = Panel::new();
    let before = panel.settings();
    panel.click("save to file");
    assert!(panel.shows("type the name of a file first"));
    panel.type_into("file name", &path("missing"));
    panel.click("load from file");
    assert!(panel.shows("missing.cloth.ron"), "the missing file is not named");
    panel.type_into("file name", &path("typo.cloth.ron"));
    panel.click("load from file");
    assert!(panel.shows("typo.cloth.ron:1:2: `densty` is not known: did you mean `density`?"));
    panel.type_into("file name", &path("notes"));
    panel.click("save to file");
    assert!(panel.shows("choose another name"));
    assert_eq!(std::fs::read_to_string(folder.join("notes.cloth.ron")).ok().as_deref(), Some("buy silk"));
    panel.type_into("file name", &path("no such folder/x"));
    panel.click("save to file");
    assert!(panel.shows("no such folder"));
    assert_eq!(panel.settings(), before);
    std::fs::remove_dir_all(folder).expect("the folder of this test");
}
