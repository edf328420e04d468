//! Bodies of avian: picked up without a line of code, and given back what cloth does to them.

use avian3d::prelude::*;
use bevy::ecs::entity_disabling::Disabled;
use bevy::ecs::schedule::{ScheduleLabel, SingleThreadedExecutor};
use bevy::mesh::MeshPlugin;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_drape::prelude::*;

use crate::common::*;

/// Gravity of both engines [m/s²].
const G: f32 = 9.81;
/// Ticks in a second.
const RATE: usize = 60;

/// Cloth and physics, a tick in every update.
fn physics(schedule: impl ScheduleLabel) -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default(), MeshPlugin));
    app.add_plugins((PhysicsPlugins::default(), ClothPlugin::new(schedule)));
    app.insert_resource(Time::<Fixed>::from_hz(RATE as f64));
    app.insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    app.insert_resource(Gravity(Vec3::NEG_Y * G));
    app.insert_resource(ClothGravity(Vec3::NEG_Y * G));
    app.finish();
    app.cleanup();
    app.update();
    app
}

/// An elastic net of 2 m, its middle sagging when at rest.
fn net(n: u32) -> Mesh {
    let mut mesh = Plane3d::default().mesh().size(2.0, 2.0).subdivisions(n - 2).build();
    if let Ok(bevy::mesh::VertexAttributeValues::Float32x3(points)) = mesh.try_attribute_mut(Mesh::ATTRIBUTE_POSITION) {
        for p in points {
            p[1] = -0.3 * (1.0 - p[0] * p[0]) * (1.0 - p[2] * p[2]);
        }
    }
    mesh
}

fn elastic() -> ClothMaterial {
    ClothMaterial { density: 0.2, strain_limit: f32::INFINITY, tether_scale: f32::INFINITY, ..default() }
}

fn rim() -> ClothPins {
    ClothPins::where_position(|p| p.x.abs() > 0.999 || p.z.abs() > 0.999)
}

fn ball(mass: f32, radius: f32, at: Vec3) -> impl Bundle {
    (RigidBody::Dynamic, Collider::sphere(radius), Mass(mass), Transform::from_translation(at), ClothCoupling::TwoWay)
}

fn at(app: &App, body: Entity) -> Vec3 {
    app.world().get::<Position>(body).expect("a body").0
}

fn velocity(app: &App, body: Entity) -> Vec3 {
    app.world().get::<LinearVelocity>(body).expect("a body").0
}

fn bodies(app: &App, cloth: Entity) -> u32 {
    report(app, cloth).bodies
}

fn impulse(app: &App, body: Entity) -> ClothReaction {
    *app.world().get::<ClothReaction>(body).expect("a two-way body")
}

/// Until cloth holds a ball that fell into it, and may bounce.
fn run_until_borne(app: &mut App, body: Entity) {
    run(app, 30);
    for _ in 0..2 * RATE {
        if impulse(app, body).linear.y > 0.0 {
            return;
        }
        run(app, 1);
    }
    panic!("the net holds the ball: {:?}", impulse(app, body));
}

/// Mass [kg] and momentum [kg m/s] of the free particles of a cloth.
fn momentum(app: &App, cloth: Entity) -> (f32, Vec3) {
    let state = app.world().get::<ClothParticles>(cloth).expect("a bound cloth").state();
    let free = (0..state.positions.len()).filter(|&i| state.positions[i].w > 0.0);
    free.fold((0.0, Vec3::ZERO), |(m, p), i| {
        let mass = state.positions[i].w.recip();
        (m + mass, p + mass * state.velocity(i))
    })
}

fn weight(app: &App, cloth: Entity) -> f32 {
    let areas = &app.world().get::<ClothRest>(cloth).expect("a bound cloth").shape().areas;
    app.world().get::<ClothMaterial>(cloth).expect("a cloth").density * areas.iter().sum::<f32>() * G
}

