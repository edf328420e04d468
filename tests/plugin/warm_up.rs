//! Warm-up: cloth that is simulated before it is shown, a slice in each frame.

use bevy::prelude::*;
use bevy_drape::ClothParticles;
use bevy_drape::prelude::*;

use crate::common::*;

fn warming(app: &App, cloth: Entity) -> bool {
    app.world().entity(cloth).contains::<ClothWarmUp>()
}

fn visibility(app: &App, entity: Entity) -> Visibility {
    *app.world().get::<Visibility>(entity).expect("it can be seen")
}

fn time(app: &App, cloth: Entity) -> f64 {
    app.world().get::<ClothParticles>(cloth).expect("a cloth").state().time
}

/// A sheet that can be seen.
fn spawn(app: &mut App, mesh: Mesh, extra: impl Bundle) -> Entity {
    let cloth = crate::common::spawn(app, mesh, extra);
    if !app.world().entity(cloth).contains::<Visibility>() {
        app.world_mut().entity_mut(cloth).insert(Visibility::default());
    }
    cloth
}

/// Runs until a cloth is shown, which is hidden in every frame before; how many frames that took.
fn warm_up(app: &mut App, cloth: Entity) -> u32 {
    for frame in 0..1000 {
        app.update();
        assert_eq!(visibility(app, cloth) == Visibility::Hidden, warming(app, cloth), "frame {frame}");
        if !warming(app, cloth) {
            return frame;
        }
    }
    panic!("it is never shown");
}

/// How far the shown vertices go in a frame, at most [m].
fn stride(app: &mut App, cloth: Entity) -> f32 {
    let before = world_positions(app, cloth);
    app.update();
    before.iter().zip(world_positions(app, cloth)).map(|(a, b)| a.distance(b)).fold(0.0, f32::max)
}

#[test]
fn a_curtain_hangs_when_it_is_first_shown_and_took_a_few_frames_for_it() {
    for rate in [30.0, 60.0, 144.0] {
        let mut app = app();
        frame_length(&mut app, 1.0 / rate);
        let cold = spawn(&mut app, sheet(12), (border(), ClothSleepDisabled, Transform::from_xyz(9.0, 0.0, 0.0)));
        let warm = spawn(&mut app, sheet(12), (border(), ClothSleepDisabled, ClothWarmUp { seconds: 3.0 }));
        let frames = warm_up(&mut app, warm);
        // One as long as that of the app, then 0.1 s each.
        assert_eq!(frames, 31, "at {rate} Hz");
        assert!((time(&app, warm) - 3.0 - 1.0 / f64::from(rate)).abs() < 1.0e-3, "{} s", time(&app, warm));
        let strides = [cold, warm].map(|cloth| stride(&mut app, cloth));
        assert!(strides[1] * rate < 0.3 && strides[0] > 2.0 * strides[1], "at {rate} Hz: {strides:?} m in a frame");
        assert_eq!((visibility(&app, cold), report(&app, warm).lost_time < 1.0e-5), (Visibility::Inherited, true));
    }
}

#[test]
fn cloths_that_warm_up_share_a_slice_and_never_wait() {
    let mut app = app();
    let seconds = 0.5;
    let cloths: Vec<Entity> = (0..30)
        .map(|i| spawn(&mut app, sheet(24), (border(), Transform::from_xyz(3.0 * i as f32, 0.0, 0.0), ClothWarmUp { seconds })))
        .collect();
    // What a frame of the app costs is more than the slice: 30 times 576 particles and 6 substeps are 103,680.
    let frames = cloths.iter().map(|cloth| warm_up(&mut app, *cloth)).max().expect("cloths");
    assert!((28..33).contains(&frames), "{frames} frames for half a second at 60 Hz");
    let substeps: u32 = cloths.iter().map(|cloth| report(&app, *cloth).substeps).sum();
    assert_eq!(substeps, 30 * 6);

    // Of one alone no frame is longer than the slice.
    let mut app = crate::common::app();
    let cloth = spawn(&mut app, sheet(48), (border(), ClothWarmUp { seconds }));
    while app.world().get::<ClothParticles>(cloth).is_none() || warming(&app, cloth) {
        app.update();
        let report = report(&app, cloth);
        let moved = 48 * 48 * report.substeps * report.inner_steps;
        assert!(moved <= 45_000 || report.substeps <= 6, "{moved} particles in a frame");
    }
}

#[test]
fn a_skinned_cloth_has_its_limits_and_its_pose_when_it_is_shown() {
    let mut app = app();
    let limits = ClothLimits { max_distance: ClothMap::Uniform(0.3), ..default() };
    let (cloth, _) = crate::skinned::dressed(
        &mut app,
        12,
        (Visibility::default(), limits, ClothWarmUp { seconds: 2.0 }, ClothSleepDisabled),
    );
    let frames = warm_up(&mut app, cloth);
    assert!(frames < 40, "{frames} frames for two seconds");
    let low = lowest(&world_positions(&app, cloth));
    assert!((-0.301..-0.29).contains(&low), "it has fallen as far as it may: {low}");
    assert!(stride(&mut app, cloth) < 1.0e-3);
}

