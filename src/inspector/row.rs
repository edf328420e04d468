//! One row of the panel: name, slider with the default marked, the number to type, unit, and a way back to the default.

use bevy_egui::egui::{
    Align, Button, Color32, Id, Key, Label, Layout, Pos2, Response, RichText, Shape, Slider, SliderClamping, Stroke, TextEdit,
    Ui, WidgetInfo, WidgetType, lerp, pos2, style::HandleShape, util::IdTypeMap, vec2,
};

use super::entry::{parse, show};
use super::setting::{Kind, Scale, Setting};
use super::settings::Edit;

/// Widths of the columns `[points]`.
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

/// Text under the hands of the user, of one row of one cloth.
#[derive(Clone)]
struct Entry {
    text: String,
    /// The number that it was typed over, as shown.
    over: String,
    /// Why it was refused.
    refused: Option<String>,
}

/// Drops what was refused: the numbers that it was typed over are others now.
pub(super) fn forget(ui: &Ui) {
    ui.data_mut(IdTypeMap::remove_by_type::<Entry>);
}

/// The row of a setting.
pub(super) fn setting(ui: &mut Ui, setting: &Setting, edit: &mut Edit) {
    let Some(value) = setting.get(&mut edit.settings) else { return };
    let default = setting.default_value();
    let label = setting.label();
    let tips = [setting.does, setting.low, setting.high];
    let new = match setting.kind {
        Kind::Number(scale, _) | Kind::Count(scale, _) | Kind::Layer(scale, _) => {
            number(ui, &Row { label: &label, name: setting.name, unit: setting.unit, scale, default, tips }, value)
        }
        Kind::Switch { .. } => switch(ui, &label, setting.name, tips, value, default),
        Kind::Choice { options, .. } => choice(ui, &label, setting.name, tips, options, value, default),
    };
    if let Some(new) = new {
        setting.set(&mut edit.settings, new);
        edit.touch(setting.part);
    }
}

