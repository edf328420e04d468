//! Colliders and wind as components.

use bevy::ecs::entity_disabling::Disabled;
use bevy::prelude::*;
use bevy_drape::ClothReport;
use bevy_drape::prelude::*;

use crate::common::*;

fn bodies(app: &App, cloth: Entity) -> u32 {
    app.world().get::<ClothReport>(cloth).expect("a cloth").bodies
}

#[test]
fn a_sheet_that_falls_on_a_ball_stays_outside() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(24), Transform::from_xyz(0.0, 0.5, 0.0));
    app.world_mut().spawn(ClothCollider::ball(0.3));
    app.world_mut().spawn((Transform::from_xyz(0.0, -0.6, 0.0), ClothCollider::ground()));
    run(&mut app, 180);
    for p in particles(&app, cloth) {
        assert!(p.length() > 0.295, "a particle is {} m from the centre", p.length());
        assert!(p.y > -0.605, "a particle is at {}", p.y);
    }
}

#[test]
fn a_fast_collider_carries_the_cloth_along() {
    let mut app = app();
    app.insert_resource(ClothGravity(Vec3::ZERO));
    // Without untangling, which moves the folds behind the ball and asks no body.
    let alone = ClothCollision { self_collision: false, ..default() };
    let cloth = spawn(&mut app, sheet(16), alone);
    let ball = app.world_mut().spawn((Transform::from_xyz(0.0, -1.0, 0.0), ClothCollider::ball(0.3))).id();
    run(&mut app, 3);
    for i in 0..24 {
        app.world_mut().get_mut::<Transform>(ball).expect("a transform").translation.y = -1.0 + 10.0 * FRAME * i as f32;
        run(&mut app, 1);
    }
    let ball = -1.0 + 10.0 * FRAME * 23.0;
    for p in particles(&app, cloth) {
        assert!(p.distance(Vec3::new(0.0, ball, 0.0)) > 0.29, "a particle is inside at {p}");
    }
    // The border folds behind the ball; the middle stays before it.
    let rest = vectors(&sheet(16), Mesh::ATTRIBUTE_POSITION);
    for (_, now) in rest.iter().zip(world_positions(&app, cloth)).filter(|(p, _)| p.length() < 0.2) {
        assert!(now.y > ball, "the ball at {ball} m went through: {now}");
    }
}

#[test]
fn disabled_colliders_and_other_layers_are_ignored() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(5), (border(), ClothCollisionLayers::new(0b01, 0b01)));
    app.world_mut().spawn(ClothCollider::ball(0.1));
    let off = app.world_mut().spawn((ClothCollider::ball(0.1), ClothColliderDisabled)).id();
    let disabled = app.world_mut().spawn((ClothCollider::ball(0.1), Disabled)).id();
    app.world_mut().spawn((ClothCollider::ball(0.1), ClothCollisionLayers::new(0b10, u32::MAX)));
    app.world_mut().spawn((ClothCollider::ball(0.1), ClothCollisionLayers::new(0b01, 0b10)));
    run(&mut app, 3);
    assert_eq!(bodies(&app, cloth), 1);
    app.world_mut().entity_mut(disabled).remove::<Disabled>();
    app.world_mut().entity_mut(off).remove::<ClothColliderDisabled>();
    run(&mut app, 3);
    assert_eq!(bodies(&app, cloth), 3);
    app.world_mut().entity_mut(off).insert(ClothColliderDisabled);
    run(&mut app, 1);
    assert_eq!(bodies(&app, cloth), 2, "off again");
}

