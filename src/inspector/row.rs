//! One row of the panel: name, slider with the default marked, the number to type, unit, and a way back to the default.

use bevy_egui::egui::{
    Align, Button, Color32, Id, Key, Label, Layout, Response, RichText, Shape, Slider, SliderClamping, Stroke, TextEdit, Ui,
    WidgetInfo, WidgetType, lerp, style::HandleShape, vec2,
};

use super::entry::{parse, show};
use super::setting::{Kind, Scale, Setting};
use super::settings::{ClothSettings, Edit};

/// Widths of the columns [points].
const NAME: f32 = 136.0;
const SLIDER: f32 = 120.0;
const NUMBER: f32 = 64.0;
const UNIT: f32 = 42.0;
const HEIGHT: f32 = 18.0;

/// What a row shows, apart from its value.
pub(super) struct Row<'a> {
    /// Name for screen readers and tests, unique in the panel.
    pub label: &'a str,
    /// Name in the first column.
    pub name: &'a str,
    pub unit: &'a str,
    pub scale: Scale,
    pub default: Option<f64>,
    /// What it does, and what goes wrong at the low and the high end.
    pub tips: [&'a str; 3],
}

/// Text under the hands of the user.
#[derive(Clone)]
struct Entry {
    text: String,
    /// Why it was refused.
    refused: Option<String>,
}

/// The row of a setting.
pub(super) fn setting(ui: &mut Ui, setting: &Setting, edit: &mut Edit, defaults: &mut ClothSettings) {
    let Some(value) = setting.get(&mut edit.settings) else { return };
    let default = setting.get(defaults);
    let label = setting.label();
    let tips = [setting.does, setting.low, setting.high];
    let new = match setting.kind {
        Kind::Number(scale, _) | Kind::Count(scale, _) | Kind::Layer(scale, _) => {
            number(ui, &Row { label: &label, name: setting.name, unit: setting.unit, scale, default, tips }, value)
        }
        Kind::Switch(_) => switch(ui, &label, setting.name, tips, value, default),
        Kind::Choice { options, .. } => choice(ui, &label, setting.name, tips, options, value, default),
    };
    if let Some(new) = new {
        setting.set(&mut edit.settings, new);
        edit.touch(setting.part);
    }
}

/// A number; the new one when it was changed.
pub(super) fn number(ui: &mut Ui, row: &Row<'_>, value: f64) -> Option<f64> {
    let id = Id::new(("cloth inspector", row.label));
    let mut new = None;
    let refused = ui
        .horizontal(|ui| {
            name(
                ui,
                row.name,
                row.unit,
                row.tips,
                Some((&row.scale, row.default)),
                row.default.is_some_and(|d| differs(d, value)),
            );
            new = slide(ui, row, value);
            let typed = typed(ui, id, row, value);
            new = new.or(typed);
            ui.add_sized([UNIT, HEIGHT], Label::new(RichText::new(row.unit).weak()).halign(Align::LEFT));
            new = reset(ui, row.label, &|v| show(v, row.scale.integer), value, row.default).or(new);
            if new.is_some() {
                ui.data_mut(|data| data.remove::<Entry>(id));
            }
            ui.data(|data| data.get_temp::<Entry>(id)).and_then(|entry| entry.refused)
        })
        .inner;
    if let Some(reason) = refused {
        ui.colored_label(ui.visuals().error_fg_color, format!("{}: {reason}", row.name));
    }
    new
}

/// Whether two numbers are different as the components hold them.
fn differs(a: f64, b: f64) -> bool {
    a as f32 != b as f32
}

fn name(
    ui: &mut Ui,
    name: &str,
    unit: &str,
    tips: [&str; 3],
    number: Option<(&Scale, Option<f64>)>,
    changed: bool,
) -> Response {
    let text = if changed { RichText::new(name).strong() } else { RichText::new(name) };
    let layout = Layout::left_to_right(Align::Center);
    let response = ui.allocate_ui_with_layout(vec2(NAME, HEIGHT), layout, |ui| {
        ui.set_min_width(NAME);
        ui.add(Label::new(text).truncate().show_tooltip_when_elided(false))
    });
    response.inner.on_hover_ui(|ui| {
        let [does, low, high] = tips;
        ui.set_max_width(320.0);
        ui.label(does);
        ui.label(RichText::new(format!("Low: {low}")).weak());
        ui.label(RichText::new(format!("High: {high}")).weak());
        if let Some((scale, default)) = number {
            let ends = format!("{} to {} {unit}", show(scale.limits.0, scale.integer), show(scale.limits.1, scale.integer));
            let default = default.map_or(String::new(), |d| format!(", default {}", show(d, scale.integer)));
            ui.label(RichText::new(format!("Range {}{default}", ends.trim_end())).weak());
        }
    })
}

