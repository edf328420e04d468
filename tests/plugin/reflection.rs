//! Components in inspectors, scenes and files.

use std::collections::BTreeMap;
use std::path::Path;

use bevy::ecs::entity::EntityHashMap;
use bevy::ecs::reflect::{ReflectComponent, ReflectResource};
use bevy::ecs::world::CommandQueue;
use bevy::math::DVec3;
use bevy::mesh::MeshPlugin;
use bevy::prelude::*;
use bevy::reflect::serde::{TypedReflectDeserializer, TypedReflectSerializer};
use bevy::reflect::{TypeRegistration, TypeRegistry};
use bevy::scene::ScenePlugin;
use bevy::time::TimeUpdateStrategy;
use bevy::world_serialization::serde::WorldDeserializer;
use bevy::world_serialization::{DynamicWorldBuilder, WorldSerializationPlugin};
use bevy_drape::prelude::*;
use bevy_drape::{ClothBuildReport, ClothErrorKind, ClothPreset, ClothPresetHandle};
use bevy_inspector_egui::DefaultInspectorConfigPlugin;
use bevy_inspector_egui::bevy_inspector::ui_for_world;
use bevy_inspector_egui::egui;
use bevy_inspector_egui::reflect_inspector::{Context, InspectorUi};
use serde::de::DeserializeSeed;

use crate::common::*;

/// What the simulation keeps on a cloth: nothing to be set or saved, since a loaded cloth binds anew.
const KEPT: [&str; 2] = ["ClothRest", "ClothParticles"];

/// Names of public types in the sources that derive something.
fn deriving(what: &str) -> Vec<String> {
    fn read(folder: &Path, what: &str, names: &mut Vec<String>) {
        for entry in std::fs::read_dir(folder).expect("a folder of sources").flatten() {
            let path = entry.path();
            if path.is_dir() {
                read(&path, what, names);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let text = std::fs::read_to_string(&path).expect("a source");
                for (at, _) in text.match_indices("\n#[derive(") {
                    let rest = &text[at + 1..];
                    let derives = rest[..rest.find(")]").unwrap_or(0)].trim_start_matches("#[derive(").split(',');
                    let item = rest.lines().find(|line| line.starts_with("pub")).unwrap_or("");
                    let name = item.strip_prefix("pub struct ").or(item.strip_prefix("pub enum "));
                    if let Some(name) = name
                        && derives.into_iter().any(|d| d.trim() == what)
                    {
                        names.push(name.split(|c: char| !c.is_alphanumeric()).next().unwrap_or("").to_owned());
                    }
                }
            }
        }
    }
    let mut names = Vec::new();
    read(&drape_tests::root().join("src"), what, &mut names);
    names.sort();
    names
}

/// Ours in a registry, by name.
fn ours(registry: &TypeRegistry) -> BTreeMap<String, &TypeRegistration> {
    let ours = registry.iter().filter(|r| r.type_info().type_path().starts_with("bevy_drape::"));
    ours.map(|r| (r.type_info().type_path_table().short_path().to_owned(), r)).collect()
}

/// An app with scenes of both kinds and what the inspector needs.
fn inspected() -> App {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        TransformPlugin,
        AssetPlugin::default(),
        MeshPlugin,
        WorldSerializationPlugin,
        ScenePlugin,
    ));
    app.add_plugins((DefaultInspectorConfigPlugin, ClothPlugin::default()));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(core::time::Duration::from_secs_f32(FRAME)));
    app.finish();
    app.cleanup();
    app.update();
    app
}

