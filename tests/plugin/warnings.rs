//! One warning for one cause, with the name of the entity and the cure.

use bevy::ecs::schedule::SingleThreadedExecutor;
use bevy::prelude::*;
use bevy_drape::prelude::*;

use crate::common::log::Log;
use crate::common::*;

/// What `act` warned of, line by line. The app runs in this thread, because the log is one of this thread.
pub fn warnings(mut app: App, act: impl FnOnce(&mut App)) -> Vec<String> {
    app.edit_schedule(PostUpdate, |schedule| {
        schedule.set_executor(SingleThreadedExecutor::new());
    });
    let log = Log::default();
    log.listen(|| act(&mut app));
    log.read()
}

/// Whatever else runs beside it; without what [`Log::listen`] does for every thread it fails where nothing else listens.
#[test]
fn a_warning_that_a_thread_without_a_listener_comes_by_first_is_heard() {
    let warn = || bevy::log::warn!("bevy_drape is tested");
    let log = Log::default();
    log.listen(|| {
        std::thread::spawn(warn).join().expect("a warning");
        warn();
    });
    assert_eq!(log.read().len(), 1);
}

#[test]
fn a_mesh_that_cannot_be_a_cloth_is_one_warning_with_name_and_cure() {
    let lines = warnings(app(), |app| {
        let mesh = Mesh::new(bevy::mesh::PrimitiveTopology::LineList, default());
        spawn(app, mesh, Name::new("washing line"));
        run(app, 400);
    });
    assert_eq!(lines.len(), 1, "{lines:#?}");
    assert!(lines[0].contains("washing line") && lines[0].contains("`TriangleList`"), "{lines:#?}");
}

#[test]
fn each_setting_out_of_range_is_one_warning() {
    let lines = warnings(app(), |app| {
        let material = ClothMaterial { density: -1.0, damping: f32::NAN, ..default() };
        spawn(app, sheet(5), (material, Name::new("flag"), border()));
        run(app, 100);
    });
    assert_eq!(lines.len(), 2, "{lines:#?}");
    assert!(lines[0].contains("flag") && lines[0].contains("`density`") && lines[1].contains("`damping`"), "{lines:#?}");
}

#[test]
fn resources_out_of_range_are_named_and_a_zone_is_not_turned_inside_out() {
    let lines = warnings(app(), |app| {
        app.insert_resource(ClothGlobalWind::new(Vec3::X * 1.0e4));
        app.insert_resource(ClothGravity(Vec3::splat(f32::NAN)));
        app.world_mut().spawn((ClothWindZone::cuboid(Vec3::new(2.0, -1.0, 2.0), Vec3::X), Name::new("draught")));
        spawn(app, sheet(5), border());
        run(app, 100);
    });
    assert_eq!(lines.len(), 3, "{lines:#?}");
    let told = |what: &[&str]| lines.iter().any(|line| what.iter().all(|what| line.contains(what)));
    assert!(told(&["`ClothGlobalWind`", "`wind.velocity`"]) && told(&["`ClothGravity`"]), "{lines:#?}");
    assert!(told(&["draught", "`zone.half_size`"]), "{lines:#?}");
}

#[test]
fn a_missing_plugin_is_one_warning_that_names_it() {
    let log = Log::default();
    log.listen(|| {
        let mut world = World::new();
        for name in ["flag", "sail"] {
            world.spawn((Cloth, Name::new(name)));
        }
    });
    let lines = log.read();
    assert_eq!(lines.len(), 1, "{lines:#?}");
    assert!(lines[0].contains("flag") && lines[0].contains("`ClothPlugin`"), "{lines:#?}");
    let lines = warnings(app(), |app| {
        for name in ["flag", "sail"] {
            spawn(app, sheet(5), (border(), ClothDraggable::default(), Name::new(name)));
        }
        run(app, 10);
    });
    assert_eq!(lines.len(), 1, "{lines:#?}");
    assert!(lines[0].contains("`ClothDraggable`") && lines[0].contains("`ClothPickingPlugin`"), "{lines:#?}");
}

#[test]
fn waiting_is_silent_for_five_seconds_and_then_one_warning() {
    let lines = warnings(app(), |app| {
        spawn(app, sheet(5), (Transform::from_scale(Vec3::ZERO), Name::new("growing")));
        run(app, 280);
    });
    assert_eq!(lines, Vec::<String>::new(), "within 5 s");
    let lines = warnings(app(), |app| {
        spawn(app, sheet(5), (Transform::from_scale(Vec3::ZERO), Name::new("growing")));
        run(app, 900);
    });
    assert_eq!(lines.len(), 1, "{lines:#?}");
    assert!(lines[0].contains("growing") && lines[0].contains("scale"), "{lines:#?}");
}

