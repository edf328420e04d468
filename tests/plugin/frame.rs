//! Time, bad numbers, blow-ups and teleports.

use bevy::prelude::*;
use bevy_drape::prelude::*;
use bevy_drape::{
    ClothError, ClothErrorKind, ClothFailed, ClothParticles, ClothRecovered, ClothRecoveryCause, ClothRecoveryLevel,
    ClothTeleportMode, ClothTeleported,
};

use crate::common::*;

#[test]
fn a_frame_without_length_changes_nothing() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(8), border());
    run(&mut app, 20);
    let (before, time) = (positions(&app, cloth), report(&app, cloth).time);
    frame_length(&mut app, 0.0);
    run(&mut app, 10);
    assert_eq!(positions(&app, cloth), before);
    assert_eq!(report(&app, cloth).time, time);
    frame_length(&mut app, FRAME);
    run(&mut app, 10);
    assert!(finite(&app, cloth) && positions(&app, cloth) != before);
}

#[test]
fn pausing_the_clock_stops_the_cloth_and_writes_no_mesh() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(8), border());
    run(&mut app, 20);
    app.world_mut().resource_mut::<Time<Virtual>>().pause();
    run(&mut app, 2);
    let before = positions(&app, cloth);
    let mut cursor = app.world().resource::<Messages<AssetEvent<Mesh>>>().get_cursor_current();
    run(&mut app, 10);
    assert_eq!(positions(&app, cloth), before);
    let written = cursor.read(app.world().resource::<Messages<AssetEvent<Mesh>>>()).count();
    assert_eq!(written, 0, "writes of a mesh that does not move");
}

#[test]
fn a_huge_frame_is_cut_and_the_rest_is_counted_as_lost() {
    let mut app = app();
    // The virtual clock clips frames at 250 ms by itself.
    app.world_mut().resource_mut::<Time<Virtual>>().set_max_delta(core::time::Duration::from_secs(100));
    let cloth = spawn(&mut app, sheet(10), border());
    run(&mut app, 10);
    frame_length(&mut app, 10.0);
    run(&mut app, 3);
    let report = report(&app, cloth).clone();
    assert!((report.lost_time - 3.0 * 9.9).abs() < 0.01, "{report:?}");
    assert!(finite(&app, cloth) && report.worst_edge < 1.2, "{report:?}");
}

#[test]
fn frame_rates_from_twenty_to_a_thousand_look_alike() {
    let bottom = |rate: f32| {
        let mut app = app();
        frame_length(&mut app, 1.0 / rate);
        let cloth = spawn(&mut app, sheet(12), border());
        run(&mut app, (3.0 * rate) as usize);
        assert!(finite(&app, cloth));
        let bottom = lowest(&world_positions(&app, cloth));
        assert!(report(&app, cloth).worst_edge < 1.15, "{rate} Hz: {:?}", report(&app, cloth));
        bottom
    };
    let at = [20.0, 60.0, 144.0, 1000.0].map(bottom);
    for b in at {
        assert!((b - at[1]).abs() < 0.2, "lowest points {at:?} m");
    }
}

#[test]
fn time_scale_slows_one_cloth_and_zero_stops_it() {
    let mut app = app();
    let half = spawn(&mut app, sheet(5), ClothSolver { time_scale: 0.5, ..default() });
    let still = spawn(&mut app, sheet(5), ClothSolver { time_scale: 0.0, ..default() });
    run(&mut app, 60);
    assert!((report(&app, half).time - 0.5).abs() < 1.0e-3, "{}", report(&app, half).time);
    assert_eq!(report(&app, still).time, 0.0);
    assert!(lowest(&world_positions(&app, still)).abs() < 1.0e-6);
}

#[test]
fn a_teleport_carries_the_cloth_rigidly_and_tells() {
    let mut app = app();
    record::<ClothTeleported>(&mut app);
    let cloth = spawn(&mut app, sheet(8), border());
    run(&mut app, 60);
    let before = particles(&app, cloth);
    app.world_mut().get_mut::<Transform>(cloth).expect("a transform").translation.x += 500.0;
    run(&mut app, 1);
    let after = particles(&app, cloth);
    let worst = before.iter().zip(&after).map(|(a, b)| (*b - *a - Vec3::X * 500.0).length()).fold(0.0, f32::max);
    assert!(worst < 0.2, "a particle is {worst} m from where it was carried");
    assert!(report(&app, cloth).worst_edge < 1.1, "{:?}", report(&app, cloth));
    let [told] = seen::<ClothTeleported>(&app) else { panic!("{:?}", seen::<ClothTeleported>(&app)) };
    assert!((told.distance - 500.0).abs() < 0.1, "{told:?}");
    run(&mut app, 60);
    assert_eq!(seen::<ClothTeleported>(&app).len(), 1);
    assert!(finite(&app, cloth));
}

