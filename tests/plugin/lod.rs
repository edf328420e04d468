//! Level of detail: fewer substeps far from the cameras and unseen, and cloth far away that is carried along.

use bevy::camera::visibility::{SetViewVisibility, VisibilityPlugin, VisibilitySystems};
use bevy::mesh::MeshPlugin;
use bevy::prelude::*;
use bevy_drape::ClothParticles;
use bevy_drape::prelude::*;

use crate::common::*;

/// With levels at 10, 20 and 100 m.
const LOD: ClothLod = ClothLod { full_within: 10.0, still_beyond: 100.0, unseen: ClothDetail::Quarter };

fn camera(app: &mut App, at: Vec3) -> Entity {
    app.world_mut().spawn((Camera3d::default(), Transform::from_translation(at))).id()
}

/// A sheet that hangs at the origin, and a camera `distance` [m] from its box.
fn watched(distance: f32, lod: impl Bundle) -> (App, Entity, Entity) {
    let mut app = app();
    let camera = camera(&mut app, Vec3::new(0.5 + distance, 0.0, 0.0));
    let cloth = spawn(&mut app, sheet(8), (border(), lod, ClothSleepDisabled));
    run(&mut app, 5);
    (app, cloth, camera)
}

fn place(app: &mut App, entity: Entity, at: Transform) {
    *app.world_mut().get_mut::<Transform>(entity).expect("a transform") = at;
}

fn bits(app: &App, cloth: Entity) -> Vec<Vec4> {
    app.world().get::<ClothParticles>(cloth).expect("a cloth").state().positions.clone()
}

#[test]
fn substeps_follow_the_distance_from_the_nearest_active_camera() {
    use ClothDetail::{Full, Half, Quarter, Still};
    for (distance, detail, substeps) in [(9.0, Full, 6), (11.0, Half, 3), (25.0, Quarter, 2), (200.0, Still, 0)] {
        let (mut app, cloth, far) = watched(distance, LOD);
        assert_eq!((report(&app, cloth).detail, report(&app, cloth).substeps), (detail, substeps), "at {distance} m");
        let near = camera(&mut app, Vec3::new(0.0, 0.0, 2.0));
        run(&mut app, 1);
        assert_eq!((report(&app, cloth).detail, report(&app, cloth).substeps), (Full, 6), "with a camera near");
        app.world_mut().get_mut::<Camera>(near).expect("a camera").is_active = false;
        run(&mut app, 1);
        assert_eq!(report(&app, cloth).detail, detail, "it is off");
        app.world_mut().despawn(far);
        run(&mut app, 1);
        assert_eq!(report(&app, cloth).detail, Full, "without a camera");
    }
}

#[test]
fn without_it_and_near_it_changes_no_bit() {
    let run_with = |lod: Option<ClothLod>, distance: f32| {
        let (mut app, cloth, _) = watched(distance, ());
        assert!(app.world().get::<ClothLod>(cloth).is_none(), "a cloth has one by default");
        if let Some(lod) = lod {
            app.world_mut().entity_mut(cloth).insert(lod);
        }
        run(&mut app, 60);
        bits(&app, cloth)
    };
    let without = run_with(None, 1.0);
    assert!(run_with(None, 500.0) == without, "without");
    assert!(run_with(Some(LOD), 1.0) == without, "near");
    assert!(run_with(Some(LOD), 12.0) != without, "it made no difference far away");
}

#[test]
fn a_level_of_detail_is_put_on_and_taken_off_while_it_runs() {
    let (mut app, cloth, _) = watched(200.0, ());
    for _ in 0..3 {
        run(&mut app, 1);
        assert_eq!((report(&app, cloth).detail, report(&app, cloth).substeps), (ClothDetail::Full, 6), "without");
        app.world_mut().entity_mut(cloth).insert(LOD);
        run(&mut app, 1);
        assert_eq!(report(&app, cloth).detail, ClothDetail::Still, "with");
        app.world_mut().entity_mut(cloth).insert(ClothLod { still_beyond: 1.0e6, ..LOD });
        run(&mut app, 1);
        assert_eq!((report(&app, cloth).detail, report(&app, cloth).substeps), (ClothDetail::Quarter, 2), "nearer");
        app.world_mut().entity_mut(cloth).remove::<ClothLod>();
    }
    run(&mut app, 1);
    assert!(report(&app, cloth).detail == ClothDetail::Full && finite(&app, cloth));
}

