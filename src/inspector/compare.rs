//! Presets, A against B, copy, save and load.

use std::path::{Path, PathBuf};

use bevy_egui::egui::{CollapsingHeader, Color32, Grid, RichText, ScrollArea, TextEdit, Ui};

use super::entry::show;
use super::export::{as_ron, as_rust, from_ron};
use super::part::Part;
use super::row;
use super::setting::{Kind, Setting};
use super::settings::{ClothSettings, Edit, OWN};
use super::state::ClothInspector;
use super::table::settings_of;
use super::widgets::button;
use crate::components::{ClothMaterial, ClothWind};
use crate::presets::ClothPreset;

/// How the name of a file ends.
const EXTENSION: &str = ".cloth.ron";
const NAMES: [&str; 2] = ["A", "B"];
/// Height of the list of what differs; the rest is scrolled to `[points]`.
const LIST: f32 = 160.0;

/// What was clicked and concerns all settings. It is done after the rows, which take what was being typed in the frame of the
/// click.
#[derive(Clone, Debug)]
pub(super) enum Ask {
    /// Takes a fabric of the library.
    Preset(ClothMaterial),
    /// Keeps the settings as A or B.
    Keep(usize),
    /// Takes those kept.
    Use(usize),
    /// Forgets both.
    Clear,
    /// Copies them as Rust.
    Rust,
    /// Copies them as RON.
    Ron,
    Save,
    Load,
    /// Gives the cloth a wind of its own, or takes it away.
    OwnWind(bool),
}

/// Does what was asked for.
pub(super) fn answer(ui: &Ui, ask: Ask, state: &mut ClothInspector, edit: &mut Edit) {
    let mut copy = |text: String| {
        state.copied.clone_from(&text);
        ui.ctx().copy_text(text);
    };
    match ask {
        Ask::Preset(material) => {
            edit.take(material.into());
            row::forget(ui);
        }
        Ask::Keep(i) => state.kept[i] = Some(edit.settings.clone()),
        Ask::Use(i) => {
            if let Some(kept) = &state.kept[i] {
                edit.settings.take(kept);
                OWN.into_iter().for_each(|part| edit.touch(part));
                row::forget(ui);
            }
        }
        Ask::Clear => state.kept = [None, None],
        Ask::Rust => copy(as_rust(&edit.settings)),
        Ask::Ron => copy(as_ron(&edit.settings.preset())),
        Ask::Save => {
            let saved = path(&state.file).and_then(|path| {
                save(&path, &edit.settings.preset())?;
                Ok(format!("saved {}", path.display()))
            });
            state.say(saved);
        }
        Ask::Load => {
            let loaded = path(&state.file).and_then(|path| {
                let (preset, clamped) = load(&path)?;
                edit.take(preset);
                row::forget(ui);
                let but = if clamped.is_empty() { "" } else { "; out of range and used clamped: " };
                Ok(format!("loaded {}{but}{}", path.display(), clamped.join(", ")))
            });
            state.say(loaded);
        }
        Ask::OwnWind(own) => {
            edit.settings.own_wind = own.then_some(ClothWind(edit.settings.wind));
            edit.touch(Part::OwnWind);
        }
    }
}

/// Buttons for the fabrics of the library.
pub(super) fn presets(ui: &mut Ui, material: &ClothMaterial) -> Option<Ask> {
    ui.horizontal_wrapped(|ui| {
        ui.label("Preset");
        let default = [("default", ClothMaterial::default())];
        let mut asked = None;
        for (name, preset) in default.into_iter().chain(ClothMaterial::PRESETS) {
            let response = ui.selectable_label(*material == preset, name);
            ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(format!("preset {name}")));
            let [density, stretch, bend] = [preset.density, preset.stretch_stiffness, preset.bend_stiffness];
            let tip = format!(
                "Takes this material: {density} kg/m², stretch {stretch} N/m, bend {bend:e} N·m. Every other setting stays."
            );
            if response.on_hover_text(tip).clicked() {
                asked = Some(Ask::Preset(preset));
            }
        }
        asked
    })
    .inner
}

/// Keeps settings as A and B, goes from one to the other, and lists what differs.
pub(super) fn compare(ui: &mut Ui, state: &mut ClothInspector, settings: &ClothSettings) -> Option<Ask> {
    let mut asked = None;
    ui.horizontal(|ui| {
        for (i, (name, kept)) in NAMES.into_iter().zip(&state.kept).enumerate() {
            let text = format!("keep as {name}");
            let tip = "Keeps the settings of this cloth, but its pins, to go back to; with both A and B kept, what differs is listed.";
            if button(ui, &text, &text, tip) {
                asked = Some(Ask::Keep(i));
            }
            let shown = kept.as_ref().is_some_and(|kept| {
                let mut same = settings.clone();
                same.take(kept);
                same == *settings
            });
            let response = ui.add_enabled_ui(kept.is_some(), |ui| ui.selectable_label(shown, format!("use {name}"))).inner;
            if response.clicked() {
                asked = Some(Ask::Use(i));
            }
        }
        let any = state.kept.iter().any(Option::is_some);
        if ui.add_enabled_ui(any, |ui| button(ui, "clear", "clear A and B", "Forgets both A and B.")).inner {
            asked = Some(Ask::Clear);
        }
    });
    if let [Some(a), Some(b)] = &mut state.kept {
        let rows = differences(a, b);
        if rows.is_empty() {
            ui.weak("A and B are equal");
        } else {
            let list = ScrollArea::vertical().max_height(LIST).auto_shrink([false, true]);
            list.id_salt("cloth inspector differences").show(ui, |ui| list_of(ui, rows));
        }
    }
    asked
}