#[test]
fn every_public_component_is_registered_made_inserted_and_written_through_reflection() {
    let mut app = inspected();
    let names: Vec<String> = deriving("Component").into_iter().filter(|name| !KEPT.contains(&name.as_str())).collect();
    assert!(names.len() >= 16, "{names:?}");
    let registry = app.world().resource::<AppTypeRegistry>().clone();
    let registry = registry.read();
    let ours = ours(&registry);
    for name in &names {
        let registration = ours.get(name).unwrap_or_else(|| panic!("{name} is not registered"));
        let made = registration.data::<ReflectDefault>().unwrap_or_else(|| panic!("{name} has no default")).default();
        let component = registration.data::<ReflectComponent>().unwrap_or_else(|| panic!("{name} is no component"));
        let entity = app.world_mut().spawn_empty().id();
        component.insert(&mut app.world_mut().entity_mut(entity), made.as_partial_reflect(), &registry);
        let inserted = component.reflect(app.world().entity(entity)).unwrap_or_else(|| panic!("{name} was not inserted"));
        assert_eq!(inserted.reflect_partial_eq(made.as_partial_reflect()), Some(true), "{name}");
        if registration.data::<ReflectSerialize>().is_none() {
            // A handle is written as its path, by what knows of assets: see the scene below.
            assert_eq!(name, "ClothPresetHandle");
            continue;
        }
        let text = ron::to_string(&TypedReflectSerializer::new(made.as_partial_reflect(), &registry))
            .unwrap_or_else(|error| panic!("{name} cannot be written: {error}"));
        let seed = TypedReflectDeserializer::new(registration, &registry);
        let mut reader = ron::Deserializer::from_str(&text).expect("RON");
        let read = seed.deserialize(&mut reader).unwrap_or_else(|error| panic!("{name} cannot be read from {text}: {error}"));
        assert_eq!(read.reflect_partial_eq(made.as_partial_reflect()), Some(true), "{name}: {text}");
    }
}

#[test]
fn every_public_resource_with_settings_is_registered() {
    let app = inspected();
    let registry = app.world().resource::<AppTypeRegistry>().read();
    let ours = ours(&registry);
    for name in ["ClothDebug", "ClothGravity", "ClothGlobalWind", "ClothPickingSettings"] {
        assert!(deriving("Resource").iter().any(|n| n == name), "{name}");
        let registration = ours.get(name).unwrap_or_else(|| panic!("{name} is not registered"));
        assert!(registration.data::<ReflectResource>().is_some(), "{name}");
        assert!(registration.data::<ReflectDefault>().is_some(), "{name}");
        assert!(registration.data::<ReflectSerialize>().is_some(), "{name}");
    }
}

/// All words on a screen.
fn words(show: impl FnMut(&mut egui::Ui)) -> String {
    fn of(shape: &egui::Shape, words: &mut String) {
        match shape {
            egui::Shape::Text(text) => words.push_str(&format!("{}\n", text.galley.text())),
            egui::Shape::Vec(shapes) => shapes.iter().for_each(|shape| of(shape, words)),
            _ => {}
        }
    }
    let context = egui::Context::default();
    let input = egui::RawInput {
        screen_rect: Some(egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(1200.0, 4000.0))),
        ..Default::default()
    };
    let output = context.run_ui(input, show);
    let mut words = String::new();
    output.shapes.iter().for_each(|clipped| of(&clipped.shape, &mut words));
    words
}

/// What the inspector says where it cannot show something.
const HELPLESS: [&str; 3] = ["is not registered", "you need to register", "not backed by"];

#[test]
fn the_inspector_shows_every_public_component() {
    let mut app = inspected();
    let handle = Handle::<ClothPreset>::default();
    app.world_mut().spawn(ClothPresetHandle(handle));
    let registry = app.world().resource::<AppTypeRegistry>().clone();
    let registry = registry.read();
    let ours = ours(&registry);
    let names = deriving("Component").into_iter().filter(|name| !KEPT.contains(&name.as_str()));
    for name in names.chain(["ClothDebug", "ClothGravity", "ClothGlobalWind", "ClothPickingSettings"].map(str::to_owned)) {
        let mut value = ours[&name].data::<ReflectDefault>().expect("a default").default();
        let world = app.world_mut();
        let text = words(|ui| {
            let mut queue = CommandQueue::default();
            let mut context = Context { world: Some((&mut *world).into()), queue: Some(&mut queue) };
            InspectorUi::for_bevy(&registry, &mut context).ui_for_reflect(value.as_partial_reflect_mut(), ui);
        });
        assert!(!HELPLESS.iter().any(|words| text.contains(words)), "{name}: {text}");
        for field in value
            .reflect_ref()
            .as_struct()
            .into_iter()
            .flat_map(|s| (0..s.field_len()).filter_map(|i| s.name_at(i).map(str::to_owned)).collect::<Vec<_>>())
        {
            assert!(text.contains(&field), "{name}.{field}: {text}");
        }
    }
}

