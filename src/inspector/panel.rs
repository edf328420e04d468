//! The panel: from the cloth that is picked to its curves, top to bottom.

use bevy::prelude::*;
use bevy_egui::egui::{Button, CollapsingHeader, ScrollArea, Ui, vec2};

use super::compare::{self, Ask};
#[cfg(feature = "debug")]
use super::drawing;
use super::part::Part;
use super::row::{self, Row};
use super::setting::Scale;
use super::settings::{ClothSettings, Edit};
use super::state::{Action, ClothInspector};
use super::table::settings_of;
use super::widgets::{button, pressed};
use super::{air, pins, plots};
use crate::components::{Cloth, ClothBuildReport, ClothError, ClothMaterial, ClothReport, ClothStatus};
use crate::islands::ClothIslands;

/// Draws the panel into a window of the app's own.
///
/// [`ClothInspectorPlugin`](super::ClothInspectorPlugin) with `window: false` does what its buttons ask for and keeps what the
/// curves show.
///
/// ```no_run
/// # use bevy::prelude::*;
/// # use bevy_egui::{EguiContext, PrimaryEguiContext, egui};
/// # use bevy_drape::inspector::cloth_inspector;
/// fn window(world: &mut World) {
///     let mut contexts = world.query_filtered::<&mut EguiContext, With<PrimaryEguiContext>>();
///     let Ok(mut context) = contexts.single_mut(world) else { return };
///     let context = context.get_mut().clone();
///     egui::Window::new("Tuning").show(&context, |ui| cloth_inspector(ui, world));
/// }
/// ```
pub fn cloth_inspector(ui: &mut Ui, world: &mut World) {
    world.init_resource::<ClothInspector>();
    world.resource_scope(|world, mut state: Mut<ClothInspector>| panel(ui, world, &mut state));
}

fn panel(ui: &mut Ui, world: &mut World, state: &mut ClothInspector) {
    state.drawn = true;
    clock(ui, world, state);
    ui.separator();
    choose(ui, world, state);
    let read = |cloth: Option<Entity>| cloth.and_then(|c| Some((c, ClothSettings::read(world, c)?)));
    // Where another one was picked, the one before is drawn once more: its rows take what was being typed.
    let Some((cloth, settings)) = read(state.shown).or_else(|| read(state.selected)) else {
        ui.weak("there is no cloth");
        return;
    };
    let islands = world.get_resource::<ClothIslands>();
    let crossings = islands.map_or(0, |islands| islands.list.iter().map(|island| island.total().crossings).sum());
    status(ui, world, cloth, crossings);
    let mut edit = Edit::new(settings);
    actions(ui, state, cloth);
    state.specimen.show(ui, &edit.settings.material);
    ui.separator();
    let mut asked: Vec<Ask> = Vec::new();
    ScrollArea::vertical().auto_shrink([false, true]).show(ui, |ui| {
        asked.extend(compare::presets(ui, &edit.settings.material));
        asked.extend(compare::compare(ui, state, &edit.settings));
        asked.extend(compare::files(ui, state));
        ui.separator();
        for part in Part::ALL {
            // What is tuned most is next to what it does.
            if part == Part::Solver {
                section(ui, "Curves", true, |ui| plots::show(ui, &state.history, &mut state.curves));
            }
            section(ui, part.heading(), part == Part::Material, |ui| {
                ui.push_id(cloth, |ui| match part {
                    Part::Pins => {
                        let report = world.get::<ClothReport>(cloth).cloned().unwrap_or_default();
                        let build = world.get::<ClothBuildReport>(cloth).cloned().unwrap_or_default();
                        pins::show(ui, &mut edit, &report, &build);
                    }
                    Part::OwnWind => asked.extend(own_wind(ui, &mut edit)),
                    Part::Wind => {
                        let dragged = air::pad(ui, "wind pad", edit.settings.wind.velocity);
                        rows(ui, part, &mut edit);
                        if let Some(velocity) = dragged {
                            edit.settings.wind.velocity = velocity;
                            edit.touch(part);
                        }
                    }
                    _ => rows(ui, part, &mut edit),
                });
            });
        }
        #[cfg(feature = "debug")]
        section(ui, "Debug drawing", false, |ui| drawing::show(ui, world));
    });
    // Buttons act after the rows: the click on one ends what was being typed.
    for ask in asked {
        compare::answer(ui, ask, state, &mut edit);
    }
    edit.write(world, cloth);
    if state.shown != state.selected {
        state.shown = state.selected;
        row::forget(ui);
        ui.ctx().request_repaint();
    }
}

fn section(ui: &mut Ui, heading: &str, open: bool, show: impl FnOnce(&mut Ui)) {
    CollapsingHeader::new(heading).id_salt(("cloth inspector", heading)).default_open(open).show(ui, show);
}

fn rows(ui: &mut Ui, part: Part, edit: &mut Edit) {
    for setting in settings_of(part) {
        row::setting(ui, setting, edit);
    }
}

fn own_wind(ui: &mut Ui, edit: &mut Edit) -> Option<Ask> {
    let mut own = edit.settings.own_wind.is_some();
    let tip = "In place of the wind in the world; zones still add to it.";
    let switched = ui.checkbox(&mut own, "a wind of its own").on_hover_text(tip).changed();
    let dragged = edit.settings.own_wind.and_then(|wind| air::pad(ui, "own wind pad", wind.0.velocity));
    rows(ui, Part::OwnWind, edit);
    if let (Some(velocity), Some(wind)) = (dragged, &mut edit.settings.own_wind) {
        wind.0.velocity = velocity;
        edit.touch(Part::OwnWind);
    }
    switched.then_some(Ask::OwnWind(own))
}

