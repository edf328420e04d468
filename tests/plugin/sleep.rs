//! Cloth at rest sleeps, costs nothing, and wakes for everything that could move it.

use bevy::prelude::*;
use bevy_drape::ClothParticles;
use bevy_drape::prelude::*;

use crate::common::*;

/// A sheet that lies on the ground and sleeps.
fn sleeping(app: &mut App, extra: impl Bundle) -> Entity {
    app.world_mut().spawn(ClothCollider::ground());
    let cloth = spawn(app, sheet(10), (Transform::from_xyz(0.0, 0.006, 0.0), extra));
    until_asleep(app, cloth);
    cloth
}

/// Runs until a cloth sleeps, for 10 s at most.
fn until_asleep(app: &mut App, cloth: Entity) {
    for _ in 0..600 {
        run(app, 1);
        if report(app, cloth).asleep {
            return;
        }
    }
    panic!("awake after 10 s: {:?}", report(app, cloth));
}

/// Whether `change` wakes a cloth that sleeps, and exactly once.
fn wakes(change: impl FnOnce(&mut App, Entity)) -> bool {
    let mut app = app();
    record::<ClothWoke>(&mut app);
    let cloth = sleeping(&mut app, ());
    run(&mut app, 5);
    assert!(seen::<ClothWoke>(&app).is_empty() && report(&app, cloth).asleep, "it woke by itself");
    change(&mut app, cloth);
    run(&mut app, 2);
    let woke = !report(&app, cloth).asleep;
    assert_eq!(seen::<ClothWoke>(&app).len(), usize::from(woke), "events of one waking");
    woke
}

fn set<C: Component<Mutability = bevy::ecs::component::Mutable>>(app: &mut App, entity: Entity, change: impl FnOnce(&mut C)) {
    change(&mut app.world_mut().get_mut::<C>(entity).expect("a component"));
}

#[test]
fn a_cloth_on_the_ground_sleeps_once_and_is_neither_stepped_nor_written() {
    let mut app = app();
    record::<ClothSlept>(&mut app);
    let cloth = sleeping(&mut app, ());
    let time = report(&app, cloth).time;
    assert!(time < 4.0, "asleep after {time} s");
    run(&mut app, 2);
    let state = app.world().get::<ClothParticles>(cloth).expect("a cloth").state().clone();
    let mut cursor = app.world().resource::<Messages<AssetEvent<Mesh>>>().get_cursor_current();
    run(&mut app, 60);
    let after = report(&app, cloth).clone();
    assert!(app.world().get::<ClothParticles>(cloth).expect("a cloth").state() == &state, "it was stepped");
    assert_eq!(cursor.read(app.world().resource::<Messages<AssetEvent<Mesh>>>()).count(), 0, "it was written");
    assert_eq!((after.time, after.integrate_ms + after.detect_ms + after.evaluate_ms), (time, 0.0), "{after:?}");
    assert_eq!(seen::<ClothSlept>(&app).len(), 1);
}

#[test]
fn cloth_over_a_ball_falls_asleep_within_seconds() {
    let mut app = app();
    app.world_mut().spawn((Transform::default(), ClothCollider::ball(0.3)));
    let cloth = spawn(&mut app, sheet(24), Transform::from_xyz(0.0, 0.4, 0.0));
    until_asleep(&mut app, cloth);
    assert!(report(&app, cloth).time < 9.0, "{:?}", report(&app, cloth));
}

#[test]
fn a_sheet_on_a_sheet_on_a_ball_falls_asleep() {
    let mut app = app();
    app.world_mut().spawn((Transform::default(), ClothCollider::ball(0.3)));
    let cloths = [0.4, 0.45].map(|y| spawn(&mut app, sheet(20), Transform::from_xyz(0.0, y, 0.0)));
    for cloth in cloths {
        until_asleep(&mut app, cloth);
        assert!(report(&app, cloth).time < 9.0, "{:?}", report(&app, cloth));
    }
}

#[test]
fn a_cloth_that_may_not_sleep_does_not() {
    let mut app = app();
    app.world_mut().spawn(ClothCollider::ground());
    let sleeps = [ClothSleep::default(), ClothSleep { threshold: 0.0, ..default() }, ClothSleep { delay: 60.0, ..default() }];
    let cloths = sleeps.map(|sleep| {
        let alone = ClothCollision { contact: false, ..default() };
        spawn(&mut app, sheet(6), (Transform::from_xyz(0.0, 0.01, 0.0), alone, sleep))
    });
    app.world_mut().entity_mut(cloths[0]).insert(ClothSleepDisabled);
    run(&mut app, 180);
    assert!(cloths.iter().all(|&c| !report(&app, c).asleep));
}

