//! The budget: what all cloths together may cost.

use bevy::prelude::*;
use bevy_drape::prelude::*;

use crate::common::*;

/// Hanging sheets in a row, before a camera.
fn row(count: u32) -> (App, Vec<Entity>) {
    let mut app = app();
    app.world_mut().spawn((Camera3d::default(), Transform::from_xyz(0.0, 0.0, 4.0)));
    let place = |i: u32| Transform::from_xyz(2.0 * i as f32, 0.0, 0.0);
    let cloths = (0..count).map(|i| spawn(&mut app, sheet(12), (border(), place(i), ClothSleepDisabled))).collect();
    run(&mut app, 5);
    (app, cloths)
}

fn details(app: &App, cloths: &[Entity]) -> Vec<ClothDetail> {
    cloths.iter().map(|cloth| report(app, *cloth).detail).collect()
}

#[test]
fn what_is_far_too_much_stands_still_without_a_jump_and_comes_back() {
    let (mut app, cloths) = row(6);
    app.insert_resource(ClothBudget { ms: 0.01 });
    let mut before: Vec<Vec<Vec3>> = cloths.iter().map(|cloth| particles(&app, *cloth)).collect();
    let mut farthest = 0.0f32;
    for _ in 0..90 {
        run(&mut app, 1);
        for (before, cloth) in before.iter_mut().zip(&cloths) {
            let now = particles(&app, *cloth);
            farthest = before.iter().zip(&now).map(|(a, b)| a.distance(*b)).fold(farthest, f32::max);
            *before = now;
        }
    }
    assert!(details(&app, &cloths).iter().all(|detail| *detail == ClothDetail::Still), "{:?}", details(&app, &cloths));
    assert!(cloths.iter().all(|cloth| report(&app, *cloth).by_budget == ClothDetail::Still));
    // They fall in free fall at the most: 1.5 s of that is 15 m/s.
    assert!(farthest < 0.25, "a particle went {farthest} m in a frame");
    app.insert_resource(ClothBudget { ms: 1000.0 });
    run(&mut app, 90);
    assert!(details(&app, &cloths).iter().all(|detail| *detail == ClothDetail::Full), "{:?}", details(&app, &cloths));
    app.insert_resource(ClothBudget { ms: 0.01 });
    run(&mut app, 90);
    app.world_mut().remove_resource::<ClothBudget>();
    run(&mut app, 1);
    assert!(details(&app, &cloths).iter().all(|detail| *detail == ClothDetail::Full), "without a budget");
}

#[test]
fn a_cloth_changes_at_most_once_a_second_unless_it_falls_again() {
    let (mut app, cloths) = row(3);
    let mut last = vec![(ClothDetail::Full, -100i32, false); cloths.len()];
    for frame in 0..200i32 {
        // It is too much, enough and too much again, in turns of half a second.
        app.insert_resource(ClothBudget { ms: if frame / 30 % 2 == 0 { 0.01 } else { 1000.0 } });
        run(&mut app, 1);
        for ((detail, at, fell), cloth) in last.iter_mut().zip(&cloths) {
            let now = report(&app, *cloth).by_budget;
            if now != *detail {
                let falls = now > *detail;
                assert!(frame - *at >= 60 || (*fell && falls), "changed in frames {at} and {frame}");
                (*detail, *at, *fell) = (now, frame, falls);
            }
        }
    }
    assert!(last.iter().all(|(_, at, _)| *at > 0), "{last:?}");
}

#[test]
fn what_has_priority_keeps_its_detail() {
    let (mut app, cloths) = row(4);
    app.world_mut().entity_mut(cloths[3]).insert(ClothPriority(1.0e4));
    run(&mut app, 30);
    let cost = |app: &App, cloth: &Entity| {
        let r = report(app, *cloth);
        r.integrate_ms + r.detect_ms + r.resolve_ms + r.evaluate_ms + r.respond_ms + r.sync_ms
    };
    let all: f32 = cloths.iter().map(|cloth| cost(&app, cloth)).sum();
    app.insert_resource(ClothBudget { ms: 0.6 * all });
    run(&mut app, 10);
    let details = details(&app, &cloths);
    assert!(details[..3].iter().any(|detail| *detail > ClothDetail::Full), "{details:?}");
    assert!(details[3] == ClothDetail::Full || details[..3].iter().all(|detail| *detail == ClothDetail::Still), "{details:?}");
}

#[test]
fn a_budget_that_cannot_be_used_is_told_of_once_and_works() {
    let (mut app, cloths) = row(1);
    for ms in [f32::NAN, 0.0, -1.0, f32::INFINITY] {
        app.insert_resource(ClothBudget { ms });
        app.world_mut().entity_mut(cloths[0]).insert(ClothPriority(f32::NAN));
        run(&mut app, 30);
        assert!(finite(&app, cloths[0]), "{ms}");
    }
    app.world_mut().entity_mut(cloths[0]).despawn();
    run(&mut app, 2);
}
