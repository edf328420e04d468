//! The last ten seconds of one cloth as curves, and a strip that shows which frames were held and why.

use bevy_egui::egui::{Color32, Rect, RichText, Sense, Ui, pos2, vec2};
use egui_plot::{FilledArea, Line, Plot, PlotPoint, PlotPoints, PlotTransform, PlotUi};

use super::history::{History, SPAN, STAGES, Sample, Verdict};

/// Height of a plot and of the strip `[points]`.
const HEIGHT: f32 = 74.0;
const STRIP: f32 = 14.0;
/// Colours of the stages.
const COLORS: [Color32; STAGES.len()] = [
    Color32::from_rgb(78, 121, 167),
    Color32::from_rgb(242, 142, 43),
    Color32::from_rgb(225, 87, 89),
    Color32::from_rgb(118, 183, 178),
    Color32::from_rgb(176, 122, 161),
    Color32::from_rgb(237, 201, 72),
];

/// Buffers for what is drawn, reused from frame to frame.
#[derive(Debug, Default)]
pub(super) struct Curves {
    time: Vec<f64>,
    below: Vec<f64>,
    above: Vec<f64>,
    points: Vec<PlotPoint>,
}

/// Colour of a verdict in the strip.
const fn color(verdict: Verdict) -> Color32 {
    match verdict {
        Verdict::Clean => Color32::from_rgb(60, 110, 70),
        Verdict::Held => Color32::from_rgb(240, 200, 60),
        Verdict::Fading => Color32::from_rgb(240, 150, 50),
        Verdict::Spent | Verdict::NeverClean | Verdict::NotAsked => Color32::from_rgb(210, 60, 60),
    }
}

/// Draws all plots.
pub(super) fn show(ui: &mut Ui, history: &History, curves: &mut Curves) {
    let Some(now) = history.newest().map(|newest| newest.time) else {
        ui.weak("nothing was simulated yet");
        return;
    };
    heading(ui, "Stages [ms]", &core::array::from_fn::<_, { STAGES.len() }, _>(|i| (STAGES[i].into(), COLORS[i])));
    stages(ui, history, curves, now);
    line(ui, "Crossings", history, curves, now, &[("edges that cross faces", COLORS[2], &|s| f64::from(s.crossings))]);
    let contours: (&str, Color32, Of<'_>) = ("all contours", COLORS[4], &|s| f64::from(s.contour_length));
    let across = line(ui, "Contour length [m]", history, curves, now, &[contours]);
    let shown = [Verdict::Clean, Verdict::Held, Verdict::Fading, Verdict::Spent].map(color);
    let names = ["clean", "held", "fading", "crossing is shown"];
    heading(ui, "Frames", &core::array::from_fn::<_, 4, _>(|i| (names[i].into(), shown[i])));
    strip(ui, history, now, &across);
    let percent = |ratio: f32| 100.0 * f64::from((ratio - 1.0).max(-1.0));
    let worst: (&str, Color32, Of<'_>) = ("worst edge", COLORS[1], &|s| percent(s.worst_edge));
    line(ui, "Stretch [%]", history, curves, now, &[worst, ("mean edge", COLORS[0], &|s| percent(s.mean_edge))]);
    line(ui, "Kinetic energy [J]", history, curves, now, &[("free particles", COLORS[3], &|s| f64::from(s.kinetic))]);
}

/// What is drawn below, and in which colours.
fn heading(ui: &mut Ui, name: &str, colors: &[(String, Color32)]) {
    ui.horizontal(|ui| {
        ui.label(name);
        for (name, color) in colors {
            ui.label(RichText::new(name).small().color(*color));
        }
    });
}

type Of<'a> = &'a dyn Fn(&Sample) -> f64;

fn plot<'a>(name: &'static str) -> Plot<'a> {
    Plot::new(("cloth inspector", name))
        .height(HEIGHT)
        .include_x(-SPAN)
        .include_x(0.0)
        .include_y(0.0)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .allow_double_click_reset(false)
        .show_grid([false, true])
        .y_axis_min_width(34.0)
        .set_margin_fraction(vec2(0.0, 0.08))
        .x_axis_formatter(|mark, _| format!("{:.0} s", mark.value))
}

