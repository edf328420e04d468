//! Entities and components come and go at the worst moments.

use bevy::camera::visibility::NoAutoAabb;
use bevy::math::vec3;
use bevy::prelude::*;
use bevy_drape::prelude::*;
use bevy_drape::solver::scene::grid;
use bevy_drape::{ClothParticles, ClothRest};

use crate::common::*;

#[test]
fn removing_cloth_gives_the_authored_mesh_back_and_leaves_nothing() {
    let mut app = app();
    let source = add(&mut app, sheet(6));
    let cloth = app.world_mut().spawn((Mesh3d(source.clone()), Cloth)).id();
    run(&mut app, 10);
    let instance = app.world().get::<Mesh3d>(cloth).expect("a mesh").0.id();
    assert_ne!(instance, source.id());
    app.world_mut().entity_mut(cloth).remove::<Cloth>();
    run(&mut app, 3);
    assert_eq!(app.world().get::<Mesh3d>(cloth).map(|m| m.0.id()), Some(source.id()));
    assert!(app.world().get::<ClothParticles>(cloth).is_none() && app.world().get::<NoAutoAabb>(cloth).is_none());
    assert!(!app.world().resource::<Assets<Mesh>>().contains(instance), "the instance mesh was left behind");
    assert_eq!(status(&app, cloth), ClothStatus::New);
    assert_eq!(*report(&app, cloth), ClothReport::default());
    app.world_mut().entity_mut(cloth).insert(Cloth);
    run(&mut app, 10);
    assert_eq!(status(&app, cloth), ClothStatus::Active);
}

#[test]
fn despawning_leaves_no_mesh_behind() {
    let mut app = app();
    let source = add(&mut app, sheet(6));
    run(&mut app, 2);
    let before = app.world().resource::<Assets<Mesh>>().len();
    let cloths: Vec<Entity> = (0..5).map(|_| app.world_mut().spawn((Mesh3d(source.clone()), Cloth)).id()).collect();
    run(&mut app, 5);
    assert_eq!(app.world().resource::<Assets<Mesh>>().len(), before + 5);
    for cloth in cloths {
        app.world_mut().despawn(cloth);
    }
    run(&mut app, 5);
    assert_eq!(app.world().resource::<Assets<Mesh>>().len(), before);
}

#[test]
fn a_cloth_despawned_in_the_frame_it_is_bound_or_fails_is_no_panic() {
    let mut app = app();
    // Despawned by a command of the same frame, between ours.
    app.add_systems(
        PostUpdate,
        (|mut commands: Commands, cloths: Query<(Entity, &Name), With<Cloth>>| {
            for (entity, name) in &cloths {
                if name.as_str() == "doomed" {
                    commands.entity(entity).despawn();
                }
            }
        })
        .before(ClothSystems::Prepare),
    );
    let broken = add(&mut app, Mesh::new(bevy::mesh::PrimitiveTopology::LineList, default()));
    let good = add(&mut app, sheet(5));
    for _ in 0..10 {
        for mesh in [&broken, &good] {
            app.world_mut().spawn((Mesh3d(mesh.clone()), Cloth, Name::new("doomed")));
        }
        run(&mut app, 1);
    }
    assert_eq!(app.world_mut().query::<&Cloth>().iter(app.world()).count(), 0);
}

#[test]
fn an_observer_may_despawn_a_cloth_while_it_is_bound() {
    let mut app = app();
    app.add_observer(|added: On<Add, ClothRest>, mut commands: Commands| commands.entity(added.entity).despawn());
    for _ in 0..5 {
        spawn(&mut app, sheet(5), border());
        run(&mut app, 2);
    }
    assert_eq!(app.world_mut().query::<&Cloth>().iter(app.world()).count(), 0);
}