#[test]
fn a_cloth_is_kept_awake_for_as_long_as_the_marker_is_on_it() {
    let mut app = app();
    record::<ClothSlept>(&mut app);
    record::<ClothWoke>(&mut app);
    let cloth = sleeping(&mut app, ());
    for times in 1..=2 {
        app.world_mut().entity_mut(cloth).insert(ClothSleepDisabled);
        run(&mut app, 1);
        assert!(!report(&app, cloth).asleep && seen::<ClothWoke>(&app).len() == times);
        run(&mut app, 120);
        assert!(!report(&app, cloth).asleep, "asleep after 2 s");
        app.world_mut().entity_mut(cloth).remove::<ClothSleepDisabled>();
        run(&mut app, 20);
        assert!(!report(&app, cloth).asleep, "its rest begins anew");
        until_asleep(&mut app, cloth);
        assert_eq!(seen::<ClothSlept>(&app).len(), times + 1);
    }
}

#[test]
fn a_swinging_cloth_does_not_sleep() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(12), border());
    for frame in 0..90 {
        run(&mut app, 1);
        assert!(!report(&app, cloth).asleep, "asleep in frame {frame}");
    }
}

#[test]
fn wind_that_rises_wakes_it_and_gusts_keep_it_awake() {
    assert!(wakes(|app, _| app.world_mut().resource_mut::<ClothGlobalWind>().velocity = Vec3::X));
    assert!(wakes(|app, cloth| {
        app.world_mut().entity_mut(cloth).insert(ClothWind::new(Vec3::X));
    }));
    assert!(wakes(|app, _| {
        app.world_mut().spawn(ClothWindZone::sphere(1.0, Vec3::Y));
    }));
    let mut app = app();
    app.world_mut().spawn(ClothCollider::ground());
    app.insert_resource(ClothGlobalWind { turbulence: 0.5, ..ClothGlobalWind::new(Vec3::X * 0.1) });
    let cloth = spawn(&mut app, sheet(6), Transform::from_xyz(0.0, 0.01, 0.0));
    run(&mut app, 180);
    assert!(!report(&app, cloth).asleep);
}

#[test]
fn a_body_that_comes_moves_goes_or_changes_wakes_it_and_one_far_away_does_not() {
    let ball = |x: f32, y: f32| (Transform::from_xyz(x, y, 0.0), ClothCollider::ball(0.1));
    assert!(wakes(|app, _| {
        app.world_mut().spawn(ball(0.0, 0.1));
        run(app, 1);
    }));
    assert!(!wakes(|app, _| {
        app.world_mut().spawn(ball(3.0, 0.1));
        run(app, 1);
    }));
    for change in 0..4 {
        let mut app = app();
        let body = app.world_mut().spawn(ball(0.0, 0.115)).id();
        let cloth = sleeping(&mut app, ());
        match change {
            0 => set::<Transform>(&mut app, body, |t| t.translation.x += 0.01),
            1 => set::<ClothCollider>(&mut app, body, |c| c.static_friction = 0.9),
            2 => {
                app.world_mut().entity_mut(body).insert(ClothColliderDisabled);
            }
            _ => {
                app.world_mut().despawn(body);
            }
        }
        run(&mut app, 2);
        assert!(!report(&app, cloth).asleep, "change {change}");
    }
}

#[test]
fn settings_gravity_and_pins_wake_it() {
    assert!(wakes(|app, _| app.insert_resource(ClothGravity(Vec3::X)).update()));
    assert!(wakes(|app, cloth| set::<ClothMaterial>(app, cloth, |m| m.density = 1.0)));
    assert!(wakes(|app, cloth| set::<ClothSolver>(app, cloth, |s| s.substep_rate = 720.0)));
    assert!(wakes(|app, cloth| set::<ClothSleep>(app, cloth, |s| s.delay = 2.0)));
    assert!(wakes(|app, cloth| {
        app.world_mut().entity_mut(cloth).insert(ClothSleepDisabled);
    }));
    assert!(wakes(|app, cloth| {
        app.world_mut().entity_mut(cloth).insert(ClothUntanglingDisabled);
    }));
    assert!(wakes(|app, cloth| set::<ClothPins>(app, cloth, |pins| *pins = border())));
}