/// Draws curves below what they are and where they are now; returns where time lies on the screen.
fn line(
    ui: &mut Ui,
    name: &'static str,
    history: &History,
    curves: &mut Curves,
    now: f64,
    lines: &[(&str, Color32, Of<'_>)],
) -> PlotTransform {
    let newest = |of: &Of<'_>| history.newest().map_or(String::new(), |sample| short(of(sample)));
    heading(ui, name, &lines.iter().map(|(name, color, of)| (format!("{name}: {}", newest(of)), *color)).collect::<Vec<_>>());
    // All curves in one buffer, cut by lines.
    curves.points.clear();
    for (_, _, of) in lines {
        curves.points.extend(history.samples().map(|s| PlotPoint::new(s.time - now, finite(of(s)))));
    }
    let each = (curves.points.len() / lines.len().max(1)).max(1);
    let points = &curves.points;
    let shown = plot(name).show(ui, |ui: &mut PlotUi<'_>| {
        for ((label, color, _), points) in lines.iter().zip(points.chunks(each)) {
            ui.line(Line::new(*label, PlotPoints::Borrowed(points)).color(*color).width(1.2));
        }
    });
    shown.transform
}

/// A number in few characters.
fn short(value: f64) -> String {
    if value == 0.0 || (0.01..1.0e5).contains(&value.abs()) {
        format!("{value:.3}").trim_end_matches('0').trim_end_matches('.').into()
    } else {
        format!("{value:.1e}")
    }
}

fn stages(ui: &mut Ui, history: &History, curves: &mut Curves, now: f64) {
    let Curves { time, below, above, .. } = curves;
    time.clear();
    time.extend(history.samples().map(|s| s.time - now));
    above.clear();
    above.resize(time.len(), 0.0);
    plot("stages").show(ui, |ui| {
        for (stage, (name, color)) in STAGES.into_iter().zip(COLORS).enumerate() {
            below.clone_from(above);
            for (sum, sample) in above.iter_mut().zip(history.samples()) {
                *sum += finite(f64::from(sample.stages[stage]));
            }
            ui.add(FilledArea::new(name, time, below, above).fill_color(color));
        }
    });
}

fn finite(value: f64) -> f64 {
    if value.is_finite() { value } else { 0.0 }
}

/// A bar for each sample, below the plot that lies `across`; the pointer over it says why.
fn strip(ui: &mut Ui, history: &History, now: f64, across: &PlotTransform) {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), STRIP), Sense::hover());
    let rect = Rect::from_x_y_ranges(across.frame().x_range(), rect.y_range());
    let x = |time: f64| across.position_from_point_x(time - now);
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
    // Neighbours of one kind are one bar.
    let mut run: Option<(f32, f32, Verdict)> = None;
    let bar = |(from, to, verdict): (f32, f32, Verdict)| {
        let area = Rect::from_min_max(pos2(from, rect.top()), pos2(to.max(from + 1.5), rect.bottom()));
        painter.rect_filled(area, 0.0, color(verdict));
    };
    for sample in history.samples() {
        let at = x(sample.time);
        match &mut run {
            Some((_, to, verdict)) if *verdict == sample.verdict => *to = at,
            _ => {
                let from = run.map_or(at, |(_, to, _)| to);
                run.into_iter().for_each(bar);
                run = Some((from, at, sample.verdict));
            }
        }
    }
    run.into_iter().for_each(bar);
    if let Some(pointer) = response.hover_pos() {
        let nearest = history.samples().min_by(|a, b| (x(a.time) - pointer.x).abs().total_cmp(&(x(b.time) - pointer.x).abs()));
        if let Some(sample) = nearest {
            response.on_hover_text(format!(
                "{:.2} s ago\n{}\n{} crossings, contours of {:.3} m, {} frames held in a row",
                now - sample.time,
                sample.verdict.why(),
                sample.crossings,
                sample.contour_length,
                sample.held_frames
            ));
        }
    }
}