#[test]
fn what_the_app_says_of_visibility_stays() {
    let mut app = app();
    let with =
        |app: &mut App, visibility: Visibility| spawn(app, sheet(6), (border(), visibility, ClothWarmUp { seconds: 0.2 }));
    let [visible, hidden, shown, failed, disabled] =
        [Visibility::Visible, Visibility::Hidden, Visibility::Visible, Visibility::Visible, Visibility::Visible]
            .map(|visibility| with(&mut app, visibility));
    app.world_mut().entity_mut(disabled).insert(ClothDisabled);
    let lines = Mesh::new(bevy::mesh::PrimitiveTopology::LineList, default());
    let lines = add(&mut app, lines);
    app.world_mut().entity_mut(failed).insert(Mesh3d(lines));
    app.update();
    assert_eq!(
        [visible, hidden, shown, failed, disabled].map(|cloth| visibility(&app, cloth)),
        [Visibility::Hidden, Visibility::Hidden, Visibility::Hidden, Visibility::Visible, Visibility::Visible]
    );
    *app.world_mut().get_mut::<Visibility>(shown).expect("visibility") = Visibility::Inherited;
    app.update();
    assert_eq!(visibility(&app, shown), Visibility::Inherited, "the app shows it all the same");
    run(&mut app, 20);
    assert_eq!(
        [visible, hidden, shown].map(|cloth| visibility(&app, cloth)),
        [Visibility::Visible, Visibility::Hidden, Visibility::Inherited]
    );
    assert!(warming(&app, disabled), "it waits");
    app.world_mut().entity_mut(disabled).remove::<ClothDisabled>();
    app.update();
    assert_eq!(visibility(&app, disabled), Visibility::Hidden);
    // Taken off, it is over, and put on again it begins again.
    app.world_mut().entity_mut(disabled).remove::<ClothWarmUp>();
    run(&mut app, 2);
    assert_eq!((visibility(&app, disabled), report(&app, disabled).substeps), (Visibility::Visible, 6));
    app.world_mut().entity_mut(disabled).insert(ClothWarmUp { seconds: 0.2 });
    assert!(warm_up(&mut app, disabled) > 1);
}

#[test]
fn what_shows_a_cloth_is_hidden_with_it() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(6), (border(), ClothWarmUp::default()));
    let fine = add(&mut app, sheet(11));
    let piece = add(&mut app, sheet(6));
    let drawn = [
        app.world_mut().spawn((Mesh3d(fine), Visibility::default(), ClothRenderMesh { cloth })).id(),
        app.world_mut().spawn((Mesh3d(piece), Visibility::default(), ClothPiece { cloth, first: 0 })).id(),
    ];
    app.update();
    assert_eq!(drawn.map(|entity| visibility(&app, entity)), [Visibility::Hidden; 2]);
    warm_up(&mut app, cloth);
    app.update();
    assert_eq!(drawn.map(|entity| visibility(&app, entity)), [Visibility::Inherited; 2]);
    app.world_mut().entity_mut(cloth).insert(ClothWarmUp::default());
    app.update();
    app.world_mut().despawn(cloth);
    app.update();
    assert_eq!(drawn.map(|entity| visibility(&app, entity)), [Visibility::Inherited; 2], "the cloth is gone");
}

#[test]
fn nothing_warms_up_while_time_stands_still_and_far_away_it_does() {
    let mut app = app();
    app.world_mut().resource_mut::<Time<Virtual>>().pause();
    app.world_mut().spawn((Camera3d::default(), Transform::from_xyz(500.0, 0.0, 0.0)));
    let cloth = spawn(&mut app, sheet(8), (border(), ClothLod::default(), ClothWarmUp::default()));
    run(&mut app, 100);
    assert!(warming(&app, cloth) && visibility(&app, cloth) == Visibility::Hidden);
    app.world_mut().resource_mut::<Time<Virtual>>().unpause();
    app.update();
    warm_up(&mut app, cloth);
    assert!(lowest(&world_positions(&app, cloth)) < -0.5, "it was simulated before it stood still");
    app.update();
    assert_eq!(report(&app, cloth).detail, ClothDetail::Still);
}