#[test]
fn avian_a_ball_comes_to_rest_in_a_net_whose_mast_bears_its_weight_in_either_schedule() {
    for (name, mut app) in [("FixedPostUpdate", physics(FixedPostUpdate)), ("PostUpdate", physics(PostUpdate))] {
        let mast = app.world_mut().spawn((Transform::default(), ClothCoupling::TwoWay)).id();
        let cloth = spawn(&mut app, net(24), (rim().to(mast), elastic()));
        let ball = app.world_mut().spawn(ball(1.0, 0.2, Vec3::new(0.0, 0.6, 0.0))).id();
        run(&mut app, 20 * RATE);
        let (mut sum, mut fastest) = (0.0, 0.0_f32);
        for _ in 0..RATE {
            run(&mut app, 1);
            sum += impulse(&app, mast).linear.y;
            fastest = fastest.max(velocity(&app, ball).length());
        }
        let expected = -(G + weight(&app, cloth));
        assert!((sum / expected - 1.0).abs() < 0.02, "{name}: the mast bears {sum} N of {expected} N");
        assert!(fastest < 0.05, "{name}: the ball still moves at {fastest} m/s");
        assert!(at(&app, ball).y > -0.9 && at(&app, ball).y < 0.0, "{name}: the ball is at {}", at(&app, ball));
    }
}

#[test]
fn avian_a_ball_and_a_free_sheet_keep_their_momentum() {
    for mass in [0.05, 1.0, 20.0] {
        let mut app = physics(FixedPostUpdate);
        app.insert_resource(Gravity(Vec3::ZERO)).insert_resource(ClothGravity(Vec3::ZERO));
        app.insert_resource(ClothGlobalWind { air_density: 0.0, ..default() });
        let still = ClothMaterial { density: 0.3, drag: 0.0, damping: 0.0, ..default() };
        let alone = ClothCollision { self_collision: false, ..default() };
        let cloth = spawn(&mut app, sheet(20), (still, alone));
        let ball = app.world_mut().spawn((ball(mass, 0.15, Vec3::new(0.1, 0.3, 0.0)), LinearVelocity(Vec3::NEG_Y * 4.0))).id();
        run(&mut app, 2);
        let total = |app: &App| momentum(app, cloth).1 + velocity(app, ball) * mass;
        let before = total(&app);
        run(&mut app, 40);
        let off = (total(&app) - before).length() / before.length();
        assert!(velocity(&app, ball).y > -3.995, "the ball of {mass} kg met nothing");
        assert!(off < 0.01, "momentum of {mass} kg and cloth is off by {off}");
    }
}

#[test]
fn avian_bodies_from_a_gram_to_a_tonne_stay_stable_on_a_net_and_on_the_floor() {
    for mass in [0.001, 0.03, 1.0, 30.0, 1000.0] {
        let mut app = physics(FixedPostUpdate);
        spawn(&mut app, net(20), (rim(), elastic()));
        app.world_mut().spawn((RigidBody::Static, Collider::half_space(Vec3::Y), Transform::from_xyz(0.0, -1.0, 0.0)));
        let ball = app.world_mut().spawn(ball(mass, 0.2, Vec3::Y * 0.3)).id();
        let mut highest = f32::MIN;
        for _ in 0..6 * RATE {
            run(&mut app, 1);
            let y = at(&app, ball).y;
            assert!(y.is_finite() && y > -1.1, "{mass} kg: the ball is at {y} m");
            highest = highest.max(y);
        }
        assert!(highest < 0.31, "{mass} kg: the ball was thrown to {highest} m");
        assert!(velocity(&app, ball).length() < 0.5, "{mass} kg: the ball moves at {}", velocity(&app, ball));
    }
}

