//! What holds a cloth: its pin sets, how firmly each holds, and what happens when a target is lost.

use bevy::prelude::*;
use bevy_egui::egui::Ui;

use super::part::Part;
use super::row::{self, Row};
use super::setting::Scale;
use super::settings::Edit;
use crate::components::{ClothBuildReport, ClothOnTargetLost, ClothPinSelect, ClothPinSet, ClothReport};

const WEIGHT: Scale = Scale::real(0.0, 1.0);
const LOST: [ClothOnTargetLost; 3] = [ClothOnTargetLost::Hold, ClothOnTargetLost::Release, ClothOnTargetLost::Despawn];

/// What a set selects, in words.
fn describe(set: &ClothPinSet) -> String {
    let what = match &set.select {
        ClothPinSelect::Vertices(list) => format!("{} vertices", list.len()),
        ClothPinSelect::Weighted(list) => format!("{} vertices with weights", list.len()),
        ClothPinSelect::Position(_) => "by position".into(),
        ClothPinSelect::Color(channel) => format!("colour {channel:?}"),
        ClothPinSelect::Attribute(name) => format!("attribute {name}"),
    };
    match set.target {
        Some(target) => format!("{what}, held by {target}"),
        None => format!("{what}, held by its own entity"),
    }
}

/// The section of the pins.
pub(super) fn show(ui: &mut Ui, edit: &mut Edit, report: &ClothReport, build: &ClothBuildReport) {
    ui.weak(format!("{} of {} particles are pinned", report.pinned, build.particles));
    if !build.bad_pins.is_empty() {
        ui.colored_label(ui.visuals().warn_fg_color, format!("vertices that the mesh does not have: {:?}", build.bad_pins));
    }
    let mut changed = false;
    let mut removed = None;
    for (i, set) in edit.settings.pins.sets.iter_mut().enumerate() {
        ui.horizontal(|ui| {
            ui.label(format!("{i}: {}", describe(set)));
            let response = ui.small_button("let go");
            ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(format!("pins {i} let go")));
            if response.on_hover_text("Removes the set: what it held falls.").clicked() {
                removed = Some(i);
            }
        });
        let label = format!("pins {i} weight");
        let tips = ["How firmly the set holds.", "0: not at all.", "1: rigidly."];
        let row = Row { label: &label, name: "weight", unit: "", scale: WEIGHT, default: Some(1.0), tips };
        if let Some(weight) = row::number(ui, &row, f64::from(set.weight)) {
            set.weight = weight as f32;
            changed = true;
        }
    }
    if let Some(i) = removed {
        edit.settings.pins.sets.remove(i);
        changed = true;
    }
    let lost = LOST.iter().position(|l| *l == edit.settings.pins.on_target_lost).unwrap_or(0);
    let tips = [
        "What happens when the target of a set is despawned.",
        "Hold: the set stays where it is.",
        "Release: the set falls; Despawn: the cloth goes too.",
    ];
    let options = ["Hold", "Release", "Despawn"];
    if let Some(new) = row::choice(ui, "pins on_target_lost", "on_target_lost", tips, &options, lost as f64, Some(0.0)) {
        edit.settings.pins.on_target_lost = LOST.get(new as usize).copied().unwrap_or_default();
        changed = true;
    }
    if changed {
        edit.touch(Part::Pins);
    }
}
