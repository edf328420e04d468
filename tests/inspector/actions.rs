//! Time, rest, tangles and picking.

use bevy::prelude::*;
use bevy_drape::ClothDebug;
use bevy_drape::inspector::{ClothInspector, SPAN, STEP, Verdict, pick};
use bevy_drape::prelude::*;

use crate::common::*;
use crate::panel::{Panel, app_with_panel};

fn now(panel: &mut Panel) -> f64 {
    panel.app().world().resource::<Time<Virtual>>().elapsed_secs_f64()
}

#[test]
fn time_stops_steps_slows_and_goes_on() {
    let mut panel = Panel::new();
    panel.click("pause");
    let (cloth, start) = (panel.cloth, now(&mut panel));
    let before = particles(panel.app(), cloth);
    run(panel.app(), 5);
    assert_eq!((now(&mut panel), particles(panel.app(), cloth) == before), (start, true), "it went on");
    panel.click("step one frame");
    run(panel.app(), 5);
    let passed = now(&mut panel) - start;
    assert!((passed - STEP).abs() < 1.0e-6, "{passed} s");
    assert_ne!(particles(panel.app(), cloth), before, "nothing was simulated");
    panel.type_into("time pace", "0.25");
    panel.click("run");
    let start = now(&mut panel);
    run(panel.app(), 60);
    let passed = now(&mut panel) - start;
    assert!((passed - 0.25).abs() < 0.01, "{passed} s in a second of slow motion");
}

#[test]
fn a_cloth_is_put_back_to_rest_without_speed() {
    let mut panel = Panel::new();
    let cloth = panel.cloth;
    let start = particles(panel.app(), cloth);
    run(panel.app(), 90);
    let fallen = start.iter().zip(particles(panel.app(), cloth)).map(|(a, b)| a.distance(b)).fold(0.0, f32::max);
    assert!(fallen > 0.3, "it fell by {fallen} m");
    panel.click("pause");
    panel.click("reset to rest");
    run(panel.app(), 2);
    let off = positions(panel.app(), cloth).iter().map(|p| p.y.abs()).fold(0.0, f32::max);
    assert!(off < 1.0e-4, "{off} m from flat");
    panel.click("run");
    run(panel.app(), 1);
    let moved = particles(panel.app(), cloth).iter().map(|p| (p.y - 2.0).abs()).fold(0.0, f32::max);
    assert!(moved < 0.01, "{moved} m in the first frame");
}

#[test]
fn a_cloth_is_tangled_on_purpose_with_itself_and_comes_apart() {
    let mut app = app_with_panel();
    app.insert_resource(ClothGravity(Vec3::ZERO));
    let cloth = spawn(&mut app, sheet(16), Transform::from_xyz(0.0, 2.0, 0.0));
    let other = spawn(&mut app, sheet(8), Transform::from_xyz(9.0, 2.0, 0.0));
    app.world_mut().entity_mut(cloth).insert(ClothUntangling { iterations: 0, ..default() });
    run(&mut app, 5);
    let mut panel = Panel::over(app, cloth, other);
    panel.click("fold through itself");
    run(panel.app(), 2);
    let tangled = report(panel.app(), cloth).clone();
    assert!(tangled.crossings > 0 && tangled.restores == 0 && tangled.resets == 0, "{tangled:?}");
    assert_eq!(report(panel.app(), other).crossings, 0);
    panel.app().world_mut().entity_mut(cloth).insert(ClothUntangling::default());
    run(panel.app(), 240);
    let after = report(panel.app(), cloth).clone();
    assert_eq!(after.crossings, 0, "{} crossings before", tangled.crossings);
    // The curves have seen it.
    let history = panel.app().world().resource::<ClothInspector>().history();
    assert!(history.samples().any(|s| s.crossings > 0 && s.verdict != Verdict::Clean));
    assert_eq!(history.newest().map(|s| s.verdict), Some(Verdict::Clean));
}

#[test]
fn a_cloth_is_pushed_through_the_nearest_other_pinned_or_not() {
    for pins in [ClothPins::NONE, border()] {
        let mut app = app_with_panel();
        app.insert_resource(ClothGravity(Vec3::ZERO));
        let idle = ClothUntangling { iterations: 0, ..default() };
        let cloth = spawn(&mut app, sheet(16), (Transform::from_xyz(0.1, 2.3, 0.05), pins.clone(), idle));
        let near = spawn(&mut app, sheet(16), (Transform::from_xyz(0.0, 2.0, 0.0), idle));
        let far = spawn(&mut app, sheet(16), (Transform::from_xyz(0.0, 4.0, 0.0), idle));
        run(&mut app, 5);
        let mut panel = Panel::over(app, cloth, near);
        panel.click("push through nearest");
        run(panel.app(), 2);
        let crossings = [cloth, near, far].map(|c| report(panel.app(), c).crossings);
        assert!(
            crossings[0] > 0 && crossings[1] > 0 && crossings[2] == 0,
            "{crossings:?} with {} pins: {:?}",
            pins.sets.len(),
            report(panel.app(), cloth)
        );
        assert_eq!(report(panel.app(), cloth).restores, 0);
    }
}