#[test]
fn avian_colliders_of_every_kind_meet_cloth() {
    let mut app = physics(FixedPostUpdate);
    let cloth = spawn(&mut app, sheet(5), border());
    let triangle = (vec![Vec3::ZERO, Vec3::X, Vec3::Z], vec![[0, 2, 1]]);
    let shapes = [
        Collider::sphere(0.1),
        Collider::cuboid(0.1, 0.2, 0.3),
        Collider::capsule(0.1, 0.4),
        Collider::cylinder(0.1, 0.4),
        Collider::cone(0.1, 0.4),
        Collider::half_space(Vec3::Y),
        Collider::trimesh(triangle.0, triangle.1),
        Collider::convex_hull(vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z]).expect("a hull"),
        Collider::heightfield(vec![vec![0.0; 4]; 4], Vec3::ONE),
        Collider::round_cuboid(0.1, 0.1, 0.1, 0.05),
        Collider::compound(vec![
            (Vec3::ZERO, Quat::IDENTITY, Collider::sphere(0.1)),
            (Vec3::X, Quat::IDENTITY, Collider::sphere(0.2)),
        ]),
    ];
    let count = shapes.len() as u32;
    for shape in shapes {
        app.world_mut().spawn((RigidBody::Static, shape, Transform::from_xyz(0.0, -3.0, 0.0)));
    }
    run(&mut app, 3);
    assert_eq!(bodies(&app, cloth), count);
    assert!(finite(&app, cloth));
}

#[test]
fn avian_a_sheet_drapes_over_children_and_scaled_colliders() {
    let mut app = physics(FixedPostUpdate);
    let cloth = spawn(&mut app, sheet(24), Transform::from_xyz(0.0, 0.6, 0.0));
    // A ball of 0.15 m at twice the scale, as a child that is set off from its body.
    app.world_mut()
        .spawn((RigidBody::Static, Transform::from_xyz(0.0, -1.0, 0.0)))
        .with_child((Collider::sphere(0.15), Transform::from_xyz(0.0, 1.0, 0.0).with_scale(Vec3::splat(2.0))));
    app.world_mut().spawn((RigidBody::Static, Collider::half_space(Vec3::Y), Transform::from_xyz(0.0, -0.6, 0.0)));
    run(&mut app, 180);
    let nearest = particles(&app, cloth).iter().map(|p| p.length()).fold(f32::MAX, f32::min);
    assert!(nearest > 0.295 && nearest < 0.32, "the nearest particle is {nearest} m from the centre");
    assert!(lowest(&particles(&app, cloth)) > -0.605);
}

#[test]
fn avian_layers_sensors_and_what_is_disabled_are_ignored() {
    let mut app = physics(FixedPostUpdate);
    let cloth = spawn(&mut app, sheet(5), (border(), ClothCollisionLayers::new(0b01, 0b01)));
    let far = Transform::from_xyz(0.0, -5.0, 0.0);
    let mut with = |extra: &mut dyn FnMut(&mut EntityWorldMut)| {
        let mut entity = app.world_mut().spawn((RigidBody::Static, Collider::sphere(0.1), far));
        extra(&mut entity);
        entity.id()
    };
    with(&mut |_| {});
    with(&mut |e| {
        e.insert(CollisionLayers::from_bits(0b10, u32::MAX));
    });
    with(&mut |e| {
        e.insert(CollisionLayers::from_bits(0b01, 0b10));
    });
    with(&mut |e| {
        e.insert((CollisionLayers::from_bits(0b10, 0), ClothCollisionLayers::DEFAULT));
    });
    with(&mut |e| {
        e.insert(Sensor);
    });
    with(&mut |e| {
        e.insert(ClothCollisionDisabled);
    });
    let disabled = [
        with(&mut |e| {
            e.insert(ColliderDisabled);
        }),
        with(&mut |e| {
            e.insert(RigidBodyDisabled);
        }),
        with(&mut |e| {
            e.insert(Disabled);
        }),
    ];
    // A collider without a body takes no part in physics, nor here; one of ours on the same entity counts once.
    app.world_mut().spawn((Collider::sphere(0.1), far));
    let both = app.world_mut().spawn((RigidBody::Static, Collider::sphere(0.1), ClothCollider::ball(0.2), far)).id();
    run(&mut app, 3);
    assert_eq!(bodies(&app, cloth), 3, "the plain one, the one with layers of its own, and the one with both");

    app.world_mut().entity_mut(disabled[0]).remove::<ColliderDisabled>();
    app.world_mut().entity_mut(disabled[1]).remove::<RigidBodyDisabled>();
    app.world_mut().entity_mut(disabled[2]).remove::<Disabled>();
    run(&mut app, 3);
    assert_eq!(bodies(&app, cloth), 6);

    app.world_mut().entity_mut(disabled[0]).remove::<Collider>();
    app.world_mut().entity_mut(disabled[1]).despawn();
    app.world_mut().entity_mut(both).remove::<ClothCollider>();
    run(&mut app, 3);
    assert_eq!(bodies(&app, cloth), 4, "avian's collider is left where ours was removed");
}

