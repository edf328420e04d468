//! Frames that take longer than the budget are stepped in the background.

use std::time::{Duration, Instant};

use bevy::prelude::*;
use bevy_drape::prelude::*;
use bevy_drape::{ClothParticles, ClothPlugin, ClothSnapshot};
use drape_tests::data;

use crate::common::*;

/// An app in which cloth of 100 particles and more is always too much.
fn short_of_time() -> App {
    let mut app = app();
    app.insert_resource(ClothLoading { in_background_from: 100 });
    app.insert_resource(ClothBudget { ms: 0.01 });
    app
}

/// Runs frames until `done`, with time in between for what runs in the background; how many that took.
fn until(app: &mut App, what: &str, mut done: impl FnMut(&App) -> bool) -> u32 {
    let start = Instant::now();
    let mut frames = 0;
    while !done(app) {
        assert!(start.elapsed() < Duration::from_secs(60), "never: {what}");
        std::thread::sleep(Duration::from_millis(1));
        app.update();
        frames += 1;
    }
    frames
}

/// Runs until a cloth has a `time` of its own [s].
fn until_time(app: &mut App, cloth: Entity, time: f32) {
    until(app, "time passes", |app| {
        let report = app.world().get::<ClothReport>(cloth);
        report.is_some_and(|report| report.time >= time)
    });
}

/// Runs until `time` [s] of its own has passed for a cloth.
fn for_time(app: &mut App, cloth: Entity, time: f32) {
    let now = report(app, cloth).time;
    until_time(app, cloth, now + time);
}

fn velocity(app: &App, cloth: Entity) -> Vec3 {
    let state = app.world().get::<ClothParticles>(cloth).expect("a bound cloth").state();
    let sum: Vec3 = state.positions.iter().zip(&state.previous).map(|(x, old)| (*x - *old).truncate()).sum();
    sum / (state.positions.len() as f32 * state.substep)
}

#[test]
fn what_is_too_much_hangs_in_the_background_as_it_does_in_the_frame() {
    let mut app = short_of_time();
    let cloth = spawn(&mut app, sheet(16), (border(), ClothSleepDisabled));
    let small = spawn(&mut app, sheet(5), (border(), Transform::from_xyz(5.0, 0.0, 0.0)));
    until_time(&mut app, cloth, 4.0);
    assert!(report(&app, cloth).in_background && !report(&app, small).in_background);
    assert_eq!(report(&app, cloth).by_budget, ClothDetail::Full);
    let hangs = particles(&app, cloth);

    let mut whole = self::app();
    let cloth = spawn(&mut whole, sheet(16), (border(), ClothSleepDisabled));
    run(&mut whole, 240);
    let farthest = hangs.iter().zip(particles(&whole, cloth)).map(|(a, b)| a.distance(b)).fold(0.0, f32::max);
    // After four seconds both swing by less.
    assert!(farthest < 0.05, "{farthest} m");
}

#[test]
fn time_in_the_background_is_that_of_the_clock() {
    let mut app = short_of_time();
    let cloth = spawn(&mut app, sheet(16), (border(), ClothSleepDisabled));
    until_time(&mut app, cloth, 0.1);
    let (start, before) = (report(&app, cloth).time, report(&app, cloth).lost_time);
    let mut frames = 0u32;
    until(&mut app, "time passes", |_| {
        frames += 1;
        frames > 200
    });
    let after = report(&app, cloth);
    let passed = after.time - start + after.lost_time - before;
    // What is under way, at both ends, is at most a frame that is too long to be simulated, and what waits for it.
    assert!((passed - FRAME * 200.0).abs() < 0.3, "{passed} s in 200 frames");
}

#[test]
fn what_is_done_to_a_cloth_while_its_frame_is_under_way_is_done() {
    let mut app = short_of_time();
    let cloth = spawn(&mut app, sheet(16), ClothSleepDisabled);
    app.insert_resource(ClothGravity(Vec3::ZERO));
    until_time(&mut app, cloth, 0.1);
    for round in 0..20 {
        let before = velocity(&app, cloth);
        let mut particles = app.world_mut().get_mut::<ClothParticles>(cloth).expect("particles");
        let at = particles.world_positions().next().expect("a particle").as_vec3();
        let mass: f32 = particles.state().positions.iter().map(|x| 1.0 / x.w).sum();
        assert!(particles.apply_impulse(at, Vec3::X * mass, 100.0) > 200);
        for_time(&mut app, cloth, 0.01);
        let gained = velocity(&app, cloth) - before;
        // Air takes some of it.
        assert!((0.5..1.2).contains(&gained.x) && gained.y.abs() < 0.1, "{round}: {gained}");
        app.world_mut().get_mut::<ClothParticles>(cloth).expect("particles").apply_impulse(at, -Vec3::X * mass, 100.0);
    }
}

