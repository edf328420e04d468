//! Presets, A against B, copy, save and load.

use std::path::{Path, PathBuf};

use bevy_egui::egui::{CollapsingHeader, Color32, Grid, RichText, TextEdit, Ui};

use super::entry::show;
use super::export::{as_ron, as_rust, from_ron};
use super::setting::{Kind, Part, Setting};
use super::settings::{ClothSettings, Edit, OWN};
use super::state::ClothInspector;
use super::table::settings_of;
use crate::components::ClothMaterial;

/// What a file is called whose name has no extension.
const EXTENSION: &str = "cloth.ron";
const NAMES: [&str; 2] = ["A", "B"];

/// A button with a name for screen readers and tests.
pub(super) fn button(ui: &mut Ui, text: &str, label: &str, tip: &str) -> bool {
    let response = ui.button(text);
    ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(label));
    response.on_hover_text(tip).clicked()
}

/// Buttons for the fabrics of the library.
pub(super) fn presets(ui: &mut Ui, edit: &mut Edit) {
    ui.horizontal_wrapped(|ui| {
        ui.label("Preset");
        let default = [("default", ClothMaterial::default())];
        for (name, preset) in default.into_iter().chain(ClothMaterial::PRESETS) {
            let response = ui.selectable_label(edit.settings.material == preset, name);
            ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(format!("preset {name}")));
            if response.clicked() {
                edit.settings.material = preset;
                edit.touch(Part::Material);
            }
        }
    });
}

/// Keeps settings as A and B, goes from one to the other, and lists what differs.
pub(super) fn compare(ui: &mut Ui, state: &mut ClothInspector, edit: &mut Edit) {
    ui.horizontal(|ui| {
        for (name, kept) in NAMES.into_iter().zip(&mut state.kept) {
            if button(
                ui,
                &format!("keep as {name}"),
                &format!("keep as {name}"),
                "Keeps the settings of this cloth to be compared.",
            ) {
                *kept = Some(edit.settings.clone());
            }
            let shown = kept.as_ref().is_some_and(|kept| {
                let mut same = edit.settings.clone();
                same.take(kept);
                same == edit.settings
            });
            let response = ui.add_enabled_ui(kept.is_some(), |ui| ui.selectable_label(shown, format!("use {name}"))).inner;
            if let (true, Some(kept)) = (response.clicked(), kept) {
                edit.settings.take(kept);
                OWN.into_iter().for_each(|part| edit.touch(part));
            }
        }
    });
    let [Some(a), Some(b)] = &mut state.kept else { return };
    let rows = differences(a, b);
    if rows.is_empty() {
        ui.weak("A and B are equal");
        return;
    }
    Grid::new("cloth inspector differences").striped(true).num_columns(3).show(ui, |ui| {
        for text in ["", "A", "B"] {
            ui.strong(text);
        }
        ui.end_row();
        for (label, a, b) in rows {
            ui.label(label);
            ui.label(a);
            ui.label(b);
            ui.end_row();
        }
    });
}

/// Settings of the cloth that differ, with both values as text.
#[must_use]
pub fn differences(a: &mut ClothSettings, b: &mut ClothSettings) -> Vec<(String, String, String)> {
    let text = |setting: &Setting, value: Option<f64>| match (value, setting.kind) {
        (None, _) => "-".to_string(),
        (Some(value), Kind::Choice { options, .. }) => options.get(value as usize).map_or(String::new(), |o| (*o).into()),
        (Some(value), Kind::Switch(_)) => if value == 0.0 { "off" } else { "on" }.into(),
        (Some(value), _) => {
            format!("{} {}", show(value, setting.scale().is_some_and(|s| s.integer)), setting.unit).trim_end().into()
        }
    };
    let settings = OWN.into_iter().flat_map(settings_of);
    settings
        .filter_map(|setting| {
            let (a, b) = (text(setting, setting.get(a)), text(setting, setting.get(b)));
            (a != b).then(|| (setting.label(), a, b))
        })
        .collect()
}

/// Copies, saves and loads.
pub(super) fn files(ui: &mut Ui, state: &mut ClothInspector, edit: &mut Edit) {
    ui.horizontal(|ui| {
        let rust =
            button(ui, "copy as Rust", "copy as Rust", "Everything that differs from the defaults, to paste into a program.");
        let ron = button(ui, "copy as RON", "copy as RON", "The material, as in a .cloth.ron file.");
        if rust || ron {
            state.copied = if rust { as_rust(&edit.settings) } else { as_ron(&edit.settings.material) };
            ui.ctx().copy_text(state.copied.clone());
        }
    });
    if !state.copied.is_empty() {
        CollapsingHeader::new("Copied").default_open(false).show(ui, |ui| {
            ui.add(TextEdit::multiline(&mut state.copied.as_str()).code_editor().desired_rows(3));
        });
    }
    ui.horizontal(|ui| {
        ui.label("File");
        let response = ui.add(TextEdit::singleline(&mut state.file).hint_text("my_fabric.cloth.ron").desired_width(170.0));
        ui.ctx().accesskit_node_builder(response.id, |node| node.set_label("file name"));
        if button(ui, "save", "save material", "Writes the material to the file.") {
            let path = path(&state.file);
            let saved =
                path.and_then(|path| save(&path, &edit.settings.material).map(|()| format!("saved {}", path.display())));
            state.say(saved);
        }
        if button(ui, "load", "load material", "Takes the material from the file.") {
            match path(&state.file).and_then(|path| Ok((load(&path)?, path))) {
                Ok((material, path)) => {
                    edit.settings.material = material;
                    edit.touch(Part::Material);
                    state.say(Ok(format!("loaded {}", path.display())));
                }
                Err(reason) => state.say(Err(reason)),
            }
        }
    });
    match &state.note {
        Some(Ok(done)) => ui.colored_label(Color32::from_rgb(110, 180, 110), done),
        Some(Err(reason)) => ui.colored_label(ui.visuals().error_fg_color, reason),
        None => ui.label(RichText::new(" ")),
    };
}

/// The file that was named; `.cloth.ron` is added where there is no extension.
fn path(name: &str) -> Result<PathBuf, String> {
    let name = name.trim();
    if name.is_empty() {
        return Err("type the name of a file first".into());
    }
    let path = Path::new(name);
    Ok(if path.extension().is_none() { path.with_extension(EXTENSION) } else { path.to_owned() })
}

/// Writes a material to a file. What is there already and is no material is left alone.
///
/// # Errors
/// Why the file cannot be written.
pub fn save(path: &Path, material: &ClothMaterial) -> Result<(), String> {
    if path.exists() && load(path).is_err() {
        return Err(format!("{} exists and is not a material: choose another name", path.display()));
    }
    std::fs::write(path, as_ron(material)).map_err(|error| format!("{}: {error}", path.display()))
}

/// Reads a material from a file.
///
/// # Errors
/// Why the file cannot be read, where it is wrong, or which field is out of range.
pub fn load(path: &Path) -> Result<ClothMaterial, String> {
    let text = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    from_ron(&text).map_err(|error| format!("{}: {error}", path.display()))
}