/// A number; the new one when it was changed. What is typed belongs to the `ui`: the panel has one for each cloth.
pub(super) fn number(ui: &mut Ui, row: &Row<'_>, value: f64) -> Option<f64> {
    let id = ui.make_persistent_id(row.label);
    let mut new = None;
    let refused = ui
        .horizontal(|ui| {
            let shown = |v: f64| show(v, row.scale.integer);
            name(ui, row.name, row.tips, row.default.is_some_and(|d| differs(d, value)), || {
                let (low, high) = row.scale.limits;
                let ends = format!("Range {} to {} {}", shown(low), shown(high), row.unit);
                let default = row.default.map_or(String::new(), |d| format!(", default {}", shown(d)));
                format!("{}{default}", ends.trim_end())
            });
            new = slide(ui, row, value);
            let typed = typed(ui, id, row, value);
            new = new.or(typed);
            ui.add_sized([UNIT, HEIGHT], Label::new(RichText::new(row.unit).weak()).halign(Align::LEFT));
            let refused = ui.data(|data| data.get_temp::<Entry>(id)).is_some_and(|entry| entry.refused.is_some());
            new = reset(ui, row.label, &shown, (value, refused), row.default).or(new);
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

/// The name, bold when the value is not the default; `last` is the last line of its tip.
fn name(ui: &mut Ui, name: &str, tips: [&str; 3], changed: bool, last: impl FnOnce() -> String) -> Response {
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
        ui.label(RichText::new(last()).weak());
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
        mark(ui, pos2(lerp(rail.min..=rail.max, row.scale.share(default) as f32), rect.bottom()));
    }
    new
}

/// Marks the default, from below.
fn mark(ui: &Ui, at: Pos2) {
    let points = vec![at - vec2(0.0, 5.0), at + vec2(3.5, 0.0), at - vec2(3.5, 0.0)];
    ui.painter().add(Shape::convex_polygon(points, ui.visuals().weak_text_color(), Stroke::NONE));
}

/// The number as text; taken when the user is done, or refused.
fn typed(ui: &mut Ui, id: Id, row: &Row<'_>, value: f64) -> Option<f64> {
    let shown = show(value, row.scale.integer);
    // What was refused goes with the number that it was typed over.
    let holds = |entry: &Entry| entry.refused.is_none() || entry.over == shown;
    let before = ui.data(|data| data.get_temp::<Entry>(id)).filter(holds);
    let typing = before.is_some();
    let mut entry = before.unwrap_or_else(|| Entry { text: shown.clone(), over: shown.clone(), refused: None });
    let color = if entry.refused.is_some() { Some(ui.visuals().error_fg_color) } else { None };
    let edit = TextEdit::singleline(&mut entry.text).id(id).desired_width(NUMBER).text_color_opt(color);
    let response = ui.add(edit);
    ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(row.label));
    let mut new = None;
    if response.changed() {
        entry.refused = None;
    }
    if response.lost_focus() {
        let given_up = ui.input(|input| input.key_pressed(Key::Escape)) || entry.text == shown;
        match parse(&entry.text, row.unit, &row.scale) {
            _ if given_up => entry.refused = None,
            Ok(number) => new = Some(number),
            Err(reason) => (entry.over, entry.refused) = (shown, Some(reason)),
        }
    }
    // What was neither taken nor refused, as when its section was closed over it, is no longer typed.
    if entry.refused.is_some() || response.has_focus() && (typing || response.changed()) {
        ui.data_mut(|data| data.insert_temp(id, entry));
    } else {
        ui.data_mut(|data| data.remove::<Entry>(id));
    }
    new
}

/// A button that leads back to the default, from another value or from text that was `refused`.
fn reset(
    ui: &mut Ui,
    label: &str,
    show: &dyn Fn(f64) -> String,
    (value, refused): (f64, bool),
    default: Option<f64>,
) -> Option<f64> {
    let default = default?;
    let away = refused || differs(value, default);
    let glyph = RichText::new("⟲").color(if away { ui.visuals().text_color() } else { Color32::TRANSPARENT });
    let response = ui.add_enabled(away, Button::new(glyph).small().frame(away));
    response.widget_info(|| WidgetInfo::labeled(WidgetType::Button, away, format!("reset {label}")));
    let tip = |ui: &mut Ui| {
        ui.label(format!("back to {}", show(default)));
    };
    response.on_hover_ui(tip).clicked().then_some(default)
}

fn switch(ui: &mut Ui, label: &str, text: &str, tips: [&str; 3], value: f64, default: Option<f64>) -> Option<f64> {
    let named = |v: f64| if v == 0.0 { "off".to_string() } else { "on".to_string() };
    let told = default.map_or(String::new(), |d| format!("default {}", named(d)));
    ui.horizontal(|ui| {
        name(ui, text, tips, default.is_some_and(|d| differs(d, value)), || told.clone());
        let mut on = value != 0.0;
        let response = ui.checkbox(&mut on, "");
        ui.ctx().accesskit_node_builder(response.id, |node| {
            node.set_label(label);
            node.set_description(told.as_str());
        });
        let new = response.changed().then_some(f64::from(u8::from(on)));
        ui.weak(&told);
        reset(ui, label, &named, (value, false), default).or(new)
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
    let named = |v: f64| options.get(v as usize).map_or(String::new(), |o| (*o).to_string());
    ui.horizontal_wrapped(|ui| {
        name(ui, text, tips, default.is_some_and(|d| differs(d, value)), || {
            default.map_or(String::new(), |d| format!("default {}", named(d)))
        });
        let mut new = None;
        ui.spacing_mut().item_spacing.x = 3.0;
        for (i, option) in options.iter().enumerate() {
            let chosen = value as usize == i;
            let response = ui.selectable_label(chosen, *option);
            let usual = default == Some(i as f64);
            ui.ctx().accesskit_node_builder(response.id, |node| {
                node.set_label(format!("{label}: {option}"));
                if usual {
                    node.set_description("default");
                }
            });
            if usual {
                mark(ui, response.rect.center_bottom());
            }
            if response.clicked() && !chosen {
                new = Some(i as f64);
            }
        }
        reset(ui, label, &named, (value, false), default).or(new)
    })
    .inner
}