#[test]
fn cleaning_a_mesh_is_not_worth_a_warning() {
    let lines = warnings(app(), |app| {
        let mut split = sheet(5);
        split.duplicate_vertices();
        spawn(app, split, ClothPins::vertices([0]));
        run(app, 100);
    });
    assert_eq!(lines, Vec::<String>::new());
}

#[test]
fn sizes_of_colliders_are_named_as_they_were_given() {
    let lines = warnings(app(), |app| {
        app.world_mut().spawn((ClothCollider::cuboid(1.0, -1.0, 1.0), Name::new("crate")));
        app.world_mut().spawn((ClothCollider::capsule(0.1, -0.5), Name::new("arm")));
        app.world_mut().spawn((ClothCollider::cylinder(0.0, 1.0), Name::new("drum")));
        run(app, 5);
    });
    for (name, what) in [("crate", "size y is -1:"), ("arm", "length is -0.5:"), ("drum", "radius is 0:")] {
        assert!(lines.iter().any(|line| line.contains(name) && line.contains(what)), "{lines:#?}");
    }
}

/// Those of other crates are not checked when they are made.
#[test]
fn shapes_of_parry_that_are_none_are_one_warning_and_push_nothing() {
    use bevy_drape::solver::body::SharedShape;
    let lines = warnings(app(), |app| {
        let shapes = [
            SharedShape::round_cylinder(0.2, 0.2, -0.1),
            SharedShape::halfspace(Vec3::splat(f32::NAN)),
            SharedShape::ball(0.2),
        ];
        for (shape, name) in shapes.into_iter().zip(["drum", "floor", "marble"]) {
            app.world_mut().spawn((Transform::default(), ClothCollider::parry(shape), Name::new(name)));
        }
        let cloth = spawn(app, sheet(5), border());
        run(app, 60);
        assert!(finite(app, cloth) && report(app, cloth).restores == 0);
    });
    assert_eq!(lines.len(), 2, "{lines:#?}");
    assert!(lines[0].contains("drum") && lines[0].contains("border radius") && lines[1].contains("floor"), "{lines:#?}");
}

#[test]
fn bodies_with_masses_that_are_none_and_places_that_are_nowhere_are_named_with_a_cure() {
    let lines = warnings(app(), |app| {
        for (mass, name) in [(-1.0, "balloon"), (f32::NAN, "ghost"), (0.0, "wall"), (f32::INFINITY, "world")] {
            let body = (ClothCollider::ball(0.1), ClothCoupling::TwoWay, ClothRigidBody::ball(mass, 0.1));
            app.world_mut().spawn((body, Name::new(name)));
        }
        let crate_ = app.world_mut().spawn((ClothCollider::ball(0.1), Name::new("crate"))).id();
        run(app, 5);
        app.world_mut().get_mut::<Transform>(crate_).expect("a crate").translation.x = f32::NAN;
        run(app, 5);
    });
    let told = |name: &str, what: &str, cure: &str| {
        let lines = lines.iter().filter(|line| line.contains(&format!("`{name}`")) && line.contains(what));
        lines.filter(|line| line.contains(cure)).count()
    };
    for name in ["balloon", "ghost"] {
        assert_eq!(told(name, "`inverse_mass`", "0 to 1000000"), 1, "{lines:#?}");
        assert_eq!(told(name, "`inverse_inertia`", "set numbers that are finite"), 1, "{lines:#?}");
    }
    assert_eq!(told("crate", "`transform`", "set numbers that are finite"), 1, "{lines:#?}");
    assert_eq!(lines.len(), 5, "{lines:#?}");
}

#[test]
fn a_collider_whose_mesh_never_comes_is_one_warning_after_five_seconds() {
    let lines = |frames| {
        warnings(app(), |app| {
            app.world_mut().spawn((ClothCollider::fit_mesh(ClothMeshFit::Cuboid), Name::new("rock")));
            let wrong = add(app, Mesh::new(bevy::mesh::PrimitiveTopology::LineList, default()));
            app.world_mut().spawn((Mesh3d(wrong), ClothCollider::fit_mesh(ClothMeshFit::Cuboid), Name::new("wire")));
            run(app, frames);
        })
        .into_iter()
        // Systems of other tests may borrow this thread.
        .filter(|line| line.contains("`rock`") || line.contains("`wire`"))
        .collect::<Vec<_>>()
    };
    assert_eq!(lines(280).len(), 1, "only the mesh that is wrong within 5 s");
    let lines = lines(900);
    assert_eq!(lines.len(), 2, "{lines:#?}");
    assert!(lines[0].contains("wire") && lines[1].contains("rock") && lines[1].contains("Mesh3d"), "{lines:#?}");
}

