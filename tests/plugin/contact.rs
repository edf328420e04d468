//! Cloth on cloth, and on itself.

use bevy::prelude::*;
use bevy_drape::ClothParticles;
use bevy_drape::prelude::*;

use crate::common::*;

/// Two sheets above a ball, one above the other.
fn pile(app: &mut App, n: u32, extra: impl Bundle + Clone) -> [Entity; 2] {
    app.world_mut().spawn((Transform::default(), ClothCollider::ball(0.3)));
    [0.4, 0.43].map(|y| {
        let turn = Quat::from_rotation_y(10.0 * y);
        spawn(app, sheet(n), (Transform::from_xyz(0.0, y, 0.0).with_rotation(turn), extra.clone()))
    })
}

#[test]
fn two_sheets_dropped_on_a_ball_rest_on_each_other_and_never_cross() {
    let mut app = app();
    let cloths = pile(&mut app, 20, ());
    let mut touched = 0;
    for frame in 0..120 {
        run(&mut app, 1);
        for cloth in cloths {
            let report = report(&app, cloth);
            assert_eq!(report.crossings, 0, "frame {frame}: {report:?}");
            touched = touched.max(report.contacts);
        }
    }
    assert!(touched > 30, "at most {touched} pairs touched");
    // Over the ball they lie one thickness apart.
    let middle = |cloth: Entity| {
        let over = world_positions(&app, cloth).into_iter().filter(|p| p.xz().length() < 0.05).map(|p| p.y);
        over.fold(f32::NEG_INFINITY, f32::max)
    };
    let gap = middle(cloths[1]) - middle(cloths[0]);
    assert!((0.003..0.02).contains(&gap), "{gap} m apart");
}

#[test]
fn piles_apart_from_each_other_each_remember_their_contacts() {
    let mut app = app();
    let cloths = [0.0, 5.0, 10.0].map(|x| {
        app.world_mut().spawn((Transform::from_xyz(x, 0.0, 0.0), ClothCollider::ball(0.3)));
        [0.4, 0.43]
            .map(|y| spawn(&mut app, sheet(14), Transform::from_xyz(x, y, 0.0).with_rotation(Quat::from_rotation_y(10.0 * y))))
    });
    run(&mut app, 120);
    for pile in cloths {
        assert!(pile.iter().all(|&cloth| report(&app, cloth).contacts > 10), "{:?}", pile.map(|c| report(&app, c).contacts));
    }
}

#[test]
fn without_contact_cloths_pass_through_each_other() {
    let mut app = app();
    let alone = || (ClothCollision { contact: false, ..default() }, ClothUntanglingDisabled);
    let cloths = pile(&mut app, 12, alone());
    run(&mut app, 60);
    assert!(cloths.iter().all(|&c| report(&app, c).contacts == 0));
    // One is enough.
    app.world_mut().entity_mut(cloths[0]).insert(ClothCollision { self_collision: false, ..default() });
    run(&mut app, 60);
    assert!(cloths.iter().all(|&c| report(&app, c).contacts == 0));
}

#[test]
fn members_of_a_pile_come_go_pause_and_start_anew() {
    let mut app = app();
    let cloths = pile(&mut app, 16, ());
    run(&mut app, 30);
    // One stops: the other still rests on it.
    app.world_mut().get_mut::<ClothSolver>(cloths[0]).expect("settings").time_scale = 0.0;
    let state = |app: &App| app.world().get::<ClothParticles>(cloths[0]).expect("a cloth").state().clone();
    let still = state(&app);
    run(&mut app, 20);
    let moved = still.positions.iter().zip(&state(&app).positions).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    assert!(moved == 0.0, "a paused cloth was moved by {moved} m");
    assert_eq!(report(&app, cloths[1]).crossings, 0);
    app.world_mut().get_mut::<ClothSolver>(cloths[0]).expect("settings").time_scale = 1.0;
    // One comes with other substeps, one gets another mesh, one goes.
    let third =
        spawn(&mut app, sheet(9), (Transform::from_xyz(0.0, 0.5, 0.0), ClothSolver { substep_rate: 720.0, ..default() }));
    run(&mut app, 20);
    let other = add(&mut app, sheet(11));
    app.world_mut().entity_mut(cloths[1]).insert(Mesh3d(other));
    run(&mut app, 20);
    app.world_mut().entity_mut(cloths[0]).despawn();
    run(&mut app, 20);
    for cloth in [cloths[1], third] {
        assert!(finite(&app, cloth) && report(&app, cloth).crossings == 0, "{:?}", report(&app, cloth));
    }
}

#[test]
fn what_is_not_a_number_in_one_cloth_stays_there() {
    let run_with = |bad: bool| {
        let mut app = app();
        let [lower, upper] = pile(&mut app, 12, ());
        // Out of reach of the bad one, in the same app.
        let apart = spawn(&mut app, sheet(12), (border(), Transform::from_xyz(5.0, 0.0, 0.0)));
        run(&mut app, 10);
        if bad {
            app.world_mut().get_mut::<Transform>(upper).expect("a transform").translation.y = f32::NAN;
        }
        run(&mut app, 30);
        assert!(finite(&app, lower) && finite(&app, apart));
        app.world().get::<ClothParticles>(apart).expect("a cloth").state().clone()
    };
    assert!(run_with(true) == run_with(false));
}

#[test]
fn cloths_that_are_not_untangled_still_rest_on_each_other() {
    let mut app = app();
    let cloths = pile(&mut app, 16, ClothUntanglingDisabled);
    run(&mut app, 60);
    assert!(cloths.iter().all(|&c| report(&app, c).contacts > 10 || report(&app, c).crossings == 0));
    let lowest_over_ball = |cloth: Entity| {
        world_positions(&app, cloth).into_iter().filter(|p| p.xz().length() < 0.1).map(|p| p.y).fold(f32::INFINITY, f32::min)
    };
    assert!(cloths.iter().all(|&c| lowest_over_ball(c) > 0.25), "a sheet fell through");
}

#[test]
fn a_particle_that_is_thrown_far_away_is_taken_back_before_another_cloth_meets_it() {
    let after = |thrown: bool| {
        let mut app = app();
        let [lower, upper] = pile(&mut app, 16, ());
        run(&mut app, 60);
        for frame in 0..3 {
            let mut particles = app.world_mut().get_mut::<ClothParticles>(upper).expect("a cloth");
            if thrown {
                particles.state_mut().positions[100 + frame].y -= 100.0;
            }
            run(&mut app, 1);
        }
        assert_eq!((report(&app, upper).restores, report(&app, lower).restores), (if thrown { 3 } else { 0 }, 0));
        assert_eq!(report(&app, lower).crossings, 0);
        particles(&app, lower)
    };
    let moved = after(true).iter().zip(after(false)).map(|(a, b)| a.distance(b)).fold(0.0, f32::max);
    assert!(moved < 0.01, "a particle of the other cloth is {moved} m off");
}