#[test]
fn a_cloned_cloth_binds_anew_from_the_authored_mesh() {
    let mut app = app();
    let source = add(&mut app, sheet(6));
    let cloth = app.world_mut().spawn((Mesh3d(source.clone()), Cloth, border())).id();
    run(&mut app, 60);
    let clone = app.world_mut().entity_mut(cloth).clone_and_spawn();
    assert!(app.world().get::<ClothParticles>(clone).is_none(), "internal state was cloned");
    run(&mut app, 1);
    let mesh = |e| app.world().get::<Mesh3d>(e).expect("a mesh").0.id();
    assert!(mesh(clone) != mesh(cloth) && mesh(clone) != source.id());
    assert!(lowest(&world_positions(&app, clone)) > -0.05, "the clone starts from the pose at rest");
    let rest = |e| app.world().get::<ClothRest>(e).expect("a rest shape");
    assert!(rest(clone).is_shared_with(rest(cloth)));
    app.world_mut().despawn(cloth);
    run(&mut app, 60);
    assert!(lowest(&world_positions(&app, clone)) < -0.5, "the clone lives on");
}

#[test]
fn a_clone_made_and_its_original_despawned_in_one_frame_still_binds() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(6), border());
    run(&mut app, 60);
    let clone = app.world_mut().entity_mut(cloth).clone_and_spawn();
    app.world_mut().despawn(cloth);
    run(&mut app, 1);
    assert_eq!(status(&app, clone), ClothStatus::Active);
    assert!(lowest(&world_positions(&app, clone)) > -0.05, "it starts from the pose at rest");
}

#[test]
fn a_cloth_that_is_switched_off_stays_as_it_is_and_goes_on_with_its_speed() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(6), Transform::from_xyz(0.0, 2.0, 0.0));
    run(&mut app, 30);
    let height = |app: &App| particles(app, cloth).iter().map(|p| p.y).sum::<f32>() / 36.0;
    let speed = |app: &mut App| {
        let before = height(app);
        run(app, 1);
        (height(app) - before) / FRAME
    };
    for _ in 0..2 {
        let before = speed(&mut app);
        let (at, shown, time) = (particles(&app, cloth), positions(&app, cloth), report(&app, cloth).time);
        app.world_mut().entity_mut(cloth).insert(ClothDisabled);
        run(&mut app, 30);
        assert!(particles(&app, cloth) == at && positions(&app, cloth) == shown, "it moved");
        let off = report(&app, cloth);
        assert_eq!((off.time, off.substeps, off.integrate_ms + off.detect_ms + off.evaluate_ms), (time, 0, 0.0), "{off:?}");
        app.world_mut().entity_mut(cloth).remove::<ClothDisabled>();
        let after = speed(&mut app);
        assert!(before < -0.5 && (after / before - 1.0).abs() < 0.2, "{before} m/s, then {after} m/s");
    }
}

#[test]
fn a_cloth_that_is_switched_off_from_the_start_is_drawn_as_it_was_authored() {
    let mut app = app();
    let source = add(&mut app, sheet(6));
    let cloth = app.world_mut().spawn((Mesh3d(source.clone()), Cloth, ClothDisabled)).id();
    run(&mut app, 10);
    assert_eq!(status(&app, cloth), ClothStatus::New);
    assert_eq!(app.world().get::<Mesh3d>(cloth).map(|m| m.0.id()), Some(source.id()));
    app.world_mut().entity_mut(cloth).remove::<ClothDisabled>();
    run(&mut app, 10);
    assert_eq!(status(&app, cloth), ClothStatus::Active);
    assert!(lowest(&particles(&app, cloth)) < -0.01, "it falls");
}

#[test]
fn what_lies_on_a_cloth_that_is_switched_off_wakes_and_falls() {
    let mut app = app();
    let rim = ClothPins::where_position(|p| p.x.abs().max(p.z.abs()) > 0.499);
    let table = spawn(&mut app, sheet(12), rim);
    let napkin = spawn(&mut app, sheet(7), Transform::from_xyz(0.0, 0.03, 0.0).with_scale(Vec3::splat(0.4)));
    run(&mut app, 300);
    let lies = lowest(&particles(&app, napkin));
    app.world_mut().entity_mut(table).insert(ClothDisabled);
    run(&mut app, 60);
    let fallen = lowest(&particles(&app, napkin));
    assert!(lies > -0.3 && fallen < lies - 0.1 && !report(&app, napkin).asleep, "from {lies} m to {fallen} m");
}