#[test]
fn a_collider_that_is_off_sweeps_nothing_on_its_way() {
    let is_hit = |off: bool| {
        let mut app = app();
        app.insert_resource(ClothGravity(Vec3::ZERO));
        let cloth = spawn(&mut app, sheet(12), border());
        let place = |y: f32| Transform::from_xyz(0.0, y, 0.0);
        let body = app.world_mut().spawn((place(-0.4), ClothCollider::ball(0.2))).id();
        run(&mut app, 3);
        let before = particles(&app, cloth);
        if off {
            app.world_mut().entity_mut(body).insert(ClothColliderDisabled);
        }
        run(&mut app, 1);
        // Through the cloth in a frame, by less than what counts as a jump.
        *app.world_mut().get_mut::<Transform>(body).expect("a transform") = place(0.5);
        app.world_mut().entity_mut(body).remove::<ClothColliderDisabled>();
        run(&mut app, 3);
        assert_eq!(bodies(&app, cloth), 1);
        let moved = particles(&app, cloth).iter().zip(&before).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        // It may have been hit so hard that it was taken back.
        moved > 1.0e-3 || report(&app, cloth).restores > 0
    };
    assert!(!is_hit(true), "off");
    assert!(is_hit(false), "on");
}

#[test]
fn a_collider_despawned_at_any_time_is_forgotten() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(10), Transform::from_xyz(0.0, 0.4, 0.0));
    let ball = app.world_mut().spawn(ClothCollider::ball(0.3)).id();
    run(&mut app, 60);
    assert_eq!(bodies(&app, cloth), 1);
    app.world_mut().despawn(ball);
    run(&mut app, 60);
    assert_eq!(bodies(&app, cloth), 0);
    assert!(finite(&app, cloth) && lowest(&particles(&app, cloth)) < -1.0, "it falls on");
}

