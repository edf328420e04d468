//! Grab, drag, throw, push and blow away.

use bevy::ecs::system::RunSystemOnce;
use bevy::prelude::*;
use bevy_drape::ClothParticles;
use bevy_drape::prelude::*;

use crate::common::*;

/// Grabs what is nearest to a point.
fn grab(app: &mut App, point: Vec3) -> Entity {
    let hit = app.world_mut().run_system_once(move |cloths: ClothQuery| cloths.nearest_point(point, 1.0));
    let hit = hit.expect("a system").expect("a cloth");
    app.world_mut().spawn(ClothGrab::at(&hit)).id()
}

fn drag(app: &mut App, grip: Entity, by: Vec3) {
    app.world_mut().get_mut::<ClothGrab>(grip).expect("a grip").target += by;
    run(app, 1);
}

fn mean(points: &[Vec3]) -> Vec3 {
    points.iter().sum::<Vec3>() / points.len() as f32
}

#[test]
fn a_grabbed_point_follows_its_target_and_the_cloth_hangs_from_it() {
    let mut app = app();
    app.world_mut().spawn(ClothCollider::ground());
    let cloth = spawn(&mut app, sheet(16), Transform::from_xyz(0.0, 0.02, 0.0));
    run(&mut app, 60);
    let grip = grab(&mut app, Vec3::ZERO);
    for frame in 0..120 {
        drag(&mut app, grip, Vec3::Y * 0.01);
        assert!(report(&app, cloth).worst_edge < 1.3, "frame {frame}: {:?}", report(&app, cloth));
    }
    run(&mut app, 120);
    let target = app.world().get::<ClothGrab>(grip).expect("a grip").target;
    let highest = particles(&app, cloth).into_iter().map(|p| p.y).fold(f32::NEG_INFINITY, f32::max);
    assert!((highest - target.y).abs() < 0.06, "{highest} for {target}");
    assert_eq!(report(&app, cloth).restores, 0);
    // Let go, it falls.
    app.world_mut().despawn(grip);
    run(&mut app, 120);
    assert!(mean(&particles(&app, cloth)).y < 0.2);
}

#[test]
fn a_thrown_cloth_keeps_its_velocity() {
    let mut app = app();
    app.insert_resource(ClothGravity(Vec3::ZERO));
    let cloth = spawn(&mut app, sheet(10), Transform::default());
    run(&mut app, 2);
    let grip = grab(&mut app, Vec3::ZERO);
    for _ in 0..40 {
        drag(&mut app, grip, Vec3::X * 0.03);
    }
    app.world_mut().despawn(grip);
    let before = mean(&particles(&app, cloth));
    run(&mut app, 10);
    let speed = (mean(&particles(&app, cloth)) - before).x / (10.0 * FRAME);
    assert!((0.8..2.2).contains(&speed), "{speed} m/s for 1.8");
}

#[test]
fn a_cloth_is_not_pulled_through_a_body_and_does_not_burst() {
    let mut app = app();
    app.world_mut().spawn(ClothCollider::ground());
    let cloth = spawn(&mut app, sheet(16), Transform::from_xyz(0.0, 0.02, 0.0));
    run(&mut app, 60);
    let grip = grab(&mut app, Vec3::ZERO);
    // At once, and far below the ground.
    drag(&mut app, grip, Vec3::NEG_Y * 5.0);
    for frame in 0..60 {
        run(&mut app, 1);
        let low = lowest(&particles(&app, cloth));
        assert!(low > -0.001 && finite(&app, cloth), "frame {frame}: lowest at {low} m");
    }
    // Pinned and torn at with all that is allowed.
    let held = spawn(&mut app, sheet(16), (border(), Transform::from_xyz(5.0, 2.0, 0.0)));
    run(&mut app, 30);
    let grip = grab(&mut app, Vec3::new(5.0, 1.0, -0.5));
    app.world_mut().get_mut::<ClothGrab>(grip).expect("a grip").max_force = f32::INFINITY;
    drag(&mut app, grip, Vec3::NEG_Y * 50.0);
    run(&mut app, 120);
    assert!(finite(&app, held));
    app.world_mut().despawn(grip);
    run(&mut app, 120);
    assert!(finite(&app, held) && report(&app, held).worst_edge < 1.2, "{:?}", report(&app, held));
}

#[test]
fn a_grip_on_nothing_or_nowhere_does_nothing() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(6), border());
    run(&mut app, 2);
    let grip = grab(&mut app, Vec3::ZERO);
    let good = app.world().get::<ClothGrab>(grip).expect("a grip").clone();
    for bad in [
        ClothGrab { target: Vec3::NAN, ..good.clone() },
        ClothGrab { particles: [0, 1, 1_000_000], ..good.clone() },
        ClothGrab { weights: Vec3::ZERO, ..good.clone() },
        ClothGrab { weights: Vec3::NAN, ..good.clone() },
        ClothGrab { radius: f32::NAN, compliance: -1.0, max_force: f32::NAN, ..good.clone() },
        ClothGrab { cloth: Entity::PLACEHOLDER, ..good },
    ] {
        app.world_mut().entity_mut(grip).insert(bad);
        run(&mut app, 5);
        assert!(finite(&app, cloth));
    }
    app.world_mut().despawn(cloth);
    run(&mut app, 2);
}

#[test]
fn an_impulse_and_an_explosion_move_a_cloth_as_their_mass_says() {
    let mut app = app();
    app.insert_resource(ClothGravity(Vec3::ZERO));
    let cloth = spawn(&mut app, sheet(10), ClothMaterial { density: 0.2, ..default() });
    run(&mut app, 2);
    let mut state = app.world_mut().get_mut::<ClothParticles>(cloth).expect("a cloth");
    // 0.2 kg with 0.1 N·s: 0.5 m/s.
    assert_eq!(state.apply_impulse(Vec3::ZERO, Vec3::Y * 0.1, 100.0), 100);
    run(&mut app, 6);
    let risen = mean(&particles(&app, cloth)).y / (6.0 * FRAME);
    assert!((0.35..0.51).contains(&risen), "{risen} m/s");
    let before = mean(&particles(&app, cloth));
    let mut state = app.world_mut().get_mut::<ClothParticles>(cloth).expect("a cloth");
    assert_eq!(state.apply_explosion(before + Vec3::Y * 0.3, 1.0, 2.0), 100);
    assert_eq!(state.apply_explosion(before + Vec3::Y * 30.0, 1.0, 2.0), 0);
    assert_eq!(state.apply_impulse(Vec3::NAN, Vec3::Y, 1.0), 0);
    run(&mut app, 6);
    assert!(mean(&particles(&app, cloth)).y < before.y - 0.05 && finite(&app, cloth));
}
