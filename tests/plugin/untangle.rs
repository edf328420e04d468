//! Cloths that cross come apart in the app, and frames that poke through are held within bounds.

use bevy::app::{TaskPoolOptions, TaskPoolPlugin};
use bevy::prelude::*;
use bevy_drape::prelude::*;
use bevy_drape::{ClothHeld, ClothParticles, ClothTangled, ClothUntangled, ClothUntanglingEscalated};
use drape_scenes::Tangle;

use crate::common::*;

const TWO_SECONDS: usize = 120;

/// Two sheets in each other, floating.
fn tangled(app: &mut App, tangle: Tangle, n: u32, at: Vec3) -> [Entity; 2] {
    app.insert_resource(ClothGravity(Vec3::ZERO));
    tangle.meshes(n).map(|mesh| spawn(app, mesh_of(&mesh), Transform::from_translation(at)))
}

fn crossings(app: &App, cloths: &[Entity]) -> u32 {
    cloths.iter().map(|&c| report(app, c).crossings).sum()
}

#[test]
fn two_sheets_spawned_tangled_come_apart_within_two_seconds_and_say_so() {
    let mut app = app();
    record::<ClothTangled>(&mut app);
    record::<ClothUntangled>(&mut app);
    let cloths = tangled(&mut app, Tangle::StripStab, 13, Vec3::Y);
    // One frame is enough for this one: it may only look at first.
    let only = |app: &mut App, iterations: u32| {
        for cloth in cloths {
            app.world_mut().entity_mut(cloth).insert(ClothUntangling { iterations, ..default() });
        }
    };
    only(&mut app, 0);
    run(&mut app, 2);
    let first = report(&app, cloths[0]).clone();
    assert!(first.crossings > 0 && first.contours == 1 && first.contour_length > 0.1, "{first:?}");
    assert!(!first.held, "there is no clean shape to hold");
    assert_eq!(seen::<ClothTangled>(&app).len(), 2);
    only(&mut app, ClothUntangling::default().iterations);
    run(&mut app, TWO_SECONDS);
    assert_eq!(crossings(&app, &cloths), 0, "{:?}", report(&app, cloths[0]));
    // Without contacts they may touch again on their way apart.
    assert_eq!(seen::<ClothUntangled>(&app).len(), seen::<ClothTangled>(&app).len());
    assert!(seen::<ClothUntangled>(&app).iter().all(|e| e.after > 0.0 && e.after < 2.0));
}

#[test]
fn a_cloth_that_takes_no_part_is_left_alone_and_the_other_gets_off_it() {
    let mut app = app();
    let cloths = tangled(&mut app, Tangle::Dent, 13, Vec3::Y);
    // Without contact, too, which would push it when they touch.
    let alone = (ClothUntanglingDisabled, ClothCollision { contact: false, ..default() });
    app.world_mut().entity_mut(cloths[0]).insert(alone);
    run(&mut app, 1);
    let before = particles(&app, cloths[0]);
    run(&mut app, TWO_SECONDS);
    assert_eq!(crossings(&app, &cloths), 0);
    let moved = before.iter().zip(particles(&app, cloths[0])).map(|(a, b)| a.distance(b)).fold(0.0, f32::max);
    assert!(moved < 1.0e-5, "{moved} m");
}

#[test]
fn untangling_is_switched_off_and_on_while_cloths_cross() {
    let mut app = app();
    let cloths = tangled(&mut app, Tangle::StripStab, 13, Vec3::Y);
    let off = |app: &mut App, off: bool| {
        for cloth in cloths {
            let mut cloth = app.world_mut().entity_mut(cloth);
            if off {
                cloth.insert(ClothUntanglingDisabled);
            } else {
                cloth.remove::<ClothUntanglingDisabled>();
            }
        }
    };
    off(&mut app, true);
    run(&mut app, 2);
    assert!(crossings(&app, &cloths) > 0 && report(&app, cloths[0]).iterations == 0, "off: {:?}", report(&app, cloths[0]));
    off(&mut app, false);
    run(&mut app, 1);
    assert!(report(&app, cloths[0]).iterations > 0, "on: {:?}", report(&app, cloths[0]));
    off(&mut app, true);
    run(&mut app, 1);
    assert_eq!(report(&app, cloths[0]).iterations, 0, "off again");
    off(&mut app, false);
    run(&mut app, TWO_SECONDS);
    assert_eq!(crossings(&app, &cloths), 0, "{:?}", report(&app, cloths[0]));
}