#[test]
fn a_quick_turn_counts_as_a_teleport_and_slow_motion_does_not() {
    // Whether it is turned at the end or not, its edges are as long: it is carried rigidly, and a turn about the vertical
    // changes nothing.
    let worst_edge = |turn: f32, self_collision: bool| {
        let mut app = app();
        record::<ClothTeleported>(&mut app);
        let cloth = spawn(&mut app, sheet(8), (border(), ClothCollision { self_collision, ..default() }));
        for i in 0..60 {
            let mut transform = app.world_mut().get_mut::<Transform>(cloth).expect("a transform");
            transform.translation.x = 0.3 * i as f32;
            transform.rotation = Quat::from_rotation_y(0.1 * i as f32);
            run(&mut app, 1);
        }
        assert_eq!(seen::<ClothTeleported>(&app).len(), 0);
        app.world_mut().get_mut::<Transform>(cloth).expect("a transform").rotate_y(turn);
        run(&mut app, 1);
        assert_eq!(seen::<ClothTeleported>(&app).len(), usize::from(turn > 0.0));
        report(&app, cloth).worst_edge
    };
    let (worst, turned) = (worst_edge(0.0, false), worst_edge(1.5, false));
    assert!((turned - worst).abs() < 0.05, "{worst}, turned {turned}");
    // The same where its border is dragged through it.
    let (worst, turned) = (worst_edge(0.0, true), worst_edge(1.5, true));
    assert!((turned / worst - 1.0).abs() < 0.05, "{worst}, turned {turned}");
}

#[test]
fn a_teleport_can_reset_the_cloth() {
    let mut app = app();
    let solver = ClothSolver { teleport: ClothTeleportMode::Reset, ..default() };
    let cloth = spawn(&mut app, sheet(8), (border(), solver));
    run(&mut app, 120);
    assert!(lowest(&world_positions(&app, cloth)) < -0.8);
    app.world_mut().get_mut::<Transform>(cloth).expect("a transform").translation = Vec3::new(0.0, 0.0, 100.0);
    run(&mut app, 1);
    assert!(lowest(&world_positions(&app, cloth)) > -0.05, "{}", lowest(&world_positions(&app, cloth)));
}

#[test]
fn one_particle_that_is_not_a_number_is_gone_in_the_next_frame_and_other_cloths_do_not_notice() {
    let run_with = |poison: bool| {
        let mut app = app();
        record::<ClothRecovered>(&mut app);
        // Out of reach: a cloth that is taken back meets those around it.
        let other = spawn(&mut app, sheet(8), (border(), Transform::from_xyz(5.0, 0.0, 0.0)));
        let cloth = spawn(&mut app, sheet(8), border());
        run(&mut app, 30);
        if poison {
            let mut particles = app.world_mut().get_mut::<ClothParticles>(cloth).expect("a bound cloth");
            particles.state_mut().positions[20].y = f32::NAN;
        }
        run(&mut app, 1);
        assert!(finite(&app, cloth), "shown positions are always finite");
        run(&mut app, 60);
        let told: Vec<_> = seen::<ClothRecovered>(&app).iter().map(|r| (r.entity == cloth, r.level, r.cause)).collect();
        let expected = [(true, ClothRecoveryLevel::LastGood, ClothRecoveryCause::NotFinite)];
        assert_eq!(told, if poison { &expected[..] } else { &[] });
        positions(&app, other)
    };
    assert_eq!(run_with(true), run_with(false), "another cloth has other bits");
}

#[test]
fn a_cloth_that_blows_up_every_frame_is_frozen_and_starts_again_when_it_is_tuned() {
    let mut app = app();
    record::<ClothRecovered>(&mut app);
    record::<ClothFailed>(&mut app);
    let cloth = spawn(&mut app, sheet(6), border());
    run(&mut app, 10);
    for _ in 0..60 {
        if let Some(mut particles) = app.world_mut().get_mut::<ClothParticles>(cloth) {
            particles.state_mut().positions[20].y = f32::NAN;
        }
        run(&mut app, 1);
        assert!(finite(&app, cloth));
        let ClothReport { worst_edge, mean_edge, .. } = report(&app, cloth);
        assert!(*worst_edge < 1.2 && *mean_edge < 1.1, "{worst_edge} and {mean_edge} of what was put back");
    }
    let levels: Vec<_> = seen::<ClothRecovered>(&app).iter().map(|r| r.level).collect();
    assert_eq!(levels.last(), Some(&ClothRecoveryLevel::Frozen), "{levels:?}");
    assert_eq!(status(&app, cloth), ClothStatus::Failed);
    assert_eq!(app.world().get::<ClothError>(cloth).map(|e| e.kind), Some(ClothErrorKind::Unstable));
    assert_eq!(seen::<ClothFailed>(&app).len(), 1);
    app.world_mut().get_mut::<ClothMaterial>(cloth).expect("a material").density = 0.5;
    run(&mut app, 60);
    assert_eq!(status(&app, cloth), ClothStatus::Active);
    assert!(lowest(&world_positions(&app, cloth)) < -0.3);
}

