//! Buttons as the panel has them: each with a name for screen readers and tests, and a tip.

use bevy_egui::egui::{Button, Ui};

/// A button with a name for screen readers and tests.
pub(super) fn button(ui: &mut Ui, text: &str, label: &str, tip: &str) -> bool {
    pressed(ui, Button::new(text), label, tip)
}

/// As [`button`], made elsewhere.
pub(super) fn pressed(ui: &mut Ui, button: Button<'_>, label: &str, tip: &str) -> bool {
    let response = ui.add(button);
    ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(label));
    response.on_hover_text(tip).clicked()
}