#[test]
fn the_inspector_shows_a_world_with_a_simulated_cloth() {
    let mut app = inspected();
    spawn(&mut app, sheet(5), (Name::new("curtain"), border(), ClothCollisionLayers::DEFAULT));
    app.world_mut().spawn((Name::new("ball"), ClothCollider::ball(0.2)));
    run(&mut app, 3);
    let world = app.world_mut();
    let text = words(|ui| ui_for_world(world, ui));
    assert!(text.contains("Entities"), "{text}");
    // Nothing was changed by looking at it.
    run(&mut app, 3);
}

/// Some of everything that can be set, nothing at its default.
fn furnish(world: &mut World) -> [Entity; 3] {
    let hand = world.spawn((Name::new("hand"), Transform::from_xyz(1.0, 2.0, 3.0))).id();
    let server = world.resource::<AssetServer>().clone();
    let cloth = world
        .spawn((
            Name::new("cloth"),
            Cloth,
            ClothMaterial { strain_limit: f32::INFINITY, ..ClothMaterial::DENIM },
            ClothPins::vertices([1, 2])
                .to(hand)
                .and(ClothPins::weights([(3, 0.5)]))
                .and(ClothPins::color(ClothColorChannel::G))
                .and(ClothPins::attribute("_PIN").weighted(0.25)),
            ClothSolver { substep_rate: 480.0, teleport: ClothTeleportMode::Reset, ..default() },
            (
                ClothSleep { delay: 2.0, ..default() },
                ClothLod { unseen: ClothDetail::Still, ..default() },
                ClothLimits { max_distance: ClothMap::attribute("_CLOTH_PAINT.g", 0.0, 0.3), scale: 0.5, ..default() },
                ClothDrive { frequency: ClothMap::color(ClothColorChannel::A, 1.0, 4.0), damping_ratio: 2.0 },
                ClothContactEvents { patience: 0.5 },
                (ClothDisabled, ClothSleepDisabled, ClothUntanglingDisabled),
                ClothDraggable { radius: 0.2, ..default() },
                (
                    ClothInertia { linear: 0.5, space: Some(hand), ..default() },
                    ClothPriority(3.0),
                    (ClothBlend { weight: 0.5, rate: 2.0 }, ClothWarmUp { seconds: 0.5 }, ClothReset),
                ),
            ),
            ClothCollision { garment_layer: -2, contact: false, ..default() },
            ClothCollisionLayers::new(0b110, 0b011),
            ClothUntangling { iterations: 11, ..default() }.with_method(ClothUntanglingMethod::LocalGradient),
            ClothSkipFrame { policy: ClothSkipPolicy::UntilClean { max: 7 }, ..default() },
            (ClothWind::new(Vec3::new(1.0, 0.0, -2.0)), ClothSubdivision::new(0.03), ClothDecimation::new(0.02)),
            ClothPresetHandle(server.load("fabric.cloth.ron")),
            ClothStatus::Waiting(ClothWaitingFor::Asset),
            ClothError { kind: ClothErrorKind::NoPositions, detail: "a \"quoted\" word".into() },
            (
                ClothReport { crossings: 4, clamped: vec!["density".into()], ..default() },
                ClothBuildReport { bad_pins: vec![9], ..default() },
            ),
        ))
        .id();
    let parts = [(Vec3::X, Quat::IDENTITY, ClothColliderShape::Cone { radius: 0.1, height: 0.3 })];
    let body = world
        .spawn((
            Name::new("body"),
            (ClothCollider::compound(parts).with_friction(0.1).with_margin(0.01), ClothColliderDisabled),
            ClothWindZone::cuboid(Vec3::ONE, Vec3::Y),
            (ClothBody { margin: 0.03, ..default() }, ClothCharacter),
            (ClothCoupling::TwoWay, ClothCollisionDisabled, ClothReaction { linear: Vec3::Y, ..default() }),
            ClothRigidBody { inverse_mass: Vec3::ONE, ..default() },
        ))
        .id();
    let shown = (ClothPiece { cloth, first: 4 }, ClothRenderMesh { cloth });
    world.entity_mut(body).insert((ClothGrab { cloth, target: Vec3::Z, ..default() }, shown));
    let pose = ClothPose { positions: vec![DVec3::X], velocities: vec![Vec3::Y] };
    world.entity_mut(body).insert(pose);
    [hand, cloth, body]
}