#[test]
fn avian_a_body_that_is_despawned_in_a_net_leaves_it_sound() {
    let mut app = physics(FixedPostUpdate);
    let cloth = spawn(&mut app, net(16), (rim(), elastic()));
    let body = app.world_mut().spawn(ball(1.0, 0.2, Vec3::new(0.0, 0.0, 0.0))).id();
    run_until_borne(&mut app, body);
    app.world_mut().despawn(body);
    run(&mut app, 60);
    assert_eq!(bodies(&app, cloth), 0);
    assert!(finite(&app, cloth));
}

#[test]
fn avian_a_flag_on_a_moving_mast_does_not_lag_in_either_schedule() {
    for (name, mut app) in [("FixedPostUpdate", physics(FixedPostUpdate)), ("PostUpdate", physics(PostUpdate))] {
        let mast = (RigidBody::Kinematic, Collider::cylinder(0.05, 2.0), LinearVelocity(Vec3::new(3.0, 0.0, 1.0)));
        let mast = app.world_mut().spawn((mast, Transform::from_xyz(0.0, 0.0, -0.6))).id();
        // Held by the tip, a child.
        let tip = app.world_mut().spawn((Transform::from_xyz(0.0, 1.0, 0.0), ChildOf(mast))).id();
        let cloth = spawn(&mut app, sheet(12), border().to(tip));
        run(&mut app, 2);
        let held: Vec<usize> = (0..144).filter(|&i| particles(&app, cloth)[i].z < at(&app, mast).z + 0.6 - 0.45).collect();
        let local: Vec<Vec3> = held.iter().map(|&i| particles(&app, cloth)[i] - at(&app, mast)).collect();
        assert_eq!(held.len(), 12);
        run(&mut app, 60);
        let lag =
            held.iter().zip(&local).map(|(&i, at_start)| (particles(&app, cloth)[i] - at(&app, mast)).distance(*at_start));
        let lag = lag.fold(0.0, f32::max);
        assert!(lag < 1.0e-4, "{name}: the flag is {lag} m behind its mast");
    }
}

#[test]
fn avian_what_hangs_on_a_sheet_is_held_up_and_bears_on_the_mast() {
    for mass in [0.05, 1.0, 5.0] {
        let mut app = physics(FixedPostUpdate);
        let mast = app.world_mut().spawn((Transform::default(), ClothCoupling::TwoWay)).id();
        let start = Vec3::new(0.0, 0.0, 0.6);
        let lantern = app.world_mut().spawn((ball(mass, 0.1, start), ClothCollisionDisabled)).id();
        let pins = border().to(mast).and(ClothPins::where_position(|p| p.z > 0.499).to(lantern));
        let cloth = spawn(&mut app, sheet(12), (pins, ClothMaterial { drag: 1.0, ..default() }));
        run(&mut app, 14 * RATE);
        let (mut sum, mut fastest) = (Vec3::ZERO, 0.0_f32);
        for _ in 0..RATE {
            run(&mut app, 1);
            sum += impulse(&app, mast).linear;
            fastest = fastest.max(velocity(&app, lantern).length());
        }
        // The particles that are pinned to the lantern weigh nothing: a half of a row of eleven.
        let expected = -(mass * G + weight(&app, cloth) * (1.0 - 1.0 / 22.0));
        assert!((sum.y / expected - 1.0).abs() < 0.02, "{mass} kg: the mast bears {sum} N of {expected} N");
        assert!((at(&app, lantern).y + 1.0).abs() < 0.2, "{mass} kg: the lantern is at {}", at(&app, lantern));
    }
}