#[test]
fn what_nobody_sees_for_half_a_second_gets_less_until_it_is_seen() {
    for unseen in [ClothDetail::Quarter, ClothDetail::Still, ClothDetail::Full] {
        let (mut app, cloth, _) = watched(1.0, ClothLod { unseen, ..LOD });
        app.world_mut().entity_mut(cloth).insert(ViewVisibility::HIDDEN);
        run(&mut app, 28);
        assert_eq!(report(&app, cloth).detail, ClothDetail::Full, "for a moment");
        run(&mut app, 5);
        assert_eq!(report(&app, cloth).detail, unseen);
        app.world_mut().entity_mut(cloth).remove::<ViewVisibility>();
        run(&mut app, 1);
        assert_eq!(report(&app, cloth).detail, ClothDetail::Full, "seen again");
    }
}

#[test]
fn what_a_camera_sees_is_read_before_it_is_forgotten() {
    for sees in [true, false] {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default(), MeshPlugin, VisibilityPlugin));
        app.add_plugins(ClothPlugin::default());
        app.insert_resource(bevy::time::TimeUpdateStrategy::ManualDuration(core::time::Duration::from_secs_f32(FRAME)));
        let see = move |mut cloths: Query<&mut ViewVisibility, With<Cloth>>| {
            if sees {
                cloths.iter_mut().for_each(|mut cloth| cloth.set_visible());
            }
        };
        app.add_systems(PostUpdate, see.in_set(VisibilitySystems::CheckVisibility));
        app.finish();
        app.cleanup();
        camera(&mut app, Vec3::ZERO);
        let cloth = spawn(&mut app, sheet(8), (border(), LOD));
        run(&mut app, 60);
        let detail = report(&app, cloth).detail;
        assert_eq!(detail, if sees { ClothDetail::Full } else { ClothDetail::Quarter }, "sees it: {sees}");
    }
}

#[test]
fn far_away_it_is_carried_along_with_what_it_hangs_on_and_goes_on_when_it_comes_near() {
    let (mut app, cloth, camera) = watched(1.0, LOD);
    record::<ClothTeleported>(&mut app);
    run(&mut app, 20);
    place(&mut app, camera, Transform::from_xyz(500.0, 0.0, 0.0));
    run(&mut app, 2);
    let (time, before) = (report(&app, cloth).time, particles(&app, cloth));
    let mut at = Transform::IDENTITY;
    // A walk of 10 m in a curve, over which a cloth that is dragged would trail behind.
    for frame in 0..200 {
        at = Transform::from_xyz(0.05 * frame as f32, 0.01 * frame as f32, 0.0)
            .with_rotation(Quat::from_rotation_y(0.01 * frame as f32));
        place(&mut app, cloth, at);
        run(&mut app, 1);
    }
    let worst =
        particles(&app, cloth).iter().zip(&before).map(|(now, &was)| now.distance(at.transform_point(was))).fold(0.0, f32::max);
    assert!(worst < 1.0e-4, "{worst} m off");
    let shown = world_positions(&app, cloth).iter().all(|p| particles(&app, cloth).iter().any(|x| x.distance(*p) < 1.0e-3));
    assert!(shown, "the mesh is elsewhere");
    assert_eq!((report(&app, cloth).time, report(&app, cloth).detail), (time, ClothDetail::Still));
    assert!(seen::<ClothTeleported>(&app).is_empty());

    let stood = particles(&app, cloth);
    place(&mut app, camera, at);
    run(&mut app, 1);
    let step = particles(&app, cloth).iter().zip(&stood).map(|(now, was)| now.distance(*was)).fold(0.0, f32::max);
    assert!(report(&app, cloth).time > time && step < 0.1, "it jumped by {step} m");
    run(&mut app, 60);
    let edge = report(&app, cloth).worst_edge;
    assert!(edge < 1.1 && finite(&app, cloth), "{edge}");
}