/// Components of ours on an entity, by name.
fn components(world: &World, registry: &TypeRegistry, entity: Entity) -> BTreeMap<String, Box<dyn PartialReflect>> {
    let components = ours(registry).into_iter().filter_map(|(name, registration)| {
        let value = registration.data::<ReflectComponent>()?.reflect(world.entity(entity))?;
        Some((name, value.to_dynamic()))
    });
    components.collect()
}

#[test]
fn a_scene_with_every_component_is_saved_and_loaded_equal() {
    let mut app = inspected();
    app.world_mut().insert_resource(ClothGravity(Vec3::new(0.0, -1.62, 0.0)));
    app.world_mut().insert_resource(ClothGlobalWind { seed: 7, ..ClothGlobalWind::new(Vec3::Z) });
    let spawned = furnish(app.world_mut());
    let registry = app.world().resource::<AppTypeRegistry>().clone();
    let registry = registry.read();
    let text = DynamicWorldBuilder::from_world(app.world(), &registry)
        .allow_resource::<ClothGravity>()
        .allow_resource::<ClothGlobalWind>()
        .extract_entities(spawned.into_iter())
        .extract_resources()
        .build()
        .serialize(&registry)
        .expect("a scene that can be written");

    let mut other = inspected();
    // So that entities get other numbers.
    other.world_mut().spawn_batch(vec![(); 7]);
    let mut server = other.world().resource::<AssetServer>().clone();
    let scene = WorldDeserializer { type_registry: &registry, load_from_path: &mut server }
        .deserialize(&mut ron::Deserializer::from_str(&text).expect("RON"))
        .unwrap_or_else(|error| panic!("{error} in {text}"));
    let mut map = EntityHashMap::default();
    scene.write_to_world_with(other.world_mut(), &mut map, &registry).expect("a scene that can be spawned");

    let [hand, cloth, body] = spawned.map(|entity| map[&entity]);
    assert_ne!(cloth, spawned[1]);
    let mut seen = Vec::new();
    for (old, new) in spawned.into_iter().zip([hand, cloth, body]) {
        let (old, new) = (components(app.world(), &registry, old), components(other.world(), &registry, new));
        assert_eq!(old.keys().collect::<Vec<_>>(), new.keys().collect::<Vec<_>>());
        for (name, old) in &old {
            let with_entities =
                ["ClothGrab", "ClothInertia", "ClothPiece", "ClothPins", "ClothPresetHandle", "ClothRenderMesh"];
            if !with_entities.contains(&name.as_str()) {
                assert_eq!(old.reflect_partial_eq(&*new[name]), Some(true), "{name}: {old:?} is now {:?}", new[name]);
            }
        }
        seen.extend(old.into_keys());
    }
    for name in deriving("Component") {
        assert!(seen.contains(&name) || KEPT.contains(&name.as_str()), "{name} is not in the scene");
    }
    assert_eq!(other.world().get::<ClothGrab>(body).map(|grab| grab.cloth), Some(cloth));
    assert_eq!(other.world().get::<ClothPiece>(body), Some(&ClothPiece { cloth, first: 4 }));
    assert_eq!(other.world().get::<ClothRenderMesh>(body), Some(&ClothRenderMesh { cloth }));
    let inertia = ClothInertia { linear: 0.5, space: Some(hand), ..default() };
    assert_eq!(other.world().get::<ClothInertia>(cloth), Some(&inertia));
    // The hand is another entity now, and the cloth hangs on that.
    let [old, mut new] =
        [(&app, spawned[1]), (&other, cloth)].map(|(app, e)| app.world().get::<ClothPins>(e).expect("pins").clone());
    assert_eq!(new.sets[0].target, Some(hand));
    new.sets[0].target = old.sets[0].target;
    assert_eq!(old, new);
    let path = |app: &App, e| app.world().get::<ClothPresetHandle>(e).and_then(|h| h.0.path().map(ToString::to_string));
    assert_eq!(path(&other, cloth), path(&app, spawned[1]));
    assert_eq!(other.world().resource::<ClothGravity>(), app.world().resource::<ClothGravity>());
    assert_eq!(other.world().resource::<ClothGlobalWind>(), app.world().resource::<ClothGlobalWind>());
}