#[test]
fn avian_a_one_way_body_feels_nothing_and_a_sleeping_two_way_body_wakes() {
    let mut app = physics(FixedPostUpdate);
    app.insert_resource(Gravity(Vec3::ZERO));
    spawn(&mut app, sheet(12), Transform::from_xyz(0.0, 0.5, 0.0));
    let one = app.world_mut().spawn((RigidBody::Dynamic, Collider::sphere(0.2), Mass(0.1))).id();
    run(&mut app, 60);
    assert_eq!(velocity(&app, one), Vec3::ZERO);
    assert_eq!(at(&app, one), Vec3::ZERO);

    let mut app = physics(FixedPostUpdate);
    app.insert_resource(Gravity(Vec3::ZERO));
    spawn(&mut app, sheet(12), Transform::from_xyz(0.0, 0.5, 0.0));
    let two = app.world_mut().spawn((ball(0.1, 0.2, Vec3::ZERO), Sleeping)).id();
    run(&mut app, 2);
    assert!(app.world().get::<Sleeping>(two).is_some(), "nothing touches it yet");
    run(&mut app, 60);
    assert!(app.world().get::<Sleeping>(two).is_none(), "cloth fell on it");
    assert!(velocity(&app, two).y < -0.1, "it moves at {}", velocity(&app, two));
}

#[test]
fn avian_locked_axes_paused_physics_and_disabled_coupling_hold() {
    let mut app = physics(FixedPostUpdate);
    let cloth = spawn(&mut app, net(16), (rim(), elastic()));
    let locked = LockedAxes::ROTATION_LOCKED.lock_translation_y();
    let body = app.world_mut().spawn((ball(1.0, 0.2, Vec3::new(0.0, -0.25, 0.0)), locked)).id();
    run(&mut app, 60);
    assert!((at(&app, body).y + 0.25).abs() < 1.0e-4, "a locked ball is at {}", at(&app, body));
    assert_eq!(app.world().get::<AngularVelocity>(body).expect("a body").0, Vec3::ZERO);

    app.world_mut().entity_mut(body).remove::<LockedAxes>();
    app.world_mut().resource_mut::<Time<Physics>>().pause();
    // Avian makes one more tick.
    run(&mut app, 2);
    let before = at(&app, body);
    run(&mut app, 30);
    assert_eq!(at(&app, body), before, "physics is paused");
    app.world_mut().resource_mut::<Time<Physics>>().unpause();
    run(&mut app, 30);
    assert!(at(&app, body).distance(before) > 0.01, "physics goes on, and the ball is still at {}", at(&app, body));

    app.world_mut().entity_mut(body).remove::<ClothCoupling>();
    run(&mut app, 5);
    assert!(app.world().get::<ClothReaction>(body).is_none());
    assert!(finite(&app, cloth));
}

#[test]
fn avian_physics_of_your_own_is_told_of_impulses() {
    // A mast of ours without avian, and a crate that a game moves by itself.
    let mut app = app();
    let cloth = spawn(&mut app, net(20), (rim(), elastic()));
    let rigid = ClothRigidBody::ball(1.0, 0.2);
    let ball = app.world_mut().spawn((ClothCollider::ball(0.2), ClothCoupling::TwoWay, rigid)).id();
    let mut speed = Vec3::ZERO;
    for _ in 0..900 {
        let world = app.world_mut();
        let given = *world.get::<ClothReaction>(ball).expect("a two-way body");
        let mut transform = world.get_mut::<Transform>(ball).expect("a body");
        transform.translation += given.displacement;
        speed += given.linear;
        transform.translation += speed * FRAME - Vec3::Y * (0.5 * G * FRAME * FRAME);
        speed.y -= G * FRAME;
        world.get_mut::<ClothRigidBody>(ball).expect("a body").velocity = Some(speed);
        run(&mut app, 1);
    }
    let at = app.world().get::<Transform>(ball).expect("a body").translation;
    assert!(at.y < -0.2 && at.y > -0.9 && speed.length() < 0.3, "the ball is at {at}, {speed}");
    assert!(report(&app, cloth).body_contacts > 0);
}