#[test]
fn numbers_out_of_range_are_clamped_and_named_and_never_shown() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.0, -1.0, 1.0e30] {
        let mut app = app();
        let material = ClothMaterial {
            density: bad,
            stretch_stiffness: bad,
            shear_stiffness: bad,
            bend_stiffness: bad,
            stretch_ratio: bad,
            bend_ratio: bad,
            warp_angle: bad,
            bend_hysteresis: bad,
            damping: bad,
            drag: bad,
            strain_limit: bad,
            thickness: bad,
            static_friction: bad,
            dynamic_friction: bad,
            restitution: bad,
            tether_scale: bad,
            drag_coefficient: bad,
            lift_coefficient: bad,
        };
        let solver = ClothSolver { substep_rate: bad, max_frame: bad, gravity_scale: bad.min(1.0), ..default() };
        let wind = ClothWind::new(Vec3::new(bad, 1.0, bad));
        let cloth = spawn(&mut app, sheet(6), (border(), material, solver, wind));
        app.insert_resource(ClothGravity(Vec3::new(0.0, bad, 0.0)));
        app.insert_resource(ClothGlobalWind { turbulence: bad, air_density: bad, ..ClothGlobalWind::new(Vec3::splat(bad)) });
        app.world_mut().spawn(ClothWindZone::sphere(bad, Vec3::splat(bad)));
        app.world_mut()
            .spawn((Transform::from_xyz(bad, bad, bad), ClothCollider::ball(bad).with_friction(bad).with_margin(bad)));
        frame_length(&mut app, 0.002);
        run(&mut app, 20);
        assert_eq!(status(&app, cloth), ClothStatus::Active, "with {bad}");
        assert!(finite(&app, cloth), "with {bad}");
        assert!(report(&app, cloth).clamped.iter().any(|c| c == "density"), "with {bad}: {:?}", report(&app, cloth).clamped);
        let density = app.world().get::<ClothMaterial>(cloth).expect("a material").density;
        assert!(density == bad || density.is_nan(), "what the user typed stays visible");
    }
}

#[test]
fn a_transform_that_is_not_a_number_waits_and_comes_back() {
    for bad in [f32::NAN, f32::INFINITY, 1.0e10] {
        let mut app = app();
        let cloth = spawn(&mut app, sheet(6), border());
        run(&mut app, 30);
        app.world_mut().get_mut::<Transform>(cloth).expect("a transform").translation = Vec3::splat(bad);
        run(&mut app, 10);
        assert_eq!(status(&app, cloth), ClothStatus::Waiting(ClothWaitingFor::Transform), "{bad}");
        assert!(finite(&app, cloth));
        app.world_mut().get_mut::<Transform>(cloth).expect("a transform").translation = Vec3::ZERO;
        run(&mut app, 30);
        assert_eq!(status(&app, cloth), ClothStatus::Active, "{bad}");
        let report = report(&app, cloth);
        assert!(finite(&app, cloth) && report.worst_edge < 1.1 && report.restores == 0, "{bad}");
    }
}

#[test]
fn ten_kilometres_from_the_origin_it_moves_as_at_the_origin() {
    let fly = |at: Vec3| {
        let mut app = app();
        app.insert_resource(ClothGlobalWind { turbulence: 0.0, ..ClothGlobalWind::new(Vec3::new(3.0, 0.0, 1.0)) });
        let cloth = spawn(&mut app, sheet(12), (border(), Transform::from_translation(at)));
        app.world_mut().spawn((Transform::from_translation(at + Vec3::new(0.0, -0.625, 0.25)), ClothCollider::ball(0.25)));
        run(&mut app, 300);
        positions(&app, cloth)
    };
    let here = fly(Vec3::ZERO);
    for at in [Vec3::new(1.0e4, 0.0, 0.0), Vec3::new(-1.0e4, 1.0e4, 1.0e4)] {
        let worst = here.iter().zip(fly(at)).map(|(a, b)| a.distance(b)).fold(0.0, f32::max);
        assert!(worst < 1.0e-3, "at {at} it is {worst} m elsewhere after 5 s");
    }
}