#[test]
fn a_time_that_is_none_is_told_and_ends() {
    for (seconds, used) in [(f32::NAN, 1.0), (-1.0, 0.0), (1.0e9, 60.0)] {
        let mut app = app();
        let cloth = spawn(&mut app, sheet(6), (border(), ClothSleepDisabled, ClothWarmUp { seconds }));
        app.update();
        assert!(seconds < 0.0 || report(&app, cloth).clamped == ["warm_up.seconds"], "{:?}", report(&app, cloth).clamped);
        warm_up(&mut app, cloth);
        assert!((time(&app, cloth) - used).abs() < 0.15, "{} s", time(&app, cloth));
    }
}

#[test]
fn what_comes_to_rest_is_shown_then() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(8), (border(), ClothMaterial::LEATHER, ClothWarmUp { seconds: 60.0 }));
    let frames = warm_up(&mut app, cloth);
    assert!(report(&app, cloth).asleep && time(&app, cloth) < 50.0, "{frames} frames, {} s", time(&app, cloth));
    app.world_mut().entity_mut(cloth).insert(ClothWarmUp { seconds: 60.0 });
    assert!(warm_up(&mut app, cloth) < 3, "it slept");
}

#[test]
fn beside_cloth_that_is_shown_and_bodies_that_it_moves_it_keeps_the_time_of_the_clock() {
    let seconds = 0.5;
    let frames = |beside: &dyn Fn(&mut App)| {
        let mut app = app();
        beside(&mut app);
        run(&mut app, 5);
        let cloth = spawn(&mut app, sheet(8), (border(), ClothWarmUp { seconds }));
        warm_up(&mut app, cloth)
    };
    let body = |at: Vec3| {
        move |app: &mut App| {
            let two_way = (ClothCollider::from(Sphere::new(0.1)), ClothCoupling::TwoWay, ClothRigidBody::default());
            app.world_mut().spawn((two_way, Transform::from_translation(at)));
        }
    };
    let neighbour = |at: Vec3| {
        move |app: &mut App| {
            spawn(app, sheet(8), (border(), ClothSleepDisabled, Transform::from_translation(at)));
        }
    };
    let far = Vec3::X * 50.0;
    let [alone, near_body, far_body] = [frames(&|_| ()), frames(&body(Vec3::new(0.0, -0.12, -0.4))), frames(&body(far))];
    let [near_cloth, far_cloth] = [frames(&neighbour(Vec3::Y * 0.02)), frames(&neighbour(far))];
    assert!(alone < 10 && [far_body, far_cloth] == [alone; 2], "{alone}, {far_body}, {far_cloth}");
    assert!((25..35).contains(&near_body) && (25..35).contains(&near_cloth), "{near_body}, {near_cloth}");
}

#[test]
fn a_reset_begins_it_anew_and_a_snapshot_goes_on_with_it() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(12), (border(), ClothWarmUp { seconds: 1.0 }));
    run(&mut app, 8);
    let snapshot = ClothSnapshot::capture(app.world_mut());
    let rest = warm_up(&mut app, cloth);
    let shape = particles(&app, cloth);
    snapshot.restore(app.world_mut()).expect("the same cloth");
    app.world_mut().entity_mut(cloth).insert(ClothWarmUp { seconds: 1.0 });
    assert_eq!((warm_up(&mut app, cloth), particles(&app, cloth) == shape), (rest, true));

    app.world_mut().entity_mut(cloth).insert(ClothWarmUp { seconds: 1.0 });
    run(&mut app, 8);
    app.world_mut().entity_mut(cloth).insert(ClothReset);
    let frames = warm_up(&mut app, cloth);
    assert!(frames > rest + 3, "{frames} frames, {rest} without a reset");
}

#[test]
fn in_a_fixed_schedule_it_warms_up_a_tick_at_a_time() {
    let mut app = app_with(ClothPlugin::new(FixedPostUpdate));
    // Three ticks of 64 Hz in a frame, or two.
    frame_length(&mut app, 0.04);
    let cloth = spawn(&mut app, sheet(12), (border(), ClothSleepDisabled, ClothWarmUp { seconds: 3.0 }));
    let frames = warm_up(&mut app, cloth);
    assert!((10..16).contains(&frames), "{frames} frames, for 31 ticks");
    assert!(lowest(&world_positions(&app, cloth)) < -0.9);
}

#[test]
fn a_budget_does_not_take_a_warm_up_for_what_a_cloth_costs() {
    let mut app = app();
    app.world_mut().spawn((Camera3d::default(), Transform::from_xyz(0.0, 0.0, 3.0)));
    let cloth = spawn(&mut app, sheet(12), (border(), ClothSleepDisabled));
    run(&mut app, 120);
    app.insert_resource(ClothBudget { ms: 1000.0 });
    app.world_mut().entity_mut(cloth).insert(ClothWarmUp { seconds: 3.0 });
    warm_up(&mut app, cloth);
    assert_eq!((report(&app, cloth).by_budget, report(&app, cloth).detail), (ClothDetail::Full, ClothDetail::Full));
}