/// The slider, with a mark where the default is.
fn slide(ui: &mut Ui, row: &Row<'_>, value: f64) -> Option<f64> {
    let mut new = None;
    let (low, high) = row.scale.slider;
    let at = if value.is_nan() { low } else { value };
    let slider = Slider::from_get_set(low..=high, |moved| {
        new = moved.or(new);
        new.unwrap_or(at)
    });
    let slider = slider.logarithmic(row.scale.log).clamping(SliderClamping::Never).show_value(false);
    ui.spacing_mut().slider_width = SLIDER;
    let response = ui.add(if row.scale.integer { slider.integer() } else { slider });
    ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(row.label));
    if let Some(default) = row.default.filter(|d| d.is_finite()) {
        let rect = response.rect;
        let radius = rect.height() / 2.5;
        let inset = match ui.style().visuals.handle_shape {
            HandleShape::Circle => radius,
            HandleShape::Rect { aspect_ratio } => radius * aspect_ratio,
        };
        let rail = rect.x_range().shrink(inset);
        let (x, bottom) = (lerp(rail.min..=rail.max, row.scale.share(default) as f32), rect.bottom());
        let points = vec![(x, bottom - 5.0).into(), (x + 3.5, bottom).into(), (x - 3.5, bottom).into()];
        ui.painter().add(Shape::convex_polygon(points, ui.visuals().weak_text_color(), Stroke::NONE));
    }
    new
}

/// The number as text; taken when the user is done, or refused.
fn typed(ui: &mut Ui, id: Id, row: &Row<'_>, value: f64) -> Option<f64> {
    let shown = show(value, row.scale.integer);
    let before = ui.data(|data| data.get_temp::<Entry>(id));
    let mut entry = before.unwrap_or_else(|| Entry { text: shown.clone(), refused: None });
    let color = if entry.refused.is_some() { Some(ui.visuals().error_fg_color) } else { None };
    let edit = TextEdit::singleline(&mut entry.text).id(id).desired_width(NUMBER).text_color_opt(color);
    let response = ui.add(edit);
    ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(row.label));
    if response.lost_focus() {
        if ui.input(|input| input.key_pressed(Key::Escape)) || entry.text == shown {
            ui.data_mut(|data| data.remove::<Entry>(id));
            return None;
        }
        match parse(&entry.text, row.unit, &row.scale) {
            Ok(number) => return Some(number),
            Err(reason) => entry.refused = Some(reason),
        }
        ui.data_mut(|data| data.insert_temp(id, entry));
    } else if response.changed() {
        entry.refused = None;
        ui.data_mut(|data| data.insert_temp(id, entry));
    }
    None
}

/// A button that leads back to the default.
fn reset(ui: &mut Ui, label: &str, show: &dyn Fn(f64) -> String, value: f64, default: Option<f64>) -> Option<f64> {
    let default = default?;
    let away = differs(value, default);
    let glyph = RichText::new("⟲").color(if away { ui.visuals().text_color() } else { Color32::TRANSPARENT });
    let response = ui.add_enabled(away, Button::new(glyph).small().frame(away));
    response.widget_info(|| WidgetInfo::labeled(WidgetType::Button, away, format!("reset {label}")));
    let tip = |ui: &mut Ui| {
        ui.label(format!("back to {}", show(default)));
    };
    response.on_hover_ui(tip).clicked().then_some(default)
}

fn switch(ui: &mut Ui, label: &str, text: &str, tips: [&str; 3], value: f64, default: Option<f64>) -> Option<f64> {
    ui.horizontal(|ui| {
        name(ui, text, "", tips, None, default.is_some_and(|d| differs(d, value)));
        let mut on = value != 0.0;
        let response = ui.checkbox(&mut on, "");
        ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(label));
        let new = response.changed().then_some(f64::from(u8::from(on)));
        reset(ui, label, &|v| if v == 0.0 { "off".into() } else { "on".into() }, value, default).or(new)
    })
    .inner
}

pub(super) fn choice(
    ui: &mut Ui,
    label: &str,
    text: &str,
    tips: [&str; 3],
    options: &[&str],
    value: f64,
    default: Option<f64>,
) -> Option<f64> {
    ui.horizontal(|ui| {
        name(ui, text, "", tips, None, default.is_some_and(|d| differs(d, value)));
        let mut new = None;
        ui.spacing_mut().item_spacing.x = 3.0;
        for (i, option) in options.iter().enumerate() {
            let chosen = value as usize == i;
            let response = ui.selectable_label(chosen, *option);
            ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(format!("{label}: {option}")));
            if response.clicked() && !chosen {
                new = Some(i as f64);
            }
        }
        let named = |v: f64| options.get(v as usize).map_or(String::new(), |o| (*o).to_string());
        reset(ui, label, &named, value, default).or(new)
    })
    .inner
}
