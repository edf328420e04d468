//! What the panel costs on top of egui: a frame with it, less the same number of bare widgets.

use std::time::Instant;

use bevy::prelude::*;
use bevy_drape::inspector::{ClothInspector, cloth_inspector};
use bevy_egui::egui::{Context, RawInput, Rect, Slider, Ui, pos2};

use crate::common::*;
use crate::panel::app_with_panel;

/// Frames that are timed.
const FRAMES: usize = 120;
/// Most that the panel may cost on top of egui [ms].
const MOST: f64 = 1.0;

/// Median time of some work [ms].
fn median(mut work: impl FnMut()) -> f64 {
    let mut times: Vec<f64> = (0..FRAMES)
        .map(|_| {
            let start = Instant::now();
            work();
            1.0e3 * start.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[FRAMES / 2]
}

/// Time of a pass of egui, with drawing [ms].
fn pass(context: &Context, mut show: impl FnMut(&mut Ui)) -> f64 {
    let input = RawInput { screen_rect: Some(Rect::from_min_max(pos2(0.0, 0.0), pos2(460.0, 720.0))), ..Default::default() };
    let frame = |show: &mut dyn FnMut(&mut Ui)| {
        let output = context.run_ui(input.clone(), |ui| show(ui));
        context.tessellate(output.shapes, output.pixels_per_point)
    };
    // Fonts and layouts are made in the first ones.
    (0..5).for_each(|_| drop(frame(&mut show)));
    median(|| drop(frame(&mut show)))
}

/// As many bare widgets as the panel shows while the material is open, and as many curves.
fn bare(ui: &mut Ui, values: &mut [f32], text: &mut [String], points: &[[f64; 2]]) {
    for (value, text) in values.iter_mut().zip(text) {
        ui.horizontal(|ui| {
            ui.label("stretch_stiffness");
            ui.add(Slider::new(value, 0.01..=10.0).logarithmic(true).show_value(false));
            ui.text_edit_singleline(text);
            ui.label("kg/m²");
            let _ = ui.small_button("⟲");
        });
    }
    for _ in 0..12 {
        ui.horizontal(|ui| [(); 3].map(|()| ui.button("push through nearest")));
    }
    for (i, curves) in [5, 1, 1, 2, 1].into_iter().enumerate() {
        egui_plot::Plot::new(i).height(74.0).show(ui, |ui| {
            for _ in 0..curves {
                ui.line(egui_plot::Line::new("curve", points.to_vec()));
            }
        });
    }
}

#[test]
#[ignore = "a measurement: cargo test --test inspector -- --ignored"]
#[expect(clippy::print_stdout, reason = "the figures of the documentation")]
fn the_panel_costs_less_than_a_millisecond_on_top_of_egui() {
    let mut app = app_with_panel();
    let cloth = spawn(&mut app, sheet(64), (border(), Transform::from_xyz(0.0, 2.0, 0.0)));
    run(&mut app, 620);
    app.world_mut().resource_mut::<ClothInspector>().selected = Some(cloth);
    // What it does without egui: the stage after everything else, with and without.
    let mut last = |open: bool| {
        app.world_mut().resource_mut::<ClothInspector>().open = open;
        median(|| app.world_mut().run_schedule(Last))
    };
    let (with, without) = (last(true), last(false));
    app.world_mut().resource_mut::<ClothInspector>().open = true;
    run(&mut app, 620);
    let panel = pass(&Context::default(), |ui| cloth_inspector(ui, app.world_mut()));
    let points: Vec<[f64; 2]> = (0..600).map(|i| [f64::from(i) / 60.0 - 10.0, f64::from(i % 7)]).collect();
    let (mut values, mut text) = ([1.0_f32; 15], [(); 15].map(|()| "2000".to_string()));
    let egui = pass(&Context::default(), |ui| bare(ui, &mut values, &mut text, &points));
    println!("recording {:.3} ms, panel {panel:.3} ms, as many bare widgets {egui:.3} ms", with - without);
    assert!(with - without + panel - egui < MOST, "recording {with} - {without} ms, panel {panel} - {egui} ms");
}