/// A frame of the app with `between` [ms] for what runs in the background.
fn frame(app: &mut App, between: u64) {
    std::thread::sleep(Duration::from_millis(between));
    app.update();
}

/// Moves a cloth by a `step` [m] in each of 180 frames, and back to a stand; its worst edge meanwhile.
fn drive(app: &mut App, cloth: Entity, step: f32, mut each: impl FnMut(&mut App, u32)) -> f32 {
    let mut worst = 0.0f32;
    for number in 0..180 {
        app.world_mut().get_mut::<Transform>(cloth).expect("a transform").translation.x += step;
        each(app, number);
        frame(app, 1);
        worst = worst.max(report(app, cloth).worst_edge);
    }
    for_time(app, cloth, 0.3);
    worst
}

fn middle(app: &App, cloth: Entity) -> Vec3 {
    let now = particles(app, cloth);
    now.iter().sum::<Vec3>() / now.len() as f32
}

#[test]
fn pins_that_move_take_along_what_is_in_the_background() {
    let mut app = short_of_time();
    let cloth = spawn(&mut app, sheet(24), (border(), ClothSleepDisabled));
    until_time(&mut app, cloth, 1.0);
    let worst = drive(&mut app, cloth, 0.02, |_, _| ());
    let at = middle(&app, cloth);
    assert!((at.x - 3.6).abs() < 0.3, "{at}");
    assert!(worst < 1.2, "{worst}");
    assert_eq!((report(&app, cloth).restores, report(&app, cloth).resets), (0, 0));
}

#[test]
fn it_comes_back_into_the_frame_while_its_pins_move() {
    let mut app = short_of_time();
    let cloth = spawn(&mut app, sheet(24), (border(), ClothSleepDisabled));
    until_time(&mut app, cloth, 1.0);
    let worst = drive(&mut app, cloth, 0.005, |app, number| match number % 40 {
        0 => app.insert_resource(ClothBudget { ms: 0.01 }).update(),
        20 => _ = app.world_mut().remove_resource::<ClothBudget>(),
        _ => {}
    });
    assert!(worst < 1.2, "{worst}");
    assert_eq!((report(&app, cloth).restores, report(&app, cloth).resets), (0, 0));
}

#[test]
fn what_takes_cloth_along_in_every_frame_keeps_it_in_the_frame() {
    let mut app = short_of_time();
    let inertia = ClothInertia { linear: 0.5, ..default() };
    let cloth = spawn(&mut app, sheet(16), (border(), ClothSleepDisabled, inertia));
    app.insert_resource(ClothBudget { ms: 1000.0 });
    drive(&mut app, cloth, 0.02, |_, _| ());
    assert!(!report(&app, cloth).in_background && (middle(&app, cloth).x - 3.6).abs() < 0.3);
}

#[test]
fn two_way_bodies_keep_cloth_in_the_frame() {
    let mut app = short_of_time();
    let cloth = spawn(&mut app, sheet(16), (ClothPins::where_position(|p| p.x.abs() > 0.49), ClothSleepDisabled));
    until(&mut app, "it goes", |app| report(app, cloth).in_background && report(app, cloth).time > 0.1);
    let body = (ClothCollider::ball(0.1), ClothCoupling::TwoWay, Transform::from_xyz(0.0, 0.11, 0.0));
    let body = app.world_mut().spawn(body).id();
    until(&mut app, "it comes back", |app| !report(app, cloth).in_background);
    run(&mut app, 5);
    assert!(!report(&app, cloth).in_background);
    app.world_mut().despawn(body);
    until(&mut app, "it goes again", |app| report(app, cloth).in_background);
}