#[test]
fn every_shape_becomes_a_body_and_a_bad_one_is_left_out() {
    use bevy_drape::ClothColliderShape::{Ball, Cuboid};
    let points = || [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    let good = [
        ClothCollider::ball(0.5),
        ClothCollider::capsule(0.2, 1.0),
        ClothCollider::cuboid(1.0, 2.0, 3.0),
        ClothCollider::cylinder(0.5, 1.0),
        ClothCollider::cone(0.5, 1.0),
        ClothCollider::ground(),
        ClothCollider::convex_hull(points()),
        ClothCollider::tri_mesh(points().to_vec(), vec![[0, 1, 2], [0, 2, 3]]),
        ClothCollider::height_field(2, 2, vec![0.0, 0.1, 0.2, 0.3], Vec3::ONE),
        ClothCollider::compound([
            (Vec3::ZERO, Quat::IDENTITY, Ball { radius: 0.5 }),
            (Vec3::X, Quat::IDENTITY, Cuboid { size: Vec3::ONE }),
        ]),
    ];
    let bad = [
        ClothCollider::ball(-1.0),
        ClothCollider::ball(f32::NAN),
        ClothCollider::half_space(Vec3::ZERO),
        ClothCollider::convex_hull([Vec3::ZERO]),
        ClothCollider::tri_mesh(points().to_vec(), vec![[7, 8, 9]]),
        ClothCollider::height_field(2, 2, vec![0.0], Vec3::ONE),
        ClothCollider::compound([]),
        ClothCollider::fit_mesh(ClothMeshFit::TriMesh),
    ];
    let mut app = app();
    let cloth = spawn(&mut app, sheet(5), border());
    let count = good.len() as u32;
    for collider in good.into_iter().chain(bad) {
        app.world_mut().spawn((Transform::from_xyz(0.0, -50.0, 0.0), collider));
    }
    run(&mut app, 5);
    assert_eq!(bodies(&app, cloth), count);
    assert!(finite(&app, cloth));
}

#[test]
fn a_collider_fitted_to_its_mesh_waits_for_it_and_scales_with_its_entity() {
    for fit in
        [ClothMeshFit::Ball, ClothMeshFit::Capsule, ClothMeshFit::Cuboid, ClothMeshFit::ConvexHull, ClothMeshFit::TriMesh]
    {
        let mut app = app();
        let cloth = spawn(&mut app, sheet(16), Transform::from_xyz(0.0, 1.5, 0.0));
        let handle = app.world().resource::<Assets<Mesh>>().reserve_handle();
        let transform = Transform::from_scale(Vec3::splat(2.0));
        app.world_mut().spawn((Mesh3d(handle.clone()), transform, ClothCollider::fit_mesh(fit)));
        run(&mut app, 3);
        assert_eq!(bodies(&app, cloth), 0, "{fit:?}");
        let sphere = Sphere::new(0.25).mesh().ico(4).expect("a sphere");
        app.world_mut().resource_mut::<Assets<Mesh>>().insert(handle.id(), sphere).expect("a live handle");
        run(&mut app, 60);
        assert_eq!(bodies(&app, cloth), 1, "{fit:?}");
        run(&mut app, 60);
        let over = particles(&app, cloth).into_iter().filter(|p| Vec2::new(p.x, p.z).length() < 0.1);
        let lowest = over.map(|p| p.y).fold(f32::INFINITY, f32::min);
        assert!((0.47..0.6).contains(&lowest), "{fit:?}: it lies at {lowest} m on a ball of 0.5 m");
    }
}

#[test]
fn wind_blows_everywhere_in_zones_and_per_cloth() {
    let blown = |setup: &dyn Fn(&mut App, Entity)| {
        let mut app = app();
        app.insert_resource(ClothGravity(Vec3::ZERO));
        let cloth = spawn(&mut app, sheet(8), border());
        setup(&mut app, cloth);
        run(&mut app, 60);
        assert!(finite(&app, cloth));
        particles(&app, cloth).iter().map(|p| p.y).sum::<f32>() / 64.0
    };
    let up = Vec3::new(0.0, 5.0, 0.0);
    let still = blown(&|_, _| {});
    let global = blown(&|app, _| app.insert_resource(ClothGlobalWind::new(up)).into_unit());
    let own = blown(&|app, cloth| {
        app.insert_resource(ClothGlobalWind::new(up));
        app.world_mut().entity_mut(cloth).insert(ClothWind::still());
    });
    let zone = blown(&|app, _| app.world_mut().spawn(ClothWindZone::sphere(2.0, up)).into_unit());
    let turned = blown(&|app, _| {
        let turn = Transform::from_rotation(Quat::from_rotation_z(core::f32::consts::PI));
        app.world_mut().spawn((ClothWindZone::cuboid(Vec3::splat(4.0), up), turn));
    });
    let elsewhere = blown(&|app, _| {
        app.world_mut().spawn((ClothWindZone::sphere(2.0, up), Transform::from_xyz(50.0, 0.0, 0.0)));
    });
    assert!(still.abs() < 1.0e-4 && own.abs() < 1.0e-4 && elsewhere.abs() < 1.0e-4, "{still} {own} {elsewhere}");
    assert!(global > 0.1 && zone > 0.1 && turned < -0.1, "{global} {zone} {turned}");
}

trait IntoUnit: Sized {
    fn into_unit(self) {}
}
impl<T> IntoUnit for T {}

#[test]
fn a_collider_whose_scale_is_not_a_number_comes_back_with_a_scale() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(5), border());
    let never = app.world_mut().spawn((Transform::from_scale(Vec3::splat(f32::NAN)), ClothCollider::ball(0.1))).id();
    let broken = app.world_mut().spawn(ClothCollider::ball(0.1)).id();
    run(&mut app, 3);
    assert_eq!(bodies(&app, cloth), 1);
    for scale in [Vec3::new(1.0, f32::NAN, 1.0), Vec3::INFINITY, Vec3::splat(2.0)] {
        for body in [never, broken] {
            app.world_mut().get_mut::<Transform>(body).expect("a transform").scale = scale;
        }
        run(&mut app, 3);
        assert_eq!(bodies(&app, cloth), if scale.is_finite() { 2 } else { 1 }, "{scale}");
        assert!(finite(&app, cloth));
    }
}