fn list_of(ui: &mut Ui, rows: Vec<(String, String, String)>) {
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
        (Some(value), Kind::Switch { .. }) => if value == 0.0 { "off" } else { "on" }.into(),
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
pub(super) fn files(ui: &mut Ui, state: &mut ClothInspector) -> Option<Ask> {
    let mut asked = None;
    ui.horizontal(|ui| {
        for (text, tip, ask) in [
            (
                "copy as Rust",
                "The components that differ from their defaults, to paste into `commands.spawn((..))`. Wind and gravity of the world and weights of pins follow as comments.",
                Ask::Rust,
            ),
            ("copy as RON", "The text of a .cloth.ron file, as \"save\" writes it.", Ask::Ron),
        ] {
            if button(ui, text, text, tip) {
                asked = Some(ask);
            }
        }
    });
    if !state.copied.is_empty() {
        CollapsingHeader::new("Copied").default_open(false).show(ui, |ui| {
            ui.add(TextEdit::multiline(&mut state.copied.as_str()).code_editor().desired_rows(3).desired_width(f32::INFINITY));
        });
    }
    ui.horizontal(|ui| {
        ui.label("File");
        let response = ui.add(TextEdit::singleline(&mut state.file).hint_text("my_fabric.cloth.ron").desired_width(170.0));
        ui.ctx().accesskit_node_builder(response.id, |node| node.set_label("file name"));
        let saves = "Writes to the path, from the folder that the program runs in, and adds .cloth.ron: the material, and what else differs from its default: solver, collision, untangling, what is shown while tangled, limits, drive, wind of its own. Sleep, blend, inertia, level of detail, priority, pins, the body, the world, and whether it is untangled at all are not in files.";
        if button(ui, "save", "save to file", saves) {
            asked = Some(Ask::Save);
        }
        if button(ui, "load", "load from file", "Takes what the file holds; the rest stays.") {
            asked = Some(Ask::Load);
        }
    });
    match &state.note {
        Some(Ok(done)) => ui.colored_label(Color32::from_rgb(110, 180, 110), done),
        Some(Err(reason)) => ui.colored_label(ui.visuals().error_fg_color, reason),
        None => ui.label(RichText::new(" ")),
    };
    asked
}

/// The file that was named; `.cloth.ron` is added where it is not there.
fn path(name: &str) -> Result<PathBuf, String> {
    let name = name.trim();
    if name.is_empty() || name.ends_with(std::path::is_separator) {
        return Err("type the name of a file first".into());
    }
    Ok(if name.ends_with(EXTENSION) { name.into() } else { format!("{name}{EXTENSION}").into() })
}

/// Writes a preset to a file. What is there already and is no preset is left alone.
///
/// # Errors
/// Why the file cannot be written.
pub fn save(path: &Path, preset: &ClothPreset) -> Result<(), String> {
    if path.exists() && load(path).is_err() {
        return Err(format!("{} exists and is not a preset: choose another name", path.display()));
    }
    std::fs::write(path, as_ron(preset)).map_err(|error| format!("{}: {error}", path.display()))
}

/// Reads a preset from a file, and what in it is out of range, as [`from_ron`] does.
///
/// # Errors
/// Why the file cannot be read, or where it is wrong.
pub fn load(path: &Path) -> Result<(ClothPreset, Vec<String>), String> {
    let file = path.display().to_string();
    let text = std::fs::read_to_string(path).map_err(|error| format!("{file}: {error}"))?;
    from_ron(&text, &file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_ends_in_what_the_loader_loads() {
        for (name, file) in [
            ("silk", "silk.cloth.ron"),
            (" a/silk.v2 ", "a/silk.v2.cloth.ron"),
            ("my.cloth", "my.cloth.cloth.ron"),
            ("silk.ron", "silk.ron.cloth.ron"),
            ("silk.cloth.ron", "silk.cloth.ron"),
        ] {
            assert_eq!(path(name), Ok(PathBuf::from(file)), "{name}");
        }
        for name in ["", "  ", "fabrics/"] {
            assert!(path(name).is_err(), "`{name}` is {:?}", path(name));
        }
    }
}
