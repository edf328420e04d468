//! What the solver sees, drawn.

use std::any::TypeId;

use bevy::gizmos::{GizmoAsset, GizmoHandles, GizmoPlugin};
use bevy::mesh::MeshPlugin;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_drape::prelude::*;
use bevy_drape::solver::state::ClothState;
use bevy_drape::{ClothDebug, ClothDebugPlugin, ClothGizmos};

use crate::common::*;

/// A scene with something of everything: a pinned sheet in the wind, one stuck in it, and one that lies on a ball.
fn scene(debug: ClothDebug) -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default(), MeshPlugin, GizmoPlugin));
    app.add_plugins((ClothDebugPlugin, ClothPlugin::default()));
    app.insert_resource(debug).insert_resource(ClothGlobalWind::new(Vec3::X));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(core::time::Duration::from_secs_f32(FRAME)));
    app.finish();
    app.cleanup();
    app.update();
    // They stay as they are.
    let still = (
        ClothUntangling { iterations: 0, ..default() },
        ClothCollision { contact: false, ..default() },
        ClothSolver { gravity_scale: 0.0, ..default() },
    );
    let through = Quat::from_rotation_x(1.5);
    let limits = ClothLimits { max_distance: ClothMap::Uniform(0.3), ..default() };
    spawn(&mut app, sheet(9), (border(), limits, still.clone()));
    // Narrower, so that both ends of the curve are its own, and the curve cuts a piece off.
    let upright = Transform::from_rotation(through).with_translation(Vec3::new(0.03, 0.0, 0.1)).with_scale(Vec3::splat(0.5));
    spawn(&mut app, sheet(9), (upright, border(), still));
    app.world_mut().spawn((Transform::from_xyz(9.0, -0.51, 0.0), ClothCollider::ball(0.5)));
    spawn(&mut app, sheet(9), Transform::from_xyz(9.0, 0.0, 0.0));
    app
}

/// The lines of the next frame.
fn lines(app: &mut App) -> Option<&GizmoAsset> {
    app.update();
    let handle = app.world().resource::<GizmoHandles>().handles().get(&TypeId::of::<ClothGizmos>())?.as_ref()?;
    app.world().resource::<Assets<GizmoAsset>>().get(handle)
}

/// Ends of the lines that are drawn in the next frame.
fn drawn(app: &mut App) -> Vec<Vec3> {
    let Some(asset) = lines(app) else { return Vec::new() };
    let buffer = asset.buffer().buffer();
    // A strip ends in what is no number.
    buffer.list_positions.iter().chain(buffer.strip_positions).filter(|p| p.is_finite()).copied().collect()
}

/// What the one colour of the lines of the next frame means, and how many lines there are.
fn meaning(app: &mut App) -> (String, usize) {
    let asset = lines(app).expect("lines");
    let colors = asset.buffer().buffer().list_colors;
    let color = *colors.first().expect("a line");
    assert!(colors.iter().all(|&c| c == color), "one cloth in two colours");
    let count = colors.len() / 2;
    let legend = app.world().resource::<ClothDebug>().legend();
    let line = legend.iter().find(|line| line.color.to_linear() == color);
    (line.unwrap_or_else(|| panic!("{color:?} is not in {legend:?}")).label.clone(), count)
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
    // In slow motion most frames are too short for cloth to move.
    let mut time = app.world_mut().resource_mut::<Time<Virtual>>();
    time.unpause();
    time.set_relative_speed(1.0e-4);
    run(&mut app, 3);
    let slow = drawn(&mut app);
    assert_eq!(slow.len(), moving.len(), "in slow motion");
}

#[test]
fn the_border_of_a_cloth_that_comes_to_rest_goes_through_the_colours_of_the_legend() {
    let mut app = scene(ClothDebug::only(["sleep"]));
    let others: Vec<Entity> = app.world_mut().query_filtered::<Entity, With<Cloth>>().iter(app.world()).collect();
    others.into_iter().for_each(|cloth| {
        app.world_mut().despawn(cloth);
    });
    app.insert_resource(ClothGlobalWind::new(Vec3::ZERO));
    app.world_mut().spawn((Transform::from_xyz(0.0, -0.5, 0.0), ClothCollider::ground()));
    let cloth = spawn(&mut app, sheet(9), Transform::from_xyz(0.0, -0.3, 0.0));
    run(&mut app, 5);
    let mut seen = Vec::new();
    for _ in 0..600 {
        let (label, lines) = meaning(&mut app);
        assert_eq!(lines, 4 * 8, "{label}");
        if seen.last() != Some(&label) {
            seen.push(label);
        }
        if report(&app, cloth).asleep {
            break;
        }
    }
    let labels: Vec<String> = app.world().resource::<ClothDebug>().legend().into_iter().map(|line| line.label).collect();
    seen.retain(|label| *label != labels[0]);
    seen.dedup();
    assert_eq!(seen, labels[1..4]);
    app.world_mut().get_mut::<ClothMaterial>(cloth).expect("a cloth").density *= 2.0;
    run(&mut app, 1);
    assert_ne!(meaning(&mut app).0, labels[3], "it woke");
    let mut particles = app.world_mut().get_mut::<ClothParticles>(cloth).expect("a cloth");
    let ClothState { positions, previous, .. } = particles.state_mut();
    positions.iter_mut().chain(previous).for_each(|x| x.x *= 1.6);
    run(&mut app, 2);
    assert_eq!(meaning(&mut app).0, labels[0], "{:?}", report(&app, cloth));
    let camera = app.world_mut().spawn((Camera::default(), Transform::default())).id();
    app.world_mut().entity_mut(cloth).insert(ClothLod::default());
    for (distance, label) in [(20.0, &labels[4]), (50.0, &labels[5]), (500.0, &labels[6])] {
        app.world_mut().get_mut::<Transform>(camera).expect("a camera").translation.y = distance;
        run(&mut app, 2);
        assert_eq!(meaning(&mut app).0, *label, "at {distance} m");
    }
}
