//! Presets, A against B, copy, save and load.

use bevy_drape::ClothMaterial;
use bevy_drape::inspector::{as_ron, from_ron, material_as_rust};

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
    let material = panel.settings().material;
    assert_eq!(panel.copied.as_deref().map(from_ron), Some(Ok(material)));
}

#[test]
fn copied_rust_is_rust() {
    // The text on the right is the code on the left.
    let material = ClothMaterial { density: 0.1, bend_stiffness: 3.5e-5, strain_limit: f32::INFINITY, ..ClothMaterial::SILK };
    let text = "ClothMaterial {\n    density: 0.1,\n    bend_stiffness: 3.5e-5,\n    strain_limit: f32::INFINITY,\n    ..ClothMaterial::SILK\n}";
    assert_eq!(material_as_rust(&material), text);
}

#[test]
fn what_is_saved_is_loaded_again() {
    let folder = folder("saves");
    let file = folder.join("my fabric");
    let mut panel = Panel::new();
    panel.click("preset leather");
    panel.type_into("material thickness", "0.002");
    let material = panel.settings().material;
    panel.type_into("file name", file.to_str().expect("a name"));
    panel.click("save material");
    assert!(panel.shows("saved"), "nothing says that it was saved");
    let text = std::fs::read_to_string(file.with_extension("cloth.ron")).expect("the file");
    assert_eq!(from_ron(&text), Ok(material.clone()));
    panel.click("preset silk");
    panel.click("load material");
    assert!(panel.shows("loaded"));
    assert_eq!(panel.settings().material, material);
    std::fs::remove_dir_all(folder).expect("the folder of this test");
}

#[test]
fn files_that_are_missing_wrong_or_not_ours_are_told_of_and_left_alone() {
    let folder = folder("bad_files");
    let path = |name: &str| folder.join(name).to_str().expect("a name").to_string();
    std::fs::write(folder.join("notes.txt"), "buy silk").expect("a file");
    std::fs::write(folder.join("nan.cloth.ron"), "(density: NaN)").expect("a file");
    let mut panel = Panel::new();
    let before = panel.settings();
    panel.click("save material");
    assert!(panel.shows("type the name of a file first"));
    panel.type_into("file name", &path("missing"));
    panel.click("load material");
    assert!(panel.shows("missing.cloth.ron"), "the missing file is not named");
    panel.type_into("file name", &path("nan.cloth.ron"));
    panel.click("load material");
    assert!(panel.shows("density: `NaN` is not a number"));
    panel.type_into("file name", &path("notes.txt"));
    panel.click("save material");
    assert!(panel.shows("choose another name"));
    assert_eq!(std::fs::read_to_string(folder.join("notes.txt")).ok().as_deref(), Some("buy silk"));
    panel.type_into("file name", &path("no such folder/x"));
    panel.click("save material");
    assert!(panel.shows("no such folder"));
    assert_eq!(panel.settings(), before);
    std::fs::remove_dir_all(folder).expect("the folder of this test");
}

#[test]
fn ron_of_every_preset_is_a_preset_file() {
    for (name, preset) in ClothMaterial::PRESETS {
        let text = as_ron(&preset);
        assert!(text.contains("density"), "{name}: {text}");
        assert_eq!(from_ron(&text), Ok(preset), "{name}");
    }
}