#[test]
fn a_cloth_that_is_paused_is_not_carried_along() {
    let (mut app, cloth, _) = watched(500.0, LOD);
    app.world_mut().get_mut::<ClothSolver>(cloth).expect("a cloth").time_scale = 0.0;
    let before = particles(&app, cloth);
    place(&mut app, cloth, Transform::from_xyz(0.0, 0.5, 0.0));
    run(&mut app, 5);
    assert!(particles(&app, cloth) == before);
}

#[test]
fn a_cloth_that_stands_still_is_an_obstacle_and_lets_others_sleep() {
    let mut app = app();
    camera(&mut app, Vec3::new(500.0, 0.0, 0.0));
    let material = ClothMaterial { thickness: 0.01, ..default() };
    let below = spawn(&mut app, sheet(12), (LOD, material.clone()));
    let above = spawn(&mut app, sheet(9), (material, Transform::from_xyz(0.02, 0.1, 0.01).with_scale(Vec3::splat(0.6))));
    let mut slept = None;
    for frame in 0..900 {
        run(&mut app, 1);
        let low = lowest(&particles(&app, above));
        assert!(low > 0.005, "frame {frame}: it fell through, to {low} m");
        assert_eq!(report(&app, below).detail, ClothDetail::Still);
        if report(&app, above).asleep {
            slept = Some(frame);
            break;
        }
    }
    assert!(slept.is_some(), "awake after 15 s: {:?}", report(&app, above));
    // Nothing is looked for any more.
    run(&mut app, 2);
    let report_of = |cloth| report(&app, cloth).detect_ms;
    assert_eq!((report_of(above), report_of(below)), (0.0, 0.0));
}

#[test]
fn cloth_that_two_way_bodies_hang_on_or_are_near_is_simulated_in_full() {
    let mut app = app();
    camera(&mut app, Vec3::new(500.0, 0.0, 0.0));
    let mast = app.world_mut().spawn((Transform::default(), ClothCoupling::TwoWay)).id();
    let flag = spawn(&mut app, sheet(8), (border().to(mast), LOD));
    let net = spawn(&mut app, sheet(8), (border(), LOD, Transform::from_xyz(0.0, 0.0, 10.0)));
    let place = Transform::from_xyz(0.0, 5.0, 10.0);
    let ball = app.world_mut().spawn((ClothCollider::ball(0.2), ClothCoupling::TwoWay, place)).id();
    run(&mut app, 30);
    let pull = app.world().get::<ClothReaction>(mast).expect("a mast").linear.y;
    assert!(report(&app, flag).detail == ClothDetail::Full && pull < 0.0, "{:?}, {pull} N s", report(&app, flag));
    assert_eq!(report(&app, net).detail, ClothDetail::Still);
    self::place(&mut app, ball, Transform::from_xyz(0.0, 0.1, 10.0));
    run(&mut app, 2);
    assert_eq!(report(&app, net).detail, ClothDetail::Full, "with the ball at it");
}

#[test]
fn cloth_that_lies_on_one_that_is_carried_away_wakes_and_falls() {
    let mut app = app();
    camera(&mut app, Vec3::new(500.0, 0.0, 0.0));
    let rim = ClothPins::where_position(|p| p.x.abs().max(p.z.abs()) > 0.499);
    let table = spawn(&mut app, sheet(12), (rim, LOD));
    let napkin = spawn(&mut app, sheet(7), Transform::from_xyz(0.0, 0.03, 0.0).with_scale(Vec3::splat(0.4)));
    for _ in 0..900 {
        run(&mut app, 1);
        if report(&app, napkin).asleep {
            break;
        }
    }
    assert!(report(&app, napkin).asleep, "{:?}", report(&app, napkin));
    for frame in 1..=60 {
        place(&mut app, table, Transform::from_xyz(0.05 * frame as f32, 0.0, 0.0));
        run(&mut app, 1);
    }
    run(&mut app, 30);
    let low = lowest(&particles(&app, napkin));
    assert!(!report(&app, napkin).asleep && low < -0.2, "it hangs in the air at {low} m");
}