#[test]
fn an_anchor_that_moves_wakes_it() {
    let mut app = app();
    app.world_mut().spawn(ClothCollider::ground());
    let cloth = spawn(&mut app, sheet(10), (Transform::from_xyz(0.0, 0.006, 0.0), border()));
    until_asleep(&mut app, cloth);
    set::<Transform>(&mut app, cloth, |t| t.translation.y += 0.01);
    run(&mut app, 2);
    assert!(!report(&app, cloth).asleep);
}

#[test]
fn a_push_a_grip_a_teleport_and_another_mesh_wake_it() {
    assert!(wakes(|app, cloth| {
        let taken =
            app.world_mut().get_mut::<ClothParticles>(cloth).expect("a cloth").apply_impulse(Vec3::ZERO, Vec3::Y * 0.1, 0.2);
        assert!(taken > 0);
    }));
    assert!(wakes(|app, cloth| {
        let grab =
            app.world_mut().run_system_cached(|cloths: ClothQuery| cloths.nearest_point(Vec3::ZERO, 1.0)).expect("a system");
        let grab = ClothGrab::at(&grab.expect("a point"));
        assert_eq!(grab.cloth, cloth);
        app.world_mut().spawn(grab);
        run(app, 1);
    }));
    assert!(wakes(|app, cloth| set::<Transform>(app, cloth, |t| t.translation.x += 10.0)));
    assert!(wakes(|app, cloth| {
        let other = add(app, sheet(7));
        app.world_mut().entity_mut(cloth).insert(Mesh3d(other));
    }));
}

#[test]
fn a_push_that_misses_wakes_nothing() {
    assert!(!wakes(|app, cloth| {
        let mut particles = app.world_mut().get_mut::<ClothParticles>(cloth).expect("a cloth");
        assert_eq!(particles.apply_impulse(Vec3::splat(50.0), Vec3::Y, 0.2), 0);
        assert_eq!(particles.apply_explosion(Vec3::splat(50.0), 1.0, 2.0), 0);
        assert_eq!(particles.apply_impulse(Vec3::NAN, Vec3::Y, 0.2), 0);
    }));
}

#[test]
fn cloths_that_can_meet_sleep_and_wake_together() {
    let mut app = app();
    record::<ClothWoke>(&mut app);
    app.world_mut().spawn(ClothCollider::ground());
    let cloths = [0.01, 0.03].map(|y| spawn(&mut app, sheet(10), Transform::from_xyz(0.0, y, 0.0)));
    for _ in 0..900 {
        run(&mut app, 1);
        let asleep = cloths.map(|c| report(&app, c).asleep);
        assert!(asleep[0] == asleep[1], "one sleeps alone");
        if asleep[0] {
            break;
        }
    }
    assert!(cloths.iter().all(|&c| report(&app, c).asleep), "awake after 15 s");
    app.world_mut().get_mut::<ClothParticles>(cloths[0]).expect("a cloth").apply_impulse(Vec3::ZERO, Vec3::Y * 0.01, 0.3);
    run(&mut app, 1);
    assert!(cloths.iter().all(|&c| !report(&app, c).asleep) && seen::<ClothWoke>(&app).len() == 2);
    // Again asleep, another comes from above.
    for _ in 0..900 {
        run(&mut app, 1);
    }
    assert!(cloths.iter().all(|&c| report(&app, c).asleep));
    spawn(&mut app, sheet(6), Transform::from_xyz(0.0, 0.1, 0.0));
    run(&mut app, 30);
    assert!(cloths.iter().all(|&c| !report(&app, c).asleep), "the third lies on them");
    assert!(cloths.iter().all(|&c| report(&app, c).crossings == 0));
}

#[test]
fn a_cloth_sleeps_through_two_way_bodies_elsewhere_that_come_and_go() {
    let mut app = app();
    let far = |x: f32| (Transform::from_xyz(x, 1.0, 0.0), ClothCollider::ball(0.1), ClothCoupling::TwoWay);
    let bodies = [5.0, 10.0, 15.0].map(|x| app.world_mut().spawn(far(x)).id());
    let cloth = sleeping(&mut app, ());
    app.world_mut().despawn(bodies[0]);
    run(&mut app, 2);
    set::<ClothCoupling>(&mut app, bodies[1], |coupling| *coupling = ClothCoupling::OneWay);
    run(&mut app, 2);
    app.world_mut().despawn(bodies[2]);
    run(&mut app, 2);
    assert!(report(&app, cloth).asleep, "what is far away does not concern it");
}