#[test]
fn cloth_before_its_mesh_waits() {
    let mut app = app();
    let cloth = app.world_mut().spawn(Cloth).id();
    run(&mut app, 3);
    assert_eq!(status(&app, cloth), ClothStatus::Waiting(ClothWaitingFor::Mesh));
    let mesh = add(&mut app, sheet(5));
    app.world_mut().entity_mut(cloth).insert(Mesh3d(mesh));
    run(&mut app, 3);
    assert_eq!(status(&app, cloth), ClothStatus::Active);
}

#[test]
fn a_cloth_that_failed_and_waits_has_no_error_until_it_fails_again() {
    use bevy_drape::ClothWaitingFor;
    let mut app = app();
    let source = add(&mut app, Mesh::new(bevy::mesh::PrimitiveTopology::LineList, default()));
    let cloth = app.world_mut().spawn((Mesh3d(source.clone()), Cloth)).id();
    let scale = |app: &mut App, scale| {
        app.world_mut().get_mut::<Transform>(cloth).expect("a transform").scale = scale;
        run(app, 3);
        (status(app, cloth), app.world().get::<ClothError>(cloth).is_some())
    };
    assert_eq!(scale(&mut app, Vec3::ONE), (ClothStatus::Failed, true));
    assert_eq!(scale(&mut app, Vec3::ZERO), (ClothStatus::Waiting(ClothWaitingFor::Transform), false));
    assert_eq!(scale(&mut app, Vec3::ONE), (ClothStatus::Failed, true));
    assert_eq!(scale(&mut app, Vec3::ZERO), (ClothStatus::Waiting(ClothWaitingFor::Transform), false));
    *app.world_mut().resource_mut::<Assets<Mesh>>().get_mut(&source).expect("the mesh") = sheet(5);
    run(&mut app, 3);
    assert_eq!(scale(&mut app, Vec3::ONE), (ClothStatus::Active, false));
}

#[test]
fn what_is_removed_from_one_of_two_cloths_that_touch_stops_nothing() {
    fn without<C: Component>() {
        let mut app = app();
        app.world_mut().spawn(ClothCollider::ball(0.2));
        let cloths = [0.25, 0.27].map(|y| spawn(&mut app, sheet(8), Transform::from_xyz(0.0, y, 0.0)));
        run(&mut app, 60);
        assert!(report(&app, cloths[0]).contacts > 0, "they touch");
        for cloth in cloths {
            app.world_mut().entity_mut(cloth).remove::<C>();
            run(&mut app, 30);
        }
        let other = spawn(&mut app, sheet(8), Transform::from_xyz(0.0, 0.4, 0.0));
        run(&mut app, 30);
        assert!(report(&app, other).time > 0.3 && finite(&app, other), "{}", core::any::type_name::<C>());
    }
    without::<ClothUntangling>();
    without::<ClothCollision>();
    without::<ClothRest>();
    without::<ClothMaterial>();
    without::<ClothSolver>();
    without::<ClothPins>();
    without::<ClothSleep>();
    without::<ClothSkipFrame>();
    without::<ClothReport>();
    without::<ClothStatus>();
    without::<ClothParticles>();
    without::<GlobalTransform>();
    without::<Mesh3d>();
}