#[test]
fn a_part_of_a_compound_that_is_fitted_waits_for_the_mesh_and_a_fit_that_failed_is_tried_again_when_it_changes() {
    use bevy_drape::ClothColliderShape;
    let mut app = app();
    let cloth = spawn(&mut app, sheet(5), border());
    let late = app.world().resource::<Assets<Mesh>>().reserve_handle();
    let part = (Vec3::X, Quat::IDENTITY, ClothColliderShape::Mesh(ClothMeshFit::ConvexHull));
    app.world_mut().spawn((Mesh3d(late.clone()), ClothCollider::compound([part])));
    let wrong = add(&mut app, Mesh::new(bevy::mesh::PrimitiveTopology::LineList, default()));
    app.world_mut().spawn((Mesh3d(wrong.clone()), ClothCollider::fit_mesh(ClothMeshFit::TriMesh)));
    run(&mut app, 5);
    assert_eq!(bodies(&app, cloth), 0);
    let sphere = || Sphere::new(0.25).mesh().ico(2).expect("a sphere");
    app.world_mut().resource_mut::<Assets<Mesh>>().insert(late.id(), sphere()).expect("a live handle");
    run(&mut app, 3);
    assert_eq!(bodies(&app, cloth), 1);
    *app.world_mut().resource_mut::<Assets<Mesh>>().get_mut(&wrong).expect("the mesh") = sphere();
    run(&mut app, 3);
    assert_eq!(bodies(&app, cloth), 2);
}

#[test]
fn a_zone_blows_from_the_frame_in_which_the_cloth_comes_to_it() {
    let teleported = |zone: bool| {
        let mut app = app();
        app.insert_resource(ClothGravity(Vec3::ZERO));
        let cloth = spawn(&mut app, sheet(8), ());
        if zone {
            app.world_mut().spawn((ClothWindZone::sphere(3.0, Vec3::Y * 20.0), Transform::from_xyz(50.0, 0.0, 0.0)));
        }
        run(&mut app, 5);
        app.world_mut().get_mut::<Transform>(cloth).expect("a transform").translation.x = 50.0;
        run(&mut app, 1);
        particles(&app, cloth).iter().map(|p| p.y).sum::<f32>() / 64.0
    };
    let (without, with) = (teleported(false), teleported(true));
    assert!(with > without + 1.0e-4, "{with} m with a zone, {without} m without");

    let thrown = |zone: f32| {
        let mut app = app();
        app.insert_resource(ClothGravity(Vec3::ZERO));
        let cloth = spawn(&mut app, sheet(8), ClothMaterial { drag: 0.5, ..default() });
        app.world_mut().spawn((ClothWindZone::cuboid(Vec3::splat(4.0), Vec3::Y * 20.0), Transform::from_xyz(zone, 0.0, 0.0)));
        run(&mut app, 1);
        let mut at = app.world_mut().get_mut::<ClothParticles>(cloth).expect("a cloth");
        at.apply_impulse(Vec3::ZERO, Vec3::X * 6.0, 2.0);
        run(&mut app, 60);
        particles(&app, cloth).iter().map(|p| p.y).fold(f32::MIN, f32::max)
    };
    assert!(thrown(4.5) > 0.02, "blown up by {} m", thrown(4.5));
    assert!(thrown(400.0).abs() < 1.0e-3, "blown up by {} m", thrown(400.0));
}

#[test]
fn a_body_that_no_longer_takes_part_is_told_of_nothing() {
    for nowhere in [false, true] {
        let mut app = app();
        let mast = app.world_mut().spawn((Transform::default(), ClothCoupling::TwoWay)).id();
        spawn(&mut app, sheet(8), border().to(mast));
        run(&mut app, 30);
        let given = |app: &App| *app.world().get::<ClothReaction>(mast).expect("a body that took part");
        assert!(given(&app).linear.y < 0.0, "the mast bears {:?}", given(&app));
        if nowhere {
            app.world_mut().get_mut::<Transform>(mast).expect("a transform").translation.x = f32::NAN;
        } else {
            app.world_mut().entity_mut(mast).insert(ClothCoupling::OneWay);
        }
        run(&mut app, 1);
        assert!(given(&app).is_zero(), "nowhere {nowhere}: {:?}", given(&app));
    }
}

