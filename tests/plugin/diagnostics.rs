//! What cloth costs and how it fares, as Bevy's diagnostics.

use bevy::diagnostic::DiagnosticsStore;
use bevy::mesh::MeshPlugin;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_drape::ClothDiagnosticsPlugin;
use bevy_drape::prelude::*;

use crate::common::*;

fn measured(schedule: ClothPlugin) -> App {
    let mut app = App::new();
    // In any order of plugins.
    app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default(), MeshPlugin, ClothDiagnosticsPlugin, schedule));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(core::time::Duration::from_secs_f32(FRAME)));
    app.finish();
    app.cleanup();
    app.update();
    app
}

fn value(app: &App, path: &bevy::diagnostic::DiagnosticPath) -> f64 {
    let store = app.world().resource::<DiagnosticsStore>();
    store
        .get(path)
        .unwrap_or_else(|| panic!("{path} is not registered"))
        .value()
        .unwrap_or_else(|| panic!("{path} has no value"))
}

/// Two sheets that stick in each other, and one far off; the first two are 9 x 9, the third is 5 x 5.
fn crowd(app: &mut App) {
    let skip = ClothSkipFrame::default();
    let still = ClothUntangling { iterations: 0, ..default() };
    spawn(app, sheet(9), (skip, still));
    let upright = Transform::from_rotation(Quat::from_rotation_x(1.5)).with_translation(Vec3::new(0.03, 0.0, 0.02));
    spawn(app, sheet(9), (upright, skip, still));
    spawn(app, sheet(5), Transform::from_xyz(10.0, 0.0, 0.0));
}

#[test]
fn every_stage_and_every_count_is_measured() {
    let mut app = measured(ClothPlugin::default());
    crowd(&mut app);
    run(&mut app, 3);
    assert_eq!(value(&app, &ClothDiagnosticsPlugin::PARTICLES), f64::from(81 + 81 + 25));
    let springs: f64 = [9.0, 9.0, 5.0].map(|n: f64| 2.0 * n * (n - 1.0) + (n - 1.0) * (n - 1.0)).into_iter().sum();
    assert_eq!(value(&app, &ClothDiagnosticsPlugin::SPRINGS), springs);
    let reports: Vec<ClothReport> = app.world_mut().query::<&ClothReport>().iter(app.world()).cloned().collect();
    assert!(reports[0].crossings > 0 && reports[0].crossings == reports[1].crossings, "{reports:?}");
    // A crossing of two cloths is one.
    assert_eq!(value(&app, &ClothDiagnosticsPlugin::CROSSINGS), f64::from(reports[0].crossings));
    assert_eq!(value(&app, &ClothDiagnosticsPlugin::CONTOURS), f64::from(reports[0].contours));
    let held = reports.iter().map(|r| r.held_frames).max().expect("reports");
    assert_eq!(value(&app, &ClothDiagnosticsPlugin::HELD_FRAMES), f64::from(held));
    for path in ClothDiagnosticsPlugin::TIMES.into_iter().chain(ClothDiagnosticsPlugin::COUNTS) {
        assert!(path.as_str().starts_with("cloth/") && value(&app, &path) >= 0.0, "{path}");
    }
    for path in [ClothDiagnosticsPlugin::INTEGRATE, ClothDiagnosticsPlugin::DETECT, ClothDiagnosticsPlugin::SYNC] {
        let ms = value(&app, &path);
        assert!(ms > 0.0 && ms < 1000.0, "{path} took {ms} ms");
    }
    let sum: f64 = reports.iter().map(|r| f64::from(r.integrate_ms)).sum();
    assert!((value(&app, &ClothDiagnosticsPlugin::INTEGRATE) - sum).abs() < 1.0e-3);
}

#[test]
fn contacts_with_bodies_and_cloth_are_counted() {
    let mut app = measured(ClothPlugin::default());
    app.world_mut().spawn((Transform::from_xyz(0.0, -0.02, 0.0), ClothCollider::ground()));
    spawn(&mut app, sheet(5), Transform::default());
    run(&mut app, 60);
    assert_eq!(value(&app, &ClothDiagnosticsPlugin::CONTACTS), 25.0);
}

#[test]
fn cloths_that_sleep_are_counted_until_they_wake() {
    let mut app = measured(ClothPlugin::default());
    app.world_mut().spawn(ClothCollider::ground());
    let lying = [0.0, 5.0].map(|x| spawn(&mut app, sheet(6), Transform::from_xyz(x, 0.006, 0.0)));
    let swinging = spawn(&mut app, sheet(6), (border(), Transform::from_xyz(10.0, 2.0, 0.0), ClothSleepDisabled));
    run(&mut app, 2);
    assert_eq!(value(&app, &ClothDiagnosticsPlugin::SLEEPING), 0.0);
    run(&mut app, 240);
    let asleep = lying.map(|cloth| report(&app, cloth).asleep);
    assert!(asleep == [true; 2] && !report(&app, swinging).asleep, "{asleep:?}");
    assert_eq!(value(&app, &ClothDiagnosticsPlugin::SLEEPING), 2.0);
    app.world_mut().get_mut::<Transform>(lying[0]).expect("a cloth").translation.y += 3.0;
    run(&mut app, 2);
    assert_eq!(value(&app, &ClothDiagnosticsPlugin::SLEEPING), 1.0);
}

#[test]
fn a_fixed_clock_is_measured_too() {
    let mut app = measured(ClothPlugin::new(FixedPostUpdate));
    spawn(&mut app, sheet(5), border());
    run(&mut app, 5);
    assert_eq!(value(&app, &ClothDiagnosticsPlugin::PARTICLES), 25.0);
    assert!(value(&app, &ClothDiagnosticsPlugin::INTEGRATE) > 0.0);
}

#[test]
#[should_panic(expected = "Add it: `app.add_plugins(ClothPlugin::default())`")]
fn without_cloth_the_plugin_says_what_to_write() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, ClothDiagnosticsPlugin));
    app.finish();
}