#[test]
fn cloths_that_are_switched_off_while_they_cross_tell_of_it_once() {
    let mut app = app();
    record::<ClothTangled>(&mut app);
    let cloths = tangled(&mut app, Tangle::StripStab, 13, Vec3::Y);
    for cloth in cloths {
        app.world_mut().entity_mut(cloth).insert(ClothUntangling { iterations: 0, ..default() });
    }
    for _ in 0..3 {
        if seen::<ClothTangled>(&app).is_empty() {
            run(&mut app, 1);
        }
    }
    assert_eq!(seen::<ClothTangled>(&app).len(), 2);
    for cloth in cloths {
        app.world_mut().entity_mut(cloth).insert(ClothDisabled);
    }
    run(&mut app, 10);
    assert_eq!(seen::<ClothTangled>(&app).len(), 2, "it is told again and again");
    for cloth in cloths {
        app.world_mut().entity_mut(cloth).insert(ClothUntangling::default()).remove::<ClothDisabled>();
    }
    run(&mut app, TWO_SECONDS);
    assert_eq!(crossings(&app, &cloths), 0);
}

#[test]
fn clean_cloths_have_the_same_bits_with_and_without_untangling() {
    let run_with = |enabled: bool| {
        let mut app = app();
        let cloths = [0.0, 0.2].map(|z| {
            let place = Transform::from_xyz(0.01, 2.0 + 0.5 * z, z);
            let cloth = spawn(&mut app, sheet(16), (border(), place));
            if !enabled {
                app.world_mut().entity_mut(cloth).insert(ClothUntanglingDisabled);
            }
            cloth
        });
        for frame in 0..90 {
            run(&mut app, 1);
            let report = report(&app, cloths[0]);
            assert_eq!(report.iterations, 0, "not clean in frame {frame}: {report:?}");
        }
        cloths.map(|c| app.world().get::<ClothParticles>(c).expect("a bound cloth").state().clone())
    };
    assert!(run_with(true) == run_with(false), "clean cloths were moved");
}

/// Which of `frames` frames held each of two cloths, while one hanging sheet is driven through the other back and forth.
fn driven(app: &mut App, skip: ClothSkipFrame, frames: usize) -> Vec<[bool; 2]> {
    // With contacts they would not cross.
    let through = ClothCollision { contact: false, ..default() };
    let wall = spawn(app, sheet(14), (border(), Transform::from_xyz(0.0, 2.0, 0.0), skip, through));
    let moving = spawn(app, sheet(14), (border(), Transform::from_xyz(0.07, 2.2, -0.5), skip, through));
    let mut held = Vec::new();
    for frame in 0..frames {
        let along = (frame as f32 * FRAME * 3.0).sin();
        app.world_mut().get_mut::<Transform>(moving).expect("a transform").translation.y = 1.9 + 0.4 * along;
        app.world_mut().get_mut::<Transform>(moving).expect("a transform").translation.z = -0.5 + 0.8 * along;
        app.update();
        held.push([wall, moving].map(|cloth| report(app, cloth).held));
        assert!(finite(app, wall) && finite(app, moving));
    }
    held
}