#[test]
fn a_reset_puts_a_cloth_back_to_where_it_begins() {
    let mut app = app();
    let root = app.world_mut().spawn((Transform::default(), ClothCharacter)).id();
    let hanging = spawn(&mut app, sheet(12), (border(), ChildOf(root)));
    let fallen = spawn(&mut app, sheet(12), Transform::from_xyz(0.0, 0.3, 0.0));
    app.update();
    let [first, above] = [hanging, fallen].map(|cloth| world_positions(&app, cloth));
    run(&mut app, 40);
    assert!(lowest(&world_positions(&app, hanging)) < -0.5);
    app.world_mut().entity_mut(root).insert(ClothReset);
    // Where it begins is where its character is now.
    app.world_mut().get_mut::<Transform>(root).expect("a transform").translation = Vec3::new(0.3, 0.0, 0.0);
    app.world_mut().entity_mut(fallen).insert(ClothReset);
    frame_length(&mut app, 1.0e-3);
    app.update();
    for (cloth, first, by) in [(hanging, first, Vec3::X * 0.3), (fallen, above, Vec3::ZERO)] {
        let now = world_positions(&app, cloth);
        let off = now.iter().zip(&first).map(|(now, first)| now.distance(*first + by)).fold(0.0, f32::max);
        // The first frame had fallen by 1.4 mm.
        assert!(off < 2.0e-3, "{off} m");
        let state = app.world().get::<ClothParticles>(cloth).expect("a cloth").state().clone();
        let fastest = (0..now.len()).map(|i| state.velocity(i).length()).fold(0.0, f32::max);
        assert!(fastest < 0.02, "{fastest} m/s: a millisecond of gravity");
    }
    assert!([root, hanging, fallen].iter().all(|&entity| !app.world().entity(entity).contains::<ClothReset>()));
    frame_length(&mut app, FRAME);
    run(&mut app, 40);
    assert!(lowest(&world_positions(&app, hanging)) < -0.5, "it hangs again");

    app.world_mut().entity_mut(hanging).insert((ClothDisabled, ClothReset));
    run(&mut app, 5);
    assert!(app.world().entity(hanging).contains::<ClothReset>(), "it waits");
    app.world_mut().entity_mut(hanging).remove::<ClothDisabled>();
    run(&mut app, 1);
    assert!(lowest(&world_positions(&app, hanging)) > -0.01);
}

#[test]
fn a_reset_revives_a_cloth_that_was_stopped() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(8), border());
    run(&mut app, 5);
    for _ in 0..400 {
        if status(&app, cloth) == ClothStatus::Failed {
            break;
        }
        app.world_mut().get_mut::<ClothParticles>(cloth).expect("a cloth").state_mut().positions[50].y = f32::NAN;
        app.update();
    }
    assert_eq!(status(&app, cloth), ClothStatus::Failed);
    run(&mut app, 5);
    app.world_mut().entity_mut(cloth).insert(ClothReset);
    run(&mut app, 60);
    assert_eq!(status(&app, cloth), ClothStatus::Active);
    assert!(app.world().get::<ClothError>(cloth).is_none() && lowest(&world_positions(&app, cloth)) < -0.5);
}

#[test]
fn settings_that_are_removed_are_the_defaults() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(8), (border(), ClothMaterial::SILK));
    run(&mut app, 30);
    let hung = lowest(&world_positions(&app, cloth));
    app.world_mut().entity_mut(cloth).remove::<(ClothPins, ClothMaterial, ClothStatus)>();
    run(&mut app, 60);
    assert_eq!(app.world().get::<ClothMaterial>(cloth), Some(&ClothMaterial::default()));
    assert_eq!((status(&app, cloth), report(&app, cloth).pinned), (ClothStatus::Active, 0));
    assert!(lowest(&world_positions(&app, cloth)) < hung - 2.0, "without pins it falls");
    // With `Cloth` they go for good.
    app.world_mut().entity_mut(cloth).remove_with_requires::<Cloth>();
    run(&mut app, 2);
    assert!(!app.world().entity(cloth).contains::<ClothPins>());
}

#[test]
fn cloths_that_get_each_others_particles_go_on() {
    let mut app = app();
    app.world_mut().spawn(ClothCollider::ground());
    let strip = grid(2, 18, |u, v| vec3(0.1 * u, 0.05, v));
    let cloths = [sheet(6), mesh_of(&strip)].map(|mesh| spawn(&mut app, mesh, ClothSleepDisabled));
    // Both have as many particles, and other springs.
    run(&mut app, 30);
    let [a, b] = cloths.map(|cloth| app.world_mut().entity_mut(cloth).take::<ClothParticles>().expect("a cloth"));
    assert_eq!(a.len(), b.len());
    app.world_mut().entity_mut(cloths[0]).insert(b);
    app.world_mut().entity_mut(cloths[1]).insert(a);
    run(&mut app, 120);
    for cloth in cloths {
        assert!(finite(&app, cloth) && status(&app, cloth) == ClothStatus::Active);
        assert!(report(&app, cloth).worst_edge < 2.0, "{:?}", report(&app, cloth));
    }
}