#[test]
fn limits_of_teleports_and_weights_of_pins_that_are_out_of_range_are_named() {
    for bad in [f32::NAN, -1.0, f32::INFINITY] {
        let lines = warnings(app(), |app| {
            let solver = ClothSolver { teleport_distance: bad, teleport_angle: bad, ..default() };
            let pins = border().and(ClothPins::vertices([24]).weighted(bad));
            let cloth = spawn(app, sheet(5), (pins, solver, Name::new("loose")));
            run(app, 20);
            assert_eq!(report(app, cloth).clamped, ["teleport_distance", "teleport_angle", "ClothPinSet::weight"], "{bad}");
            assert!(finite(app, cloth));
        });
        assert_eq!(lines.iter().filter(|line| line.contains("`loose`")).count(), 3, "{lines:#?}");
        let told = format!("in place of {bad}");
        assert!(lines.iter().filter(|line| line.contains("`loose`")).all(|line| line.contains(&told)), "{lines:#?}");
    }
}

#[test]
fn waiting_for_something_else_is_a_new_patience() {
    let lines = warnings(app(), |app| {
        let hand = app.world_mut().spawn_empty().id();
        let pins = border().to(hand);
        let cloth = spawn(app, sheet(5), (Transform::from_scale(Vec3::ZERO), pins, Name::new("patient")));
        run(app, 200);
        app.world_mut().get_mut::<Transform>(cloth).expect("a transform").scale = Vec3::ONE;
        run(app, 200);
        assert_eq!(status(app, cloth), ClothStatus::Waiting(ClothWaitingFor::Target));
    });
    assert_eq!(lines.iter().filter(|line| line.contains("`patient`")).count(), 0, "{lines:#?}");
}

#[test]
fn a_mesh_that_moves_as_a_board_is_one_warning_with_the_cure() {
    for (subdivisions, expected) in [(0, 1), (1, 0)] {
        let mesh = Plane3d::default().mesh().size(1.0, 1.0).subdivisions(subdivisions).build();
        let told = warnings(app(), |app| {
            spawn(app, mesh, Name::new("plane"));
            run(app, 3);
        });
        assert_eq!(told.len(), expected, "{told:?}");
        assert!(told.iter().all(|line| line.contains("`plane`") && line.contains("ClothSubdivision")), "{told:?}");
    }
    let told = warnings(app(), |app| {
        spawn(app, sheet(4), ClothDecimation::new(10.0));
        run(app, 3);
    });
    assert!(told.len() == 1 && told[0].contains("shorter `shortest_edge`"), "{told:?}");
}

#[test]
fn pins_that_hold_nothing_are_named_once() {
    let lines = warnings(app(), |app| {
        let nowhere = ClothPins::where_position(|p| p.y > 4.9);
        spawn(app, sheet(5), (nowhere, Transform::from_xyz(0.0, 5.0, 0.0), Name::new("loose")));
        spawn(app, sheet(5), Name::new("free"));
        run(app, 20);
    });
    let of = |name: &str| lines.iter().filter(|line| line.contains(name)).cloned().collect::<Vec<_>>();
    let loose = of("`loose`");
    assert!(loose.len() == 1 && loose[0].contains("space of the mesh"), "{lines:#?}");
    assert!(of("`free`").is_empty(), "{lines:#?}");
}

#[test]
fn layers_in_another_order_than_pins_are_named_once() {
    let lines = warnings(app(), |app| {
        for (name, layer, z) in [("coat", 1, 0.0), ("shirt", 0, 0.02)] {
            let collision = ClothCollision { garment_layer: layer, ..default() };
            spawn(
                app,
                sheet(9),
                (border(), collision, Transform::from_xyz(0.0, 0.0, z), ClothUntangling::default(), Name::new(name)),
            );
        }
        run(app, 60);
    });
    let lines: Vec<_> = lines.iter().filter(|line| line.contains("`shirt`")).collect();
    assert!(lines.len() == 1 && lines[0].contains("`coat`") && lines[0].contains("layer"), "{lines:#?}");
}

#[test]
fn a_recovery_is_one_warning() {
    let lines = warnings(app(), |app| {
        let cloth = spawn(app, sheet(5), (border(), Name::new("torn")));
        for _ in 0..3 {
            run(app, 20);
            app.world_mut().get_mut::<ClothParticles>(cloth).expect("a cloth").state_mut().positions[7].x = f32::NAN;
        }
        run(app, 20);
        assert!(report(app, cloth).restores >= 2);
    });
    let lines: Vec<_> = lines.iter().filter(|line| line.contains("`torn`")).collect();
    assert!(lines.len() == 1 && lines[0].contains("NotFinite"), "{lines:#?}");
}

