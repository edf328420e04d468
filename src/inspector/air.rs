//! The wind as an arrow on the ground that is dragged.

use bevy::math::Vec3;
use bevy_egui::egui::{Sense, Stroke, Ui, Vec2, WidgetInfo, WidgetType, vec2};

/// Size of the pad `[points]`, and the speed at its rim `[m/s]`.
const SIZE: f32 = 96.0;
const RIM: f32 = 20.0;

/// A pad seen from above, x to the right and z towards the viewer: drag the arrow. The new velocity when it was changed.
pub(super) fn pad(ui: &mut Ui, label: &str, velocity: Vec3) -> Option<Vec3> {
    let (rect, response) = ui.allocate_exact_size(Vec2::splat(SIZE), Sense::click_and_drag());
    response.widget_info(|| WidgetInfo::labeled(WidgetType::Other, true, label));
    let visuals = ui.visuals();
    let (center, radius) = (rect.center(), 0.5 * SIZE - 2.0);
    let painter = ui.painter();
    painter.circle(center, radius, visuals.extreme_bg_color, visuals.widgets.noninteractive.bg_stroke);
    painter.circle_stroke(center, 0.5 * radius, visuals.widgets.noninteractive.bg_stroke);
    let drawn = vec2(velocity.x, velocity.z) * (radius / RIM);
    let drawn = if drawn.is_finite() { drawn * (radius / drawn.length().max(radius)) } else { Vec2::ZERO };
    painter.arrow(center, drawn, Stroke::new(2.0, visuals.selection.bg_fill));
    let pointer = response.interact_pointer_pos().filter(|_| response.dragged() || response.clicked());
    response.on_hover_text("Seen from above: x to the right, z down. Drag the arrow; the rim is 20 m/s.");
    pointer.map(|at| {
        let offset = (at - center) * (RIM / radius);
        let flat = offset * (RIM / offset.length().max(RIM));
        let tenth = |x: f32| (10.0 * x).round() / 10.0;
        Vec3::new(tenth(flat.x), velocity.y, tenth(flat.y))
    })
}