#[test]
fn at_most_two_frames_in_a_row_and_a_tenth_of_any_second_are_held() {
    let mut app = app();
    record::<ClothHeld>(&mut app);
    record::<ClothTangled>(&mut app);
    let held = driven(&mut app, ClothSkipFrame::default(), 300);
    let any = held.iter().filter(|h| h.contains(&true)).count();
    assert!(!seen::<ClothTangled>(&app).is_empty() && any > 0, "{any} frames held");
    assert!(!seen::<ClothHeld>(&app).is_empty());
    let each = |e: &ClothHeld| seen::<ClothTangled>(&app).iter().any(|t| t.entity == e.entity);
    assert!(seen::<ClothHeld>(&app).iter().all(each));
    for cloth in 0..2 {
        let held: Vec<bool> = held.iter().map(|h| h[cloth]).collect();
        assert!(held.windows(3).all(|w| w != [true; 3]), "cloth {cloth}, three in a row: {held:?}");
        let most = held.windows(60).map(|w| w.iter().filter(|&&h| h).count()).max().unwrap_or(0);
        assert!(most <= 6, "cloth {cloth}: {most} of 60 frames");
    }
    let mut app = app_with(ClothPlugin::default());
    assert!(driven(&mut app, ClothSkipFrame::OFF, 120).iter().all(|h| !h.contains(&true)));
}

#[test]
fn a_cloth_that_is_not_a_number_changes_no_bit_of_another() {
    let run_with = |poison: Option<f32>| {
        let mut app = app();
        let cloths = tangled(&mut app, Tangle::Waves, 13, Vec3::Y);
        let stray = spawn(&mut app, sheet(8), Transform::from_xyz(0.0, 1.9, 0.0));
        run(&mut app, 2);
        for _ in 0..20 {
            if let (Some(value), Some(mut particles)) = (poison, app.world_mut().get_mut::<ClothParticles>(stray)) {
                particles.state_mut().positions[5].y = value;
            }
            app.update();
            assert!(finite(&app, stray));
        }
        cloths.map(|c| app.world().get::<ClothParticles>(c).expect("a bound cloth").state().clone())
    };
    let healthy = run_with(None);
    for poison in [f32::NAN, f32::INFINITY, 1.0e30] {
        assert!(run_with(Some(poison)) == healthy, "{poison} spread");
    }
}

/// Bits of everything after a while, folded.
fn bits(threads: usize) -> u64 {
    let mut app = App::new();
    let options = TaskPoolOptions::with_num_threads(threads);
    app.add_plugins((
        MinimalPlugins.set(TaskPoolPlugin { task_pool_options: options }),
        TransformPlugin,
        AssetPlugin::default(),
        bevy::mesh::MeshPlugin,
        ClothPlugin::default(),
    ));
    frame_length(&mut app, FRAME);
    app.finish();
    app.cleanup();
    app.update();
    let mut cloths = Vec::new();
    for (i, tangle) in Tangle::ALL.into_iter().enumerate() {
        cloths.extend(tangled(&mut app, tangle, 13, Vec3::new(3.0 * i as f32, 0.0, 0.0)));
    }
    run(&mut app, 30);
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for cloth in cloths {
        let state = app.world().get::<ClothParticles>(cloth).expect("a bound cloth").state();
        for value in state.positions.iter().chain(&state.previous).flat_map(Vec4::to_array) {
            hash = (hash ^ u64::from(value.to_bits())).wrapping_mul(0x0100_0000_01b3);
        }
    }
    hash
}

#[test]
#[ignore = "started by the test below: there is one task pool per process"]
#[expect(clippy::print_stdout, reason = "tells its parent")]
fn prints_the_bits() {
    if let Some(threads) = std::env::var("CLOTH_THREADS").ok().and_then(|t| t.parse().ok()) {
        // The first app decides how many threads the process has.
        let tangles = bits(threads);
        let apps: Vec<_> = crate::bits::in_apps().into_iter().map(|app| format!("{:x}", app.hash())).collect();
        println!("bits {tangles:x},{}", apps.join(","));
    }
}

#[test]
fn the_bits_are_the_same_for_one_two_and_four_threads() {
    let run = |threads: usize| {
        let output = std::process::Command::new(std::env::current_exe().expect("this test"))
            .args(["--exact", "untangle::prints_the_bits", "--ignored", "--nocapture"])
            .env("CLOTH_THREADS", threads.to_string())
            .output()
            .expect("this test runs again");
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        text.split("bits ").nth(1).map(|rest| rest.split_whitespace().next().unwrap_or_default().to_string())
    };
    let one = run(1);
    assert!(one.is_some(), "the other process prints nothing");
    assert_eq!([run(2), run(4)], [one.clone(), one]);
}