#[test]
fn a_warp_without_texture_coordinates_is_one_warning_and_one_with_them_is_none() {
    let lines = warnings(app(), |app| {
        let mut bare = sheet(5);
        bare.remove_attribute(Mesh::ATTRIBUTE_UV_0);
        spawn(app, bare, (ClothMaterial::DENIM, Name::new("bare"), border()));
        let mut flat = sheet(5);
        flat.insert_attribute(Mesh::ATTRIBUTE_UV_0, vec![[0.5, 0.5]; flat.count_vertices()]);
        spawn(app, flat, (ClothMaterial { stretch_ratio: 2.0, ..default() }, Name::new("flat"), border()));
        spawn(app, sheet(5), (ClothMaterial::DENIM, Name::new("mapped"), border()));
        let mut plain = sheet(5);
        plain.remove_attribute(Mesh::ATTRIBUTE_UV_0);
        spawn(app, plain, (ClothMaterial::RUBBER, Name::new("plain"), border()));
        run(app, 100);
    });
    assert_eq!(lines.len(), 2, "{lines:#?}");
    for name in ["bare", "flat"] {
        assert!(lines.iter().any(|line| line.contains(name) && line.contains("unwrap")), "{lines:#?}");
    }
}

#[test]
fn one_warning_stays_one_when_another_component_of_the_entity_comes_and_goes() {
    let lines = warnings(app(), |app| {
        let material = ClothMaterial { density: -1.0, ..default() };
        let cloth = spawn(app, sheet(5), (material, Name::new("flag"), border()));
        for _ in 0..5 {
            app.world_mut().entity_mut(cloth).insert((ClothCollider::ball(0.1), ClothCoupling::TwoWay));
            run(app, 3);
            app.world_mut().entity_mut(cloth).remove::<(ClothCollider, ClothCoupling)>();
            run(app, 3);
        }
    });
    assert_eq!(lines.len(), 1, "{lines:#?}");
}

#[test]
fn a_grip_is_warned_of_anew_after_it_was_let_go() {
    let lines = warnings(app(), |app| {
        let cloth = spawn(app, sheet(5), border());
        run(app, 2);
        let grip = app.world_mut().spawn(Name::new("hand")).id();
        for _ in 0..2 {
            let grab = ClothGrab { cloth, target: Vec3::NAN, ..default() };
            app.world_mut().entity_mut(grip).insert(grab);
            run(app, 5);
            app.world_mut().entity_mut(grip).remove::<ClothGrab>();
            run(app, 5);
        }
    });
    assert_eq!(lines.len(), 2, "{lines:#?}");
}

#[test]
fn what_has_no_effect_without_another_component_is_told_of_after_a_while() {
    let stray = |frames: usize| {
        warnings(app(), |app| {
            app.world_mut().spawn((Name::new("pole"), ClothPins::NONE));
            app.world_mut().spawn((Name::new("swatch"), ClothMaterial::SILK));
            let late = app.world_mut().spawn(ClothMaterial::SILK).id();
            let cloth = spawn(app, sheet(5), ());
            app.world_mut().spawn((Name::new("lining"), ClothPiece { cloth, first: 0 }));
            run(app, 60);
            app.world_mut().entity_mut(late).insert(Cloth);
            app.world_mut().entity_mut(cloth).remove::<Cloth>();
            run(app, frames);
        })
    };
    assert_eq!(stray(200), Vec::<String>::new(), "within 5 s");
    let lines: Vec<String> = stray(600).into_iter().filter(|line| line.contains("has no effect")).collect();
    let told = |words: [&str; 3]| lines.iter().filter(|line| words.iter().all(|word| line.contains(word))).count();
    assert_eq!(told(["pole", "`ClothPins`", "`Cloth`"]), 1, "{lines:#?}");
    assert_eq!(told(["swatch", "`ClothMaterial`", "`Cloth`"]), 1, "{lines:#?}");
    assert_eq!(told(["lining", "`ClothPiece`", "`Mesh3d`"]), 1, "{lines:#?}");
    assert_eq!(lines.len(), 3, "{lines:#?}");
}

#[test]
fn one_number_of_two_components_is_told_of_twice() {
    let lines = warnings(app(), |app| {
        let material = ClothMaterial { static_friction: f32::NAN, ..default() };
        let collider = ClothCollider { static_friction: f32::NAN, ..ClothCollider::ball(0.1) };
        spawn(app, sheet(5), (material, collider, border()));
        run(app, 10);
    });
    assert_eq!(lines.len(), 2, "{lines:#?}");
    assert!(lines.iter().any(|line| line.contains("`collider.static_friction`")), "{lines:#?}");
}