#[test]
fn one_that_is_paused_holds_up_no_other() {
    let mut app = short_of_time();
    app.world_mut().spawn((ClothCollider::cuboid(2.0, 0.2, 2.0), Transform::from_xyz(0.0, -0.2, 0.0)));
    let low = spawn(&mut app, sheet(16), ClothSleepDisabled);
    let high = spawn(&mut app, sheet(16), (ClothSleepDisabled, Transform::from_xyz(0.0, 0.05, 0.0)));
    until_time(&mut app, high, 0.5);
    for scale in [0.0, 1.0, 0.0] {
        app.world_mut().get_mut::<ClothSolver>(low).expect("settings").time_scale = scale;
        let (before, lay) = (report(&app, low).time, particles(&app, low));
        for_time(&mut app, high, 0.3);
        assert!(report(&app, high).crossings == 0 && report(&app, high).restores == 0);
        if scale == 0.0 {
            assert!(report(&app, low).time <= before + 0.2 && particles(&app, low).len() == lay.len());
        } else {
            assert!(report(&app, low).time > before);
        }
    }
}

#[test]
fn a_cloth_that_is_reset_or_begins_anew_while_its_frame_is_under_way_does() {
    let mut app = short_of_time();
    let cloth = spawn(&mut app, sheet(24), ClothSleepDisabled);
    for round in 0..4 {
        for_time(&mut app, cloth, 0.4);
        assert!(middle(&app, cloth).y < -0.2, "it falls");
        if round % 2 == 0 {
            app.world_mut().entity_mut(cloth).insert(ClothReset);
            app.update();
        } else {
            app.world_mut().entity_mut(cloth).remove::<Cloth>();
            app.world_mut().entity_mut(cloth).insert(Cloth);
            app.update();
            app.update();
        }
        for _ in 0..3 {
            assert!(middle(&app, cloth).y > -0.1, "round {round}: {}", middle(&app, cloth));
            frame(&mut app, 3);
        }
    }
}

#[test]
fn what_is_written_in_every_frame_is_added_to_what_was_done_meanwhile() {
    let mut app = short_of_time();
    app.insert_resource(ClothGravity(Vec3::ZERO));
    let cloth = spawn(&mut app, sheet(24), ClothSleepDisabled);
    until_time(&mut app, cloth, 0.1);
    let start = middle(&app, cloth);
    for _ in 0..60 {
        let mut particles = app.world_mut().get_mut::<ClothParticles>(cloth).expect("particles");
        let at = particles.world_positions().next().expect("a particle").as_vec3();
        let mass: f32 = particles.state().positions.iter().map(|x| 1.0 / x.w).sum();
        // 3 m/s in all.
        particles.apply_impulse(at, Vec3::X * 0.05 * mass, 1000.0);
        frame(&mut app, 1);
    }
    for_time(&mut app, cloth, 0.1);
    let (now, speed) = (middle(&app, cloth) - start, velocity(&app, cloth));
    assert!(now.x > 0.5 && now.x < 2.5, "{now}");
    assert!(speed.x > 1.0 && speed.x < 3.3 && report(&app, cloth).restores == 0, "{speed}");
}

#[test]
fn a_body_that_jumps_meanwhile_is_not_swept_through_cloth() {
    let mut app = short_of_time();
    app.insert_resource(ClothGravity(Vec3::ZERO));
    let cloth = spawn(&mut app, sheet(24), ClothSleepDisabled);
    let ball = app.world_mut().spawn((ClothCollider::ball(0.2), Transform::from_xyz(0.0, 2.0, 0.0))).id();
    until_time(&mut app, cloth, 0.1);
    for round in 0..10 {
        app.world_mut().get_mut::<Transform>(ball).expect("a transform").translation.y *= -1.0;
        for_time(&mut app, cloth, 0.05);
        assert!(middle(&app, cloth).length() < 0.02, "round {round}: {}", middle(&app, cloth));
    }
}

#[test]
fn what_falls_far_in_the_background_meets_the_floor() {
    let mut app = short_of_time();
    app.world_mut().spawn((ClothCollider::cuboid(4.0, 0.1, 4.0), Transform::from_xyz(0.0, -5.0, 0.0)));
    let cloth = spawn(&mut app, sheet(24), ClothSleepDisabled);
    until_time(&mut app, cloth, 4.0);
    let lowest = lowest(&particles(&app, cloth));
    assert!((-4.951..-4.9).contains(&lowest), "{lowest}");
    assert_eq!((report(&app, cloth).restores, report(&app, cloth).resets), (0, 0));
}