#[test]
fn what_cloth_gave_a_body_stands_for_the_time_in_which_it_did_and_for_no_frame_more() {
    let mut app = app();
    let mast = app.world_mut().spawn((Transform::default(), ClothCoupling::TwoWay)).id();
    let material = ClothMaterial { density: 0.2, ..default() };
    spawn(&mut app, sheet(8), (border().to(mast), material, ClothSleepDisabled));
    run(&mut app, 600);
    let given = |app: &App| *app.world().get::<ClothReaction>(mast).expect("a two-way body");
    // 0.2 kg, of which pins bear their own share, too.
    assert!((given(&app).force().y + 0.2 * 9.81).abs() < 0.02, "{:?}", given(&app));
    // Every other frame is simulated, together with the one before.
    frame_length(&mut app, 0.7e-3);
    run(&mut app, 100);
    let (mut sum, mut time, mut empty) = (0.0, 0.0, 0);
    for _ in 0..40 {
        run(&mut app, 1);
        let ClothReaction { linear, duration, .. } = given(&app);
        (sum, time) = (sum + linear.y, time + duration);
        empty += u32::from(given(&app) == ClothReaction::default());
    }
    assert!(empty == 20 && (time - 28.0e-3).abs() < 1.0e-5, "{empty} frames without, {time} s with");
    assert!((sum / time + 0.2 * 9.81).abs() < 0.1, "{} N", sum / time);
    frame_length(&mut app, 0.0);
    run(&mut app, 3);
    assert_eq!(given(&app), ClothReaction::default(), "time stands still");
    assert_eq!(given(&app).force(), Vec3::ZERO);
}

#[test]
fn a_mast_bears_what_a_hand_draws_at_its_flag() {
    let mut app = app();
    app.insert_resource(ClothGravity(Vec3::ZERO));
    let mast = app.world_mut().spawn((Transform::default(), ClothCoupling::TwoWay)).id();
    let cloth = spawn(&mut app, sheet(12), (border().to(mast), ClothSleepDisabled));
    run(&mut app, 5);
    let hit =
        app.world_mut().run_system_cached(|q: ClothQuery| q.nearest_point(Vec3::new(0.0, 0.0, 0.5), 0.1)).expect("a system");
    let grab = ClothGrab::at(&hit.expect("a point"));
    assert_eq!(grab.cloth, cloth);
    let hand = Vec3::new(0.0, 0.0, 0.52);
    app.world_mut().spawn(ClothGrab { target: hand, ..grab });
    run(&mut app, 300);
    let mean = (0..60).map(|_| {
        run(&mut app, 1);
        app.world().get::<ClothReaction>(mast).expect("a two-way body").force()
    });
    let force = mean.sum::<Vec3>() / 60.0;
    // It is drawn by two centimetres of a metre: many newtons, along z.
    assert!(force.z > 0.5 && force.x.abs() + force.y.abs() < 0.05 * force.z, "{force} N");
}

#[test]
fn a_collider_that_was_disabled_sweeps_nothing_on_its_way() {
    use bevy::ecs::entity_disabling::Disabled;
    let mut app = app();
    app.insert_resource(ClothGravity(Vec3::ZERO));
    let cloth = spawn(&mut app, sheet(8), ());
    let ball = app.world_mut().spawn((Transform::from_xyz(0.0, 0.4, 0.0), ClothCollider::ball(0.2))).id();
    run(&mut app, 10);
    app.world_mut().entity_mut(ball).insert(Disabled);
    run(&mut app, 2);
    app.world_mut().get_mut::<Transform>(ball).expect("a transform").translation.y = -0.4;
    run(&mut app, 2);
    app.world_mut().entity_mut(ball).remove::<Disabled>();
    run(&mut app, 10);
    assert!(lowest(&world_positions(&app, cloth)).abs() < 1.0e-3, "it was taken along");
}