#[test]
fn what_is_pinned_nowhere_stays_where_it_is_far_away() {
    let mut app = app();
    camera(&mut app, Vec3::new(500.0, 0.0, 0.0));
    let cloth = spawn(&mut app, sheet(6), LOD);
    run(&mut app, 3);
    let before = particles(&app, cloth);
    place(&mut app, cloth, Transform::from_xyz(3.0, 0.0, 0.0));
    run(&mut app, 3);
    assert!(particles(&app, cloth) == before);
}

#[test]
fn pins_that_went_elsewhere_meanwhile_draw_the_cloth_there_in_one_piece() {
    let (mut app, cloth, camera) = watched(1.0, LOD);
    let [left, right] = [-0.5, 0.5].map(|x| app.world_mut().spawn(Transform::from_xyz(x, 0.0, -0.5)).id());
    let pins = ClothPins::where_position(|p| p.z < -0.499 && p.x < -0.499).to(left);
    let pins = pins.and(ClothPins::where_position(|p| p.z < -0.499 && p.x > 0.499).to(right));
    app.world_mut().entity_mut(cloth).insert(pins);
    run(&mut app, 30);
    place(&mut app, camera, Transform::from_xyz(500.0, 0.0, 0.0));
    run(&mut app, 2);
    // The first is its carrier: it goes along with that one only.
    place(&mut app, right, Transform::from_xyz(0.5, 3.0, -0.5));
    run(&mut app, 3);
    // As far from the other as at rest.
    place(&mut app, right, Transform::from_xyz(0.4, 0.4, -0.6));
    place(&mut app, camera, Transform::from_xyz(1.0, 0.0, 0.0));
    run(&mut app, 60);
    let report = report(&app, cloth);
    assert!(report.restores + report.resets == 0 && report.worst_edge < 1.2, "{report:?}");
}

#[test]
fn in_a_fixed_schedule_what_is_carried_is_shown_where_its_carrier_is_shown() {
    let mut app = app_with(ClothPlugin::new(FixedPostUpdate));
    camera(&mut app, Vec3::new(500.0, 0.0, 0.0));
    let cloth = spawn(&mut app, sheet(6), (border(), LOD));
    run(&mut app, 10);
    let local = positions(&app, cloth);
    // As an engine with interpolation moves it: in ticks, and shown in between.
    let go = |time: Res<Time>, mut carrier: Query<&mut Transform, With<Cloth>>| {
        carrier.iter_mut().for_each(|mut at| at.translation.x += 10.0 * time.delta_secs());
    };
    app.add_systems(FixedUpdate, go);
    let mut apart = Vec::new();
    for _ in 0..40 {
        run(&mut app, 1);
        let overstep = app.world().resource::<Time<Fixed>>().overstep_fraction();
        let behind = (1.0 - overstep) * 10.0 * app.world().resource::<Time<Fixed>>().timestep().as_secs_f32();
        let shown = positions(&app, cloth);
        // The transform is that of the last tick; what is shown lies between it and the one before.
        apart.push(shown.iter().zip(&local).map(|(now, was)| (*was - Vec3::X * behind).distance(*now)).fold(0.0, f32::max));
    }
    let worst = apart[5..].iter().copied().fold(0.0, f32::max);
    assert!(worst < 1.0e-3, "{worst} m off");
}

#[test]
fn distances_out_of_range_are_named_and_used_clamped() {
    let (app, cloth, _) = watched(1.0, ClothLod { full_within: -1.0, still_beyond: f32::NAN, ..LOD });
    let clamped = &report(&app, cloth).clamped;
    assert_eq!(clamped.iter().map(AsRef::as_ref).collect::<Vec<&str>>(), ["lod.full_within", "lod.still_beyond"]);
    assert_eq!(report(&app, cloth).detail, ClothDetail::Quarter);
}