/// Stops, steps and slows time.
fn clock(ui: &mut Ui, world: &mut World, state: &mut ClothInspector) {
    let Some(mut clock) = world.get_resource_mut::<Time<Virtual>>() else { return };
    ui.horizontal(|ui| {
        let paused = clock.is_paused();
        let tip = "Stops the clock of the game, or lets it run.";
        // As wide either way, so that what is next to it stays under the pointer.
        let size = vec2(62.0, ui.spacing().interact_size.y);
        let toggle = Button::new(if paused { "▶ run" } else { "⏸ pause" }).min_size(size);
        if pressed(ui, toggle, if paused { "run" } else { "pause" }, tip) {
            if paused {
                clock.unpause();
            } else {
                clock.pause();
            }
        }
        let tip = "Stops the clock and lets a sixtieth of a second pass.";
        if button(ui, "step", "step one frame", tip) {
            clock.pause();
            state.actions.push(Action::Step);
        }
        if paused {
            ui.weak("time stands still");
        }
    });
    let tips = ["Pace of the clock of the game.", "Slow motion.", "More than real time: frames need more substeps."];
    let scale = Scale::real(0.001, 10.0).slider(0.01, 4.0).log();
    let row = Row { label: "time pace", name: "pace of time", unit: "", scale, default: Some(1.0), tips };
    if let Some(pace) = row::number(ui, &row, f64::from(clock.relative_speed())) {
        clock.set_relative_speed(pace as f32);
    }
}

/// How a cloth is called in the list.
fn name(world: &World, cloth: Entity) -> String {
    world.get::<Name>(cloth).map_or_else(|| format!("cloth {cloth}"), ToString::to_string)
}

/// The list of cloths.
fn choose(ui: &mut Ui, world: &mut World, state: &mut ClothInspector) {
    let mut query = world.query_filtered::<Entity, With<Cloth>>();
    let mut cloths: Vec<Entity> = query.iter(world).collect();
    cloths.sort_unstable();
    if state.selected.is_none_or(|cloth| !cloths.contains(&cloth)) {
        state.selected = cloths.first().copied();
    }
    let list = ScrollArea::vertical().max_height(84.0).id_salt("cloth inspector list");
    list.show(ui, |ui| {
        ui.horizontal_wrapped(|ui| {
            ui.label("Cloth").on_hover_text("Or click it in the scene.");
            for &cloth in &cloths {
                if ui.selectable_label(state.selected == Some(cloth), name(world, cloth)).clicked() {
                    state.selected = Some(cloth);
                }
            }
        });
    });
}

/// Times the strain limit from which on a cloth counts as overstretched.
const OVERSTRETCHED: f32 = 4.0;
const STATUS: &str = "Of this cloth, in the last frame. Crossings are edges that go through faces, of it and of what it meets; in brackets those of all cloths. The worst edge is its longest over its \
     length at rest. The time is what it cost, its share of what cloths do together included.";

/// Whether it is simulated, why not, and what of its settings is not used as given.
fn status(ui: &mut Ui, world: &World, cloth: Entity, crossings: u32) {
    let error = world.get::<ClothError>(cloth);
    match (world.get::<ClothStatus>(cloth), error) {
        (_, Some(error)) => ui.colored_label(ui.visuals().error_fg_color, error.to_string()),
        (Some(ClothStatus::Waiting(what)), None) => ui.colored_label(ui.visuals().warn_fg_color, format!("waits for {what:?}")),
        _ => {
            let all = if crossings == 0 { String::new() } else { format!(" ({crossings} in all)") };
            let (Some(report), Some(build)) = (world.get::<ClothReport>(cloth), world.get::<ClothBuildReport>(cloth)) else {
                return;
            };
            let stretch = report.worst_edge.max(1.0) - 1.0;
            let text = format!(
                "{} crossings{all}, worst edge {:+.1} %\n{} particles, {} substeps, {:.2} ms",
                report.crossings,
                100.0 * stretch,
                build.particles,
                report.substeps,
                report.integrate_ms + report.detect_ms + report.resolve_ms + report.evaluate_ms + report.respond_ms
            );
            let limit = world.get::<ClothMaterial>(cloth).map_or(f32::INFINITY, |material| material.strain_limit);
            let bad = report.crossings > 0 || stretch > OVERSTRETCHED * limit;
            let color = if bad { ui.visuals().warn_fg_color } else { ui.visuals().weak_text_color() };
            ui.colored_label(color, text).on_hover_text(STATUS)
        }
    };
    if let Some(report) = world.get::<ClothReport>(cloth).filter(|report| !report.clamped.is_empty()) {
        let names = format!("out of range and used clamped: {}", report.clamped.join(", "));
        ui.colored_label(ui.visuals().warn_fg_color, names);
    }
}

/// What can be done to the cloth itself.
fn actions(ui: &mut Ui, state: &mut ClothInspector, cloth: Entity) {
    ui.horizontal(|ui| {
        for (text, tip, action) in [
            ("reset to rest", "Puts it at its pose at rest, without speed.", Action::Reset(cloth)),
            ("fold through itself", "Tangles it: one half is folded over the other and through it.", Action::Fold(cloth)),
            ("push through nearest", "Tangles it: it is pushed through the nearest other cloth.", Action::Push(cloth)),
            #[cfg(feature = "record")]
            (
                "record frame",
                "Writes its next frame to a file, which `stress --replay FILE` steps again.",
                Action::Record(cloth),
            ),
        ] {
            if button(ui, text, text, tip) {
                state.note = None;
                state.actions.push(action);
            }
        }
    });
}