#[test]
fn a_sail_goes_on_pulling_at_its_mast_and_sleeps_when_the_mast_no_longer_takes_it() {
    let mut app = app();
    record::<ClothSlept>(&mut app);
    let mast = app.world_mut().spawn((Transform::default(), ClothCoupling::TwoWay)).id();
    let sail = spawn(&mut app, sheet(8), (border().to(mast), ClothMaterial { drag: 5.0, damping: 5.0, ..default() }));
    run(&mut app, 900);
    let pull = app.world().get::<ClothReaction>(mast).expect("a two-way body").linear.y;
    assert!(pull < 0.0, "the mast bears {pull} N s");
    assert!(seen::<ClothSlept>(&app).is_empty() && !report(&app, sail).asleep, "{:?}", report(&app, sail));
    set::<ClothCoupling>(&mut app, mast, |coupling| *coupling = ClothCoupling::OneWay);
    until_asleep(&mut app, sail);
    // It wakes to pull again.
    set::<ClothCoupling>(&mut app, mast, |coupling| *coupling = ClothCoupling::TwoWay);
    run(&mut app, 3);
    let pull = app.world().get::<ClothReaction>(mast).expect("a two-way body").linear.y;
    assert!(pull < 0.0 && !report(&app, sail).asleep, "the mast bears {pull} N s");
}

#[test]
fn a_sheet_on_a_body_that_takes_its_weight_stays_awake_and_a_body_that_begins_to_take_it_wakes_it() {
    let mut app = app();
    let table = app.world_mut().spawn((ClothCollider::ground(), ClothCoupling::TwoWay)).id();
    let cloth = spawn(&mut app, sheet(10), Transform::from_xyz(0.0, 0.006, 0.0));
    let given = |app: &App| app.world().get::<ClothReaction>(table).expect("a two-way body").linear.y;
    run(&mut app, 400);
    assert!(given(&app) < 0.0 && !report(&app, cloth).asleep, "the table bears {} N s", given(&app));
    set::<ClothCoupling>(&mut app, table, |coupling| *coupling = ClothCoupling::OneWay);
    until_asleep(&mut app, cloth);
    set::<ClothCoupling>(&mut app, table, |coupling| *coupling = ClothCoupling::TwoWay);
    run(&mut app, 10);
    assert!(given(&app) < 0.0 && !report(&app, cloth).asleep, "the table bears {} N s", given(&app));
}

#[test]
fn a_cloth_that_is_paused_in_its_fall_falls_on_with_its_speed() {
    let mut app = app();
    record::<ClothSlept>(&mut app);
    let cloth = spawn(&mut app, sheet(6), ());
    run(&mut app, 30);
    let height = |app: &App| particles(app, cloth).iter().map(|p| p.y).sum::<f32>() / 36.0;
    let speed = |app: &mut App| {
        let before = height(app);
        run(app, 1);
        (height(app) - before) / FRAME
    };
    let before = speed(&mut app);
    assert!(before < -1.0, "it falls at {before} m/s");
    set::<ClothSolver>(&mut app, cloth, |solver| solver.time_scale = 0.0);
    run(&mut app, 120);
    assert!(seen::<ClothSlept>(&app).is_empty(), "it fell asleep in the air");
    assert_eq!(speed(&mut app), 0.0, "it is paused");
    set::<ClothSolver>(&mut app, cloth, |solver| solver.time_scale = 1.0);
    let after = speed(&mut app);
    assert!((after / before - 1.0).abs() < 0.1, "it fell at {before} m/s and falls on at {after} m/s");
}

#[test]
fn a_cloth_in_slow_motion_rests_by_its_own_clock() {
    let mut app = app();
    app.world_mut().spawn(ClothCollider::ground());
    let slow = ClothSolver { time_scale: 0.1, ..default() };
    let cloth = spawn(&mut app, sheet(6), (Transform::from_xyz(0.0, 0.006, 0.0), slow));
    // 0.5 s of its own are 5 s.
    run(&mut app, 240);
    assert!(!report(&app, cloth).asleep);
    run(&mut app, 600);
    assert!(report(&app, cloth).asleep, "{:?}", report(&app, cloth));
}