#[test]
fn a_loaded_cloth_is_simulated() {
    let mut app = inspected();
    let cloth = spawn(&mut app, sheet(5), ClothPins::vertices([0, 4]));
    run(&mut app, 20);
    let registry = app.world().resource::<AppTypeRegistry>().clone();
    let scene =
        DynamicWorldBuilder::from_world(app.world(), &registry.read()).deny_component::<Mesh3d>().extract_entity(cloth).build();
    let mut map = EntityHashMap::default();
    scene.write_to_world(app.world_mut(), &mut map).expect("a scene that can be spawned");
    let twin = map[&cloth];
    assert_ne!(twin, cloth);
    // Or they would lie on each other.
    app.world_mut().despawn(cloth);
    let mesh = add(&mut app, sheet(5));
    app.world_mut().entity_mut(twin).insert(Mesh3d(mesh));
    run(&mut app, 20);
    assert_eq!(status(&app, twin), ClothStatus::Active);
    assert_eq!(report(&app, twin).pinned, 2);
    assert!(lowest(&particles(&app, twin)) < -0.02);
}

#[test]
fn pins_by_a_predicate_are_an_error_to_save_not_a_panic() {
    let mut app = inspected();
    let cloth = app.world_mut().spawn(border()).id();
    let registry = app.world().resource::<AppTypeRegistry>().read();
    let scene = DynamicWorldBuilder::from_world(app.world(), &registry).extract_entity(cloth).build();
    let error = scene.serialize(&registry).expect_err("a function cannot be written");
    assert!(error.to_string().contains("Position"), "{error}");
}

#[test]
fn components_are_written_in_bsn() {
    let mut app = inspected();
    let scene = bsn! {
        #Curtain
        Cloth
        ClothMaterial { density: 0.3, thickness: 0.004 }
        ClothSolver { substep_rate: 480.0, teleport: {ClothTeleportMode::Reset} }
        ClothCollision { garment_layer: 2 }
        ClothCollisionLayers { memberships: 2 }
        ClothUntangling { iterations: 6 }
        ClothSkipFrame { max_held_frames: 1 }
        ClothPins { sets: {ClothPins::vertices([0, 4]).sets} }
        ClothPresetHandle("fabric.cloth.ron")
        Children [
            (ClothCollider { shape: {ClothColliderShape::Ball { radius: 0.25 }}, margin: 0.01 } ClothWindZone { velocity: {Vec3::X} }),
        ]
    };
    let entity = app.world_mut().spawn_scene(scene).expect("a scene that can be spawned").id();
    let world = app.world();
    assert_eq!(world.get::<ClothMaterial>(entity), Some(&ClothMaterial { density: 0.3, thickness: 0.004, ..default() }));
    assert_eq!(
        world.get::<ClothSolver>(entity),
        Some(&ClothSolver { substep_rate: 480.0, teleport: ClothTeleportMode::Reset, ..default() })
    );
    assert_eq!(world.get::<ClothCollision>(entity).map(|c| c.garment_layer), Some(2));
    assert_eq!(world.get::<ClothCollisionLayers>(entity), Some(&ClothCollisionLayers::new(2, u32::MAX)));
    assert_eq!(world.get::<ClothUntangling>(entity).map(|u| (u.iterations, u.stall_iterations)), Some((6, 10)));
    assert_eq!(world.get::<ClothSkipFrame>(entity).map(|s| s.max_held_frames), Some(1));
    assert_eq!(world.get::<ClothPins>(entity), Some(&ClothPins::vertices([0, 4])));
    let path = world.get::<ClothPresetHandle>(entity).and_then(|h| h.0.path().map(ToString::to_string));
    assert_eq!(path.as_deref(), Some("fabric.cloth.ron"));
    assert!(world.get::<ClothReport>(entity).is_some(), "what a cloth requires comes with it");
    let child = world.get::<Children>(entity).and_then(|c| c.first().copied()).expect("a child");
    assert_eq!(world.get::<ClothCollider>(child), Some(&ClothCollider::ball(0.25).with_margin(0.01)));
    assert_eq!(world.get::<ClothWindZone>(child).map(|z| z.velocity), Some(Vec3::X));
    // And it is simulated.
    let mesh = add(&mut app, sheet(5));
    app.world_mut().entity_mut(entity).insert(Mesh3d(mesh));
    run(&mut app, 10);
    assert_eq!(status(&app, entity), ClothStatus::Active);
}
