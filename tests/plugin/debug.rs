//! What the solver sees, drawn.

use std::any::TypeId;

use bevy::gizmos::{GizmoAsset, GizmoHandles, GizmoPlugin};
use bevy::mesh::MeshPlugin;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_drape::prelude::*;
use bevy_drape::{ClothDebug, ClothDebugPlugin, ClothGizmos};

use crate::common::*;

/// A scene with something of everything: a pinned sheet in the wind, one stuck in it, and one that lies on a ball.
fn scene(debug: ClothDebug) -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default(), MeshPlugin, GizmoPlugin));
    app.add_plugins((ClothDebugPlugin, ClothPlugin::default()));
    app.insert_resource(debug).insert_resource(GlobalWind::new(Vec3::X));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(core::time::Duration::from_secs_f32(FRAME)));
    app.finish();
    app.cleanup();
    app.update();
    // They stay as they are.
    let still = (
        Untangle { iterations: 0, ..default() },
        ClothCollision { contact: false, ..default() },
        ClothSolver { gravity_scale: 0.0, ..default() },
    );
    let through = Quat::from_rotation_x(1.5);
    spawn(&mut app, sheet(9), (border(), still.clone()));
    // Narrower, so that both ends of the curve are its own, and the curve cuts a piece off.
    let upright = Transform::from_rotation(through).with_translation(Vec3::new(0.03, 0.0, 0.1)).with_scale(Vec3::splat(0.5));
    spawn(&mut app, sheet(9), (upright, border(), still));
    app.world_mut().spawn((Transform::from_xyz(9.0, -0.51, 0.0), ClothCollider::ball(0.5)));
    spawn(&mut app, sheet(9), Transform::from_xyz(9.0, 0.0, 0.0));
    app
}

/// Ends of the lines that are drawn in the next frame.
fn drawn(app: &mut App) -> Vec<Vec3> {
    app.update();
    let handles = app.world().resource::<GizmoHandles>();
    let Some(Some(handle)) = handles.handles().get(&TypeId::of::<ClothGizmos>()) else { return Vec::new() };
    let Some(asset) = app.world().resource::<Assets<GizmoAsset>>().get(handle) else { return Vec::new() };
    let buffer = asset.buffer().buffer();
    // A strip ends in what is no number.
    buffer.list_positions.iter().chain(buffer.strip_positions).filter(|p| p.is_finite()).copied().collect()
}

#[test]
fn each_item_draws_something_and_without_items_nothing_is_drawn() {
    for item in ClothDebug::ITEMS {
        let mut app = scene(ClothDebug::only([item]));
        run(&mut app, 20);
        let points = drawn(&mut app);
        assert!(!points.is_empty(), "{item} drew nothing");
        let far = points.iter().map(|p| p.length()).fold(0.0, f32::max);
        assert!(far < 20.0, "{item} drew at {far} m");
        assert!(ClothDebug::only([item]).legend().iter().all(|line| !line.label.is_empty()));
        assert!(!ClothDebug::only([item]).legend().is_empty(), "{item} has no legend");
    }
    let mut app = scene(ClothDebug::none());
    run(&mut app, 20);
    assert_eq!(drawn(&mut app), []);
    assert_eq!(ClothDebug::none().legend(), []);
}

#[test]
fn contacts_stay_in_sight_while_time_stands_still() {
    let mut app = scene(ClothDebug::only(["contacts"]));
    run(&mut app, 30);
    let moving = drawn(&mut app);
    app.world_mut().resource_mut::<Time<Virtual>>().pause();
    run(&mut app, 3);
    let still = drawn(&mut app);
    assert!(!moving.is_empty() && still.len() == moving.len(), "{} ends of lines, then {}", moving.len(), still.len());
}