/// A sheet that sleeps on the ground, and another far away that does.
fn asleep() -> Panel {
    let mut app = app_with_panel();
    app.world_mut().spawn(ClothCollider::ground());
    let cloth = spawn(&mut app, sheet(10), Transform::from_xyz(0.0, 0.05, 0.0));
    let other = spawn(&mut app, sheet(8), Transform::from_xyz(6.0, 0.05, 0.0));
    run(&mut app, 400);
    let sleeping = [cloth, other].map(|cloth| report(&app, cloth).asleep);
    assert_eq!(sleeping, [true, true]);
    Panel::over(app, cloth, other)
}

#[test]
fn what_the_buttons_do_to_a_cloth_that_sleeps_is_seen_at_once() {
    for (button, paused) in [("fold through itself", false), ("reset to rest", false), ("reset to rest", true)] {
        let mut panel = asleep();
        let cloth = panel.cloth;
        let before = positions(panel.app(), cloth);
        if paused {
            panel.click("pause");
        }
        panel.click(button);
        run(panel.app(), 2);
        assert!(!report(panel.app(), cloth).asleep || paused, "{button}");
        assert_ne!(positions(panel.app(), cloth), before, "{button}, paused {paused}");
        let other = panel.other;
        assert!(report(panel.app(), other).asleep, "{button} is of no concern to a cloth that lies far away");
    }
}

#[test]
fn what_lay_on_a_cloth_that_is_reset_wakes_with_it() {
    let mut app = app_with_panel();
    app.world_mut().spawn(ClothCollider::ground());
    let low = spawn(&mut app, sheet(10), Transform::from_xyz(0.0, 0.3, 0.0));
    run(&mut app, 60);
    let high = spawn(&mut app, sheet(10), Transform::from_xyz(0.0, 0.05, 0.0));
    run(&mut app, 700);
    assert_eq!([low, high].map(|cloth| report(&app, cloth).asleep), [true, true]);
    let mut panel = Panel::over(app, low, high);
    panel.click("reset to rest");
    run(panel.app(), 2);
    assert_eq!([low, high].map(|cloth| report(panel.app(), cloth).asleep), [false, false]);
}

#[test]
fn a_cloth_that_is_gone_before_a_button_acts_is_no_harm() {
    for button in ["reset to rest", "fold through itself", "push through nearest"] {
        let mut panel = Panel::new();
        let cloth = panel.cloth;
        panel.click(button);
        panel.app().world_mut().despawn(cloth);
        run(panel.app(), 2);
        panel.steps(2);
    }
}

#[test]
fn a_cloth_that_was_stopped_goes_on_after_a_reset() {
    let mut panel = Panel::new();
    let cloth = panel.cloth;
    for _ in 0..600 {
        let mut particles = panel.app().world_mut().get_mut::<ClothParticles>(cloth).expect("a cloth");
        particles.state_mut().positions[20].x = f32::NAN;
        run(panel.app(), 1);
        if status(panel.app(), cloth) == ClothStatus::Failed {
            break;
        }
    }
    assert_eq!(status(panel.app(), cloth), ClothStatus::Failed);
    // The reason takes room: what is below it moves.
    panel.steps(2);
    panel.click("reset to rest");
    run(panel.app(), 3);
    assert_eq!(status(panel.app(), cloth), ClothStatus::Active);
    let start = particles(panel.app(), cloth);
    run(panel.app(), 20);
    assert!(finite(panel.app(), cloth) && particles(panel.app(), cloth) != start, "it does not move");
}

#[test]
fn without_another_cloth_the_reason_is_shown() {
    let mut app = app_with_panel();
    let cloth = spawn(&mut app, sheet(8), border());
    run(&mut app, 3);
    let mut panel = Panel::over(app, cloth, cloth);
    panel.click("push through nearest");
    run(panel.app(), 1);
    panel.steps(2);
    assert!(panel.shows("there is no other cloth"));
}

#[test]
fn a_ray_picks_the_nearer_cloth_that_is_shown() {
    let mut app = app_with_panel();
    app.insert_resource(ClothGravity(Vec3::ZERO));
    let low = spawn(&mut app, sheet(8), Transform::from_xyz(100.0, 1.0, 0.0));
    let high = spawn(&mut app, sheet(8), Transform::from_xyz(100.0, 2.0, 0.0));
    run(&mut app, 3);
    let picked = |app: &mut App, x: f32| pick(app.world_mut(), Ray3d::new(Vec3::new(x, 5.0, 0.1), Dir3::NEG_Y));
    assert_eq!(picked(&mut app, 100.1).map(|hit| hit.0), Some(high));
    assert!((picked(&mut app, 100.1).map_or(0.0, |hit| hit.1) - 3.0).abs() < 1.0e-3);
    assert_eq!(picked(&mut app, 101.0), None, "beside both");
    app.world_mut().despawn(high);
    assert_eq!(picked(&mut app, 100.1).map(|hit| hit.0), Some(low));
}