#[test]
fn cloths_that_start_tangled_are_apart_when_first_shown_if_asked() {
    for tangle in [Tangle::StripStab, Tangle::FullCut, Tangle::Waves] {
        let mut app = app();
        record::<ClothTangled>(&mut app);
        app.insert_resource(ClothGravity(Vec3::ZERO));
        let ask = ClothUntangling { at_load: true, ..default() };
        let cloths = tangle.meshes(13).map(|mesh| spawn(&mut app, mesh_of(&mesh), (Transform::default(), ask)));
        run(&mut app, 5);
        assert_eq!((crossings(&app, &cloths), seen::<ClothTangled>(&app).len()), (0, 0), "{tangle:?}");
    }
}

#[test]
fn of_equal_settings_those_of_the_cloth_that_was_spawned_first_hold() {
    for (methods, is_clean) in [
        ([ClothUntanglingMethod::ByEndType, ClothUntanglingMethod::History], true),
        ([ClothUntanglingMethod::History, ClothUntanglingMethod::ByEndType], false),
    ] {
        let mut app = app();
        app.insert_resource(ClothGravity(Vec3::ZERO));
        let [first, second] = Tangle::FullCut.meshes(13).map(|mesh| mesh_of(&mesh));
        let ask = |method| (Transform::default(), ClothUntangling { method, ..default() });
        let first = spawn(&mut app, first, ask(methods[0]));
        let second = spawn(&mut app, second, ask(methods[1]));
        run(&mut app, 50);
        assert_eq!(crossings(&app, &[first, second]) == 0, is_clean, "{methods:?}");
    }
}

#[test]
fn the_game_is_told_of_last_resorts() {
    let mut app = app();
    record::<ClothUntanglingEscalated>(&mut app);
    app.insert_resource(ClothGravity(Vec3::ZERO));
    let idle = ClothUntangling { iterations: 0, ..default() };
    let cloths = Tangle::DeepDent.meshes(13).map(|mesh| spawn(&mut app, mesh_of(&mesh), (Transform::default(), idle)));
    let off = ClothUntanglingDisabled;
    for mesh in Tangle::DeepDent.meshes(13) {
        spawn(&mut app, mesh_of(&mesh), (Transform::from_xyz(10.0, 0.0, 0.0), off));
    }
    run(&mut app, 50);
    assert!(seen::<ClothUntanglingEscalated>(&app).is_empty(), "not before a second");
    run(&mut app, 20);
    let told: Vec<Entity> = seen::<ClothUntanglingEscalated>(&app).iter().map(|e| e.entity).collect();
    assert!(cloths.iter().all(|c| told.contains(c)) && told.len() == 2, "{told:?}");
}

/// Two sheets that cross at a pinned edge: contacts that did not know of it would pull at the crossing from both sides.
#[test]
fn crossings_of_cloths_that_are_not_untangled_are_counted_and_left_alone() {
    let mut app = app();
    let off = ClothUntanglingDisabled;
    let turn = |angle: f32| Transform::from_rotation(Quat::from_rotation_y(angle));
    let cloths = [0.0, 0.5].map(|angle| {
        let stands = Quat::from_rotation_x(core::f32::consts::FRAC_PI_2);
        spawn(&mut app, sheet(20), (turn(angle) * Transform::from_rotation(stands), border(), off))
    });
    run(&mut app, 300);
    let fastest = |app: &App, cloth: Entity| {
        let state = app.world().get::<ClothParticles>(cloth).expect("particles").state();
        (0..state.positions.len()).map(|i| state.velocity(i).length()).fold(0.0, f32::max)
    };
    for cloth in cloths {
        let report = report(&app, cloth);
        let fastest = fastest(&app, cloth);
        assert!(
            report.crossings > 10 && report.iterations == 0 && fastest < 0.1,
            "{} crossings, {fastest} m/s",
            report.crossings
        );
    }
}
