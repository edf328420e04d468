//! Debug drawing, item by item, with what the colours mean.

use bevy::prelude::*;
use bevy_egui::egui::{Color32, RichText, Ui};

use crate::debug::ClothDebug;

/// Switches for what is drawn of all cloths.
pub(super) fn show(ui: &mut Ui, world: &mut World) {
    let Some(mut debug) = world.get_resource_mut::<ClothDebug>() else {
        ui.weak("add ClothDebugPlugin to see what the solver sees");
        return;
    };
    ui.horizontal_wrapped(|ui| {
        for name in ClothDebug::ITEMS {
            // Nothing is marked as changed by being shown.
            let Some(drawn) = debug.bypass_change_detection().item_mut(name) else { continue };
            let response = ui.checkbox(drawn, name);
            ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(format!("draw {name}")));
            if response.changed() {
                debug.set_changed();
            }
        }
    });
    for line in debug.legend() {
        let [r, g, b, _] = line.color.to_srgba().to_u8_array();
        ui.horizontal(|ui| {
            ui.label(RichText::new("■").color(Color32::from_rgb(r, g, b)));
            ui.weak(format!("{}: {}", line.item, line.label));
        });
    }
}