#[test]
fn what_is_let_go_of_while_it_is_paused_falls_afterwards() {
    let mut app = short_of_time();
    app.world_mut().spawn((ClothCollider::cuboid(4.0, 0.1, 4.0), Transform::from_xyz(0.0, -2.0, 0.0)));
    let held = spawn(&mut app, sheet(16), (border(), ClothSleepDisabled));
    let other = spawn(&mut app, sheet(16), (border(), ClothSleepDisabled, Transform::from_xyz(0.0, 0.03, 0.0)));
    until_time(&mut app, other, 0.3);
    app.world_mut().get_mut::<ClothSolver>(held).expect("settings").time_scale = 0.0;
    for_time(&mut app, other, 0.1);
    app.world_mut().entity_mut(held).insert(ClothPins::default());
    for_time(&mut app, other, 0.1);
    app.world_mut().get_mut::<ClothSolver>(held).expect("settings").time_scale = 1.0;
    for_time(&mut app, held, 2.0);
    let highest = particles(&app, held).iter().map(|p| p.y).fold(f32::NEG_INFINITY, f32::max);
    assert!(highest < -0.5, "{highest}");
}

#[test]
fn cloths_come_and_go_while_a_frame_is_under_way() {
    let mut app = short_of_time();
    let ball = ClothCollider::ball(0.3);
    app.world_mut().spawn((ball, Transform::from_xyz(0.0, -0.5, 0.0)));
    let low = spawn(&mut app, sheet(16), ClothSleepDisabled);
    until_time(&mut app, low, 0.2);
    for round in 0..6 {
        let other = spawn(&mut app, sheet(12), (Transform::from_xyz(0.0, 0.1, 0.0), ClothSleepDisabled));
        until_time(&mut app, other, 0.1 * round as f32);
        let saved = ClothSnapshot::capture(app.world_mut());
        for_time(&mut app, other, 0.05);
        saved.restore(app.world_mut()).expect("both are there");
        for_time(&mut app, other, 0.05);
        match round % 3 {
            0 => app.world_mut().entity_mut(other).despawn(),
            1 => {
                app.world_mut().entity_mut(other).remove::<Cloth>();
                app.update();
                app.world_mut().entity_mut(other).despawn();
            }
            _ => {
                app.world_mut().entity_mut(other).insert(ClothReset);
                app.update();
                app.world_mut().entity_mut(other).despawn();
            }
        }
        for_time(&mut app, low, 0.05);
        assert!(finite(&app, low) && report(&app, low).crossings == 0, "round {round}");
    }
    // It lies on the ball, and nothing went through.
    let lowest = particles(&app, low).iter().map(|p| p.distance(Vec3::Y * -0.5)).fold(f32::INFINITY, f32::min);
    assert!(lowest > 0.299, "{lowest}");
}

#[test]
fn what_meets_nothing_is_left_to_the_budget() {
    let mut app = short_of_time();
    let collision = ClothCollision { self_collision: false, ..default() };
    let alone = spawn(&mut app, sheet(16), (border(), ClothSleepDisabled, collision));
    until(&mut app, "it is stepped", |app| report(app, alone).time > 0.0);
    for number in 0..120 {
        frame(&mut app, 1);
        assert!(!report(&app, alone).in_background, "frame {number}");
    }
    assert_eq!(report(&app, alone).by_budget, ClothDetail::Still);
}

#[test]
fn without_the_budget_it_is_stepped_in_the_frame_again() {
    let mut app = short_of_time();
    let cloth = spawn(&mut app, sheet(16), (border(), ClothSleepDisabled));
    until_time(&mut app, cloth, 0.3);
    app.world_mut().remove_resource::<ClothBudget>();
    until(&mut app, "it comes back", |app| !report(app, cloth).in_background);
    let before = report(&app, cloth).time;
    run(&mut app, 60);
    let passed = report(&app, cloth).time - before;
    assert!((passed - 1.0).abs() < 1.0e-3, "{passed} s in 60 frames");
    assert!(report(&app, cloth).worst_edge < 1.1 && report(&app, cloth).restores == 0);
    // And there again.
    app.insert_resource(ClothBudget { ms: 0.01 });
    until(&mut app, "it goes", |app| report(app, cloth).in_background);
    for_time(&mut app, cloth, 0.1);
}