#[test]
fn a_long_fall_keeps_its_precision() {
    let mut app = app();
    let mut material = ClothMaterial::COTTON;
    material.drag = 0.0;
    app.insert_resource(ClothGlobalWind { air_density: 0.0, ..default() });
    let cloth = spawn(&mut app, sheet(5), material);
    run(&mut app, 600);
    let fell = -lowest(&particles(&app, cloth));
    assert!((fell / (0.5 * 9.81 * 100.0) - 1.0).abs() < 2.0e-3, "fell {fell} m in 10 s");
    let edge = report(&app, cloth).worst_edge;
    assert!((edge - 1.0).abs() < 1.0e-3, "worst edge {edge}");
}

/// Speed of the fastest particle [m/s], and kinetic energy and energy of position of all [J].
fn motion(app: &App, cloth: Entity) -> (f32, f64) {
    let state = app.world().get::<ClothParticles>(cloth).expect("a cloth").state();
    let free = || (0..state.positions.len()).filter(|&i| state.positions[i].w > 0.0);
    let fastest = free().map(|i| state.velocity(i).length()).fold(0.0, f32::max);
    let energy = free().map(|i| {
        let (x, v) = (state.positions[i], state.velocity(i));
        f64::from((0.5 * v.length_squared() + 9.81 * x.y) / x.w)
    });
    (fastest, energy.sum())
}

/// A sheet that is held along a border and swings down.
fn swinging(frames: usize) -> (App, Entity) {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(12), border());
    run(&mut app, frames);
    (app, cloth)
}

#[test]
fn very_short_frames_do_not_kick() {
    let fastest = |short: Option<f32>| {
        let (mut app, cloth) = swinging(0);
        let (mut fastest, mut worst) = (0.0f32, 0.0f32);
        for frame in 0..240 {
            let is_short = short.is_some() && frame % 8 == 7;
            frame_length(&mut app, short.filter(|_| is_short).unwrap_or(FRAME));
            app.update();
            fastest = fastest.max(motion(&app, cloth).0);
            worst = worst.max(report(&app, cloth).worst_edge);
        }
        assert_eq!(report(&app, cloth).restores, 0, "{short:?}");
        (fastest, worst)
    };
    let (usual, stretched) = fastest(None);
    for short in [5.0e-4, 5.0e-5, 2.0e-5, 1.0e-5, 1.0e-7] {
        let (speed, worst) = fastest(Some(short));
        assert!(speed < 1.02 * usual && worst < stretched + 0.005, "{short}: {speed} for {usual} m/s, {worst} for {stretched}");
    }
}

/// Beside frames of the usual length that cover the same time.
#[test]
fn slow_motion_and_hit_stops_give_no_speed() {
    for (frames, slow, count) in
        [(20, 1.0e-3, 600), (20, 1.0e-4, 600), (20, 0.05, 40), (20, 0.0, 6), (34, 1.0e-3, 600), (60, 0.01, 100)]
    {
        let (mut app, cloth) = swinging(frames);
        let (mut usual, twin) = swinging(frames);
        let before = motion(&app, cloth);
        app.world_mut().resource_mut::<Time<Virtual>>().set_relative_speed(slow);
        let mut fastest = 0.0f32;
        for _ in 0..count {
            app.update();
            fastest = fastest.max(motion(&app, cloth).0);
        }
        let (mut left, mut bound) = (slow * count as f32 * FRAME, before.0);
        while left > 0.0 {
            frame_length(&mut usual, left.min(FRAME));
            usual.update();
            left -= FRAME;
            bound = bound.max(motion(&usual, twin).0);
        }
        let (now, then) = (motion(&app, cloth).1, motion(&usual, twin).1);
        // A millisecond at most is owed; without that, the fastest particle went at 97 m/s.
        assert!(fastest < 1.06 * bound, "{frames} frames, then {slow}: {fastest} for {bound} m/s");
        assert!(
            (now - then).abs() < 0.02 * then.abs(),
            "{frames} frames, then {slow}: {now} for {then} J, {} before",
            before.1
        );
        // Back at the usual speed.
        app.world_mut().resource_mut::<Time<Virtual>>().set_relative_speed(1.0);
        frame_length(&mut usual, FRAME);
        let (mut most, mut bound) = (0.0f32, 0.0f32);
        for _ in 0..30 {
            app.update();
            usual.update();
            (most, bound) = (most.max(motion(&app, cloth).0), bound.max(motion(&usual, twin).0));
        }
        assert!(most < 1.02 * bound, "{frames} frames, then {slow}, and on: {most} for {bound} m/s");
    }
}
