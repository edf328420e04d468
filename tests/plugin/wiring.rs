//! How the plugin is put into an app.

use bevy::ecs::schedule::{LogLevel, ScheduleBuildSettings, ScheduleLabel, SingleThreadedExecutor};
use bevy::mesh::MeshPlugin;
use bevy::prelude::*;
use bevy_drape::prelude::*;

use crate::common::*;

#[test]
#[should_panic(expected = "app.add_plugins(ClothPlugin::default())")]
fn adding_the_plugin_twice_panics_with_the_line_to_write() {
    App::new()
        .add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default(), MeshPlugin))
        .add_plugins(ClothPlugin::default())
        .add_plugins(ClothPlugin::default());
}

#[test]
#[should_panic(expected = "cannot run in")]
fn a_schedule_that_runs_once_panics_with_the_line_to_write() {
    App::new()
        .add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default(), MeshPlugin))
        .add_plugins(ClothPlugin::new(Startup));
}

#[test]
#[should_panic(expected = "MeshPlugin")]
fn an_app_without_meshes_panics_with_the_line_to_write() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, ClothPlugin::default()));
    app.finish();
}

#[test]
fn every_public_component_works_in_scenes_and_inspectors() {
    use bevy::ecs::reflect::ReflectComponent;
    use bevy::reflect::std_traits::ReflectDefault;
    let app = app();
    let registry = app.world().resource::<AppTypeRegistry>().read();
    for name in [
        "Cloth",
        "ClothMaterial",
        "ClothSolver",
        "ClothPins",
        "ClothCollider",
        "ClothCollision",
        "ClothCollisionLayers",
        "ClothWind",
        "ClothWindZone",
        "ClothStatus",
        "ClothReport",
        "ClothBuildReport",
    ] {
        let found = registry.get_with_short_type_path(name).unwrap_or_else(|| panic!("{name} is not registered"));
        assert!(found.data::<ReflectComponent>().is_some() && found.data::<ReflectDefault>().is_some(), "{name}");
    }
}

#[test]
fn our_systems_have_no_ambiguous_order() {
    for plugin in [ClothPlugin::default(), ClothPlugin::new(FixedPostUpdate)] {
        let mut app = App::new();
        app.add_plugins((
            MinimalPlugins,
            TransformPlugin,
            AssetPlugin::default(),
            MeshPlugin,
            bevy::camera::visibility::VisibilityPlugin,
            plugin,
        ));
        for label in [PostUpdate.intern(), FixedPostUpdate.intern()] {
            app.edit_schedule(label, |schedule| {
                schedule.set_build_settings(ScheduleBuildSettings { ambiguity_detection: LogLevel::Error, ..default() });
            });
        }
        app.finish();
        app.cleanup();
        run(&mut app, 2);
    }
}

#[test]
fn one_thread_and_many_give_the_same_bits() {
    let fly = |single: bool| {
        let mut app = app();
        if single {
            app.edit_schedule(PostUpdate, |schedule| {
                schedule.set_executor(SingleThreadedExecutor::new());
            });
        }
        app.insert_resource(ClothGlobalWind::new(Vec3::new(4.0, 0.0, 1.0)));
        app.world_mut().spawn((Transform::from_xyz(0.0, -0.5, 0.3), ClothCollider::ball(0.2)));
        let cloths: Vec<Entity> =
            (0..6).map(|i| spawn(&mut app, sheet(6 + i), (border(), Transform::from_xyz(0.1 * i as f32, 0.0, 0.0)))).collect();
        run(&mut app, 60);
        cloths.iter().map(|&c| positions(&app, c)).collect::<Vec<_>>()
    };
    let first = fly(false);
    assert_eq!(first, fly(false), "a second run");
    assert_eq!(first, fly(true), "a single thread");
}

#[test]
fn it_runs_in_lockstep_with_a_fixed_clock() {
    let mut app = app_with(ClothPlugin::new(FixedPostUpdate));
    let cloth = spawn(&mut app, sheet(8), border());
    run(&mut app, 130);
    assert_eq!(status(&app, cloth), ClothStatus::Active);
    let bottom = lowest(&world_positions(&app, cloth));
    assert!((-1.1..-0.8).contains(&bottom), "lowest point after 2 s: {bottom} m");
}