#[test]
fn a_cloth_in_the_background_comes_to_rest_and_wakes() {
    let mut app = short_of_time();
    let cloth = spawn(&mut app, sheet(12), border());
    record::<ClothSlept>(&mut app);
    until(&mut app, "it sleeps", |app| report(app, cloth).asleep);
    let time = report(&app, cloth).time;
    run(&mut app, 10);
    assert_eq!(report(&app, cloth).time, time, "nothing is stepped");
    app.world_mut().get_mut::<Transform>(cloth).expect("a transform").translation.x += 0.1;
    until(&mut app, "it wakes", |app| report(app, cloth).time > time);
    assert_eq!(seen::<ClothSlept>(&app).len(), 1);
}

#[test]
fn a_fixed_clock_shows_what_was_done_in_the_background() {
    let mut app = app_with(ClothPlugin::new(FixedPostUpdate));
    app.insert_resource(ClothLoading { in_background_from: 100 });
    app.insert_resource(ClothBudget { ms: 0.01 });
    let cloth = spawn(&mut app, sheet(16), (border(), ClothSleepDisabled));
    until_time(&mut app, cloth, 1.0);
    assert!(finite(&app, cloth) && lowest(&positions(&app, cloth)) < -0.3);
}

/// A garment of 43,275 vertices that crosses itself: the longest frame while it loads and comes apart, and when it is clean.
#[test]
#[ignore = "measures"]
#[expect(clippy::print_stderr, reason = "the figures are wanted")]
fn a_large_garment_is_loaded_and_untangled_in_the_background() {
    let Some(path) = data("garments/multilayer.obj") else { return };
    let text = std::fs::read_to_string(path).expect("text");
    let numbers = |line: &str| -> Vec<f32> { line.split_whitespace().skip(1).map(|w| w.parse().expect("a number")).collect() };
    let corner = |word: &str| word.split('/').next().and_then(|i| i.parse::<u32>().ok()).expect("an index") - 1;
    let positions: Vec<Vec3> = text.lines().filter(|l| l.starts_with("v ")).map(|l| Vec3::from_slice(&numbers(l))).collect();
    let faces = text.lines().filter(|line| line.starts_with("f "));
    let triangles: Vec<[u32; 3]> = faces
        .map(|line| {
            let mut corners = line.split_whitespace().skip(1).map(corner);
            core::array::from_fn(|_| corners.next().expect("a corner"))
        })
        .collect();
    let mesh = mesh_of(&bevy_drape::solver::rest::SourceMesh { positions, triangles, uvs: Vec::new() });
    let mut app = app();
    app.insert_resource(ClothLoading::default());
    app.insert_resource(ClothBudget { ms: 4.0 });
    app.insert_resource(ClothGravity(Vec3::ZERO));
    app.world_mut().spawn((Camera3d::default(), Transform::from_xyz(0.0, 0.0, 4.0)));
    let cloth = spawn(&mut app, mesh, ());
    let start = Instant::now();
    let (mut longest, mut last) = (Vec::new(), 0.0);
    let mut clean = None;
    while start.elapsed() < Duration::from_secs(20) {
        let frame = Instant::now();
        app.update();
        let ms = frame.elapsed().as_secs_f32() * 1.0e3;
        longest.push((ms, start.elapsed().as_secs_f32()));
        let now = report(&app, cloth);
        if now.time != last {
            last = now.time;
            let costs = [now.integrate_ms, now.detect_ms, now.resolve_ms, now.evaluate_ms, now.respond_ms, now.sync_ms];
            eprintln!(
                "{:.2} s: {} crossings at {last:.3} s, held {}, {} substeps, {} contacts, put off {}, {costs:.1?} ms, {ms:.1} ms",
                start.elapsed().as_secs_f32(),
                now.crossings,
                now.held,
                now.substeps,
                now.contacts,
                now.deferred
            );
            if now.crossings == 0 && clean.is_none() {
                clean = Some(start.elapsed());
            }
        }
        std::thread::sleep(Duration::from_millis(16).saturating_sub(frame.elapsed()));
    }
    longest.sort_by(|a, b| b.0.total_cmp(&a.0));
    eprintln!("clean after {clean:?}; longest frames [ms], at [s]: {:.1?}", &longest[..12.min(longest.len())]);
}