#[test]
fn avian_and_cloth_give_the_same_bits_on_one_thread_and_on_many() {
    let fall = |single: bool| {
        let mut app = physics(FixedPostUpdate);
        if single {
            for label in [FixedPostUpdate.intern(), PostUpdate.intern()] {
                app.edit_schedule(label, |schedule| {
                    schedule.set_executor(SingleThreadedExecutor::new());
                });
            }
        }
        let mast = app.world_mut().spawn((Transform::default(), ClothCoupling::TwoWay)).id();
        let nets: Vec<Entity> = (0..3)
            .map(|i| spawn(&mut app, net(12 + i), (rim().to(mast), elastic(), Transform::from_xyz(0.0, -0.1 * i as f32, 0.0))))
            .collect();
        let ball = app.world_mut().spawn(ball(2.0, 0.2, Vec3::Y * 0.3)).id();
        run(&mut app, 120);
        let cloths: Vec<Vec<Vec3>> = nets.iter().map(|&net| positions(&app, net)).collect();
        (at(&app, ball), velocity(&app, ball), impulse(&app, mast).linear, cloths)
    };
    let first = fall(false);
    assert!(first == fall(false), "a second run differs");
    assert!(first == fall(true), "a single thread differs");
}

#[test]
fn avian_a_body_that_no_longer_takes_part_falls_freely() {
    let mut app = physics(FixedPostUpdate);
    spawn(&mut app, net(16), (rim(), elastic()));
    let body = app.world_mut().spawn(ball(1.0, 0.2, Vec3::ZERO)).id();
    run_until_borne(&mut app, body);
    app.world_mut().entity_mut(body).insert((ClothCoupling::OneWay, ClothCollisionDisabled));
    run(&mut app, 1);
    assert!(impulse(&app, body).is_zero(), "{:?}", impulse(&app, body));
    let before = velocity(&app, body).y;
    run(&mut app, RATE / 2);
    let gained = velocity(&app, body).y - before;
    assert!((gained + 0.5 * G).abs() < 0.05, "it gained {gained} m/s");
}

#[test]
fn avian_a_net_does_not_sleep_under_a_ball_at_rest() {
    let mut app = physics(FixedPostUpdate);
    record::<ClothSlept>(&mut app);
    let cloth = spawn(&mut app, net(16), (rim(), elastic()));
    let damped = (LinearDamping(5.0), AngularDamping(5.0));
    let ball = app.world_mut().spawn((ball(1.0, 0.2, Vec3::new(0.0, -0.1, 0.0)), damped)).id();
    run(&mut app, 20 * RATE);
    assert!(seen::<ClothSlept>(&app).is_empty() && !report(&app, cloth).asleep, "{:?}", report(&app, cloth));
    assert!(at(&app, ball).y > -0.9 && velocity(&app, ball).length() < 0.05, "{} {}", at(&app, ball), velocity(&app, ball));
}

#[test]
fn avian_a_margin_below_nothing_counts_as_none() {
    // Avian's own assertions let no NaN pass.
    for margin in [-0.05, 50.0] {
        let mut app = physics(FixedPostUpdate);
        let (cloth, _) =
            crate::skinned::dressed(&mut app, 8, ClothLimits { max_distance: ClothMap::Uniform(0.1), ..default() });
        app.world_mut().spawn((
            RigidBody::Static,
            Collider::sphere(0.1),
            CollisionMargin(margin),
            Transform::from_xyz(0.2, -0.15, 0.0),
        ));
        run(&mut app, 30);
        assert!(finite(&app, cloth) && bodies(&app, cloth) == 1, "{margin}");
    }
}