#[test]
fn a_cloth_is_chosen_in_the_list_and_replaced_when_it_is_gone() {
    let mut panel = Panel::new();
    panel.click("second");
    let (cloth, other) = (panel.cloth, panel.other);
    assert_eq!(panel.app().world().resource::<ClothInspector>().selected, Some(other));
    panel.app().world_mut().despawn(other);
    panel.steps(2);
    assert_eq!(panel.app().world().resource::<ClothInspector>().selected, Some(cloth));
    panel.app().world_mut().despawn(cloth);
    panel.steps(2);
    assert!(panel.shows("there is no cloth"));
}

#[test]
fn the_curves_are_of_the_chosen_cloth_and_no_longer_than_ten_seconds() {
    let mut panel = Panel::new();
    run(panel.app(), 700);
    panel.steps(1);
    let history = panel.app().world().resource::<ClothInspector>().history();
    let times: Vec<f64> = history.samples().map(|s| s.time).collect();
    let span = times.last().unwrap_or(&0.0) - times.first().unwrap_or(&0.0);
    assert!(times.is_sorted() && (0.97 * SPAN..=SPAN).contains(&span), "{} samples over {span} s", times.len());
    assert!(history.samples().any(|s| s.kinetic > 0.0) && history.samples().all(|s| s.kinetic.is_finite()));
    panel.click("second");
    run(panel.app(), 1);
    assert_eq!(panel.app().world().resource::<ClothInspector>().history().samples().count(), 1);
}

#[test]
fn the_curves_go_on_while_an_app_draws_the_panel_in_a_window_of_its_own() {
    let mut panel = Panel::new();
    panel.app().world_mut().resource_mut::<ClothInspector>().open = false;
    let kept = |panel: &mut Panel| panel.app().world().resource::<ClothInspector>().history().newest().map(|s| s.time);
    run(panel.app(), 1);
    let before = kept(&mut panel);
    run(panel.app(), 20);
    assert_eq!(kept(&mut panel), before, "nobody sees it");
    panel.steps(1);
    run(panel.app(), 1);
    assert!(kept(&mut panel) > before);
}

#[test]
fn items_of_the_debug_drawing_are_switched_one_by_one_with_their_legend() {
    let mut panel = Panel::new();
    panel.click("Debug drawing");
    panel.steps(6);
    assert!(panel.shows("add ClothDebugPlugin"));
    panel.app().insert_resource(ClothDebug::none());
    panel.app().world_mut().clear_trackers();
    panel.steps(3);
    assert!(!panel.app().world().resource_ref::<ClothDebug>().is_changed(), "it was marked as changed by being shown");
    for name in ClothDebug::ITEMS {
        panel.click(&format!("draw {name}"));
        assert_eq!(*panel.app().world().resource::<ClothDebug>(), ClothDebug::only([name]), "{name}");
        let legend = panel.app().world().resource::<ClothDebug>().legend();
        assert!(!legend.is_empty() && legend.iter().all(|line| panel.shows(&line.label)), "{name}");
        panel.click(&format!("draw {name}"));
    }
    assert_eq!(*panel.app().world().resource::<ClothDebug>(), ClothDebug::none());
}

#[test]
fn the_line_of_a_clean_cloth_tells_of_crossings_elsewhere() {
    let mut app = app_with_panel();
    app.insert_resource(ClothGravity(Vec3::ZERO));
    let cloth = spawn(&mut app, sheet(8), Transform::from_xyz(0.0, 2.0, 0.0));
    let far = Transform::from_xyz(9.0, 2.0, 0.0);
    let one = spawn(&mut app, sheet(8), (far, ClothUntangling { iterations: 0, ..default() }));
    let other = spawn(
        &mut app,
        sheet(8),
        (far.with_rotation(Quat::from_rotation_x(1.3)), ClothUntangling { iterations: 0, ..default() }),
    );
    run(&mut app, 3);
    assert!(report(&app, one).crossings > 0, "they do not cross");
    // Each of them counts what crosses; in all it is counted once.
    let crossings = report(&app, other).crossings;
    let panel = Panel::over(app, cloth, one);
    assert!(panel.shows(&format!("0 crossings ({crossings} in all)")));
}

#[test]
fn the_fabric_that_is_tuned_is_draped_on_a_disk_and_again_when_it_changes() {
    let mut panel = Panel::new();
    let measured = |panel: &mut Panel| -> String {
        for _ in 0..800 {
            panel.steps(1);
            if let Some(label) = panel.text("drape coefficient ") {
                return label;
            }
        }
        String::new()
    };
    panel.click("preset denim");
    panel.click("drape on a disk");
    assert!(panel.shows("drape coefficient: it still moves"));
    let denim = measured(&mut panel);
    assert!(denim.ends_with("; denim shows 82 ± 6"), "{denim}");
    panel.click("preset silk");
    assert!(panel.shows("drape coefficient: it still moves"), "the specimen is still of denim");
    let silk = measured(&mut panel);
    let number = |text: &str| text.split_whitespace().nth(2).and_then(|n| n.parse::<f32>().ok()).expect("a number");
    assert!((number(&denim) - 82.0).abs() < 6.0 && (number(&silk) - 35.0).abs() < 8.0, "{denim}, {silk}");
    panel.click("put the disk away");
    assert!(!panel.shows("drape coefficient"));
}
