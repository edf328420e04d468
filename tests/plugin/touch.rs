//! Who touches whom is told to those who ask, once.

use bevy::prelude::*;
use bevy_drape::prelude::*;

use crate::common::*;

fn recorded() -> App {
    let mut app = app();
    record::<ClothContactStarted>(&mut app);
    record::<ClothContactEnded>(&mut app);
    app
}

#[test]
fn a_sheet_that_lands_touches_the_ball_and_then_the_ground_each_once() {
    let mut app = recorded();
    let ball = app.world_mut().spawn((Transform::from_xyz(0.0, 0.2, 0.0), ClothCollider::ball(0.2))).id();
    let ground = app.world_mut().spawn(ClothCollider::ground()).id();
    let cloth = spawn(&mut app, sheet(14), (Transform::from_xyz(0.0, 0.6, 0.0), ClothContactEvents::default()));
    run(&mut app, 240);
    let started: Vec<Entity> = seen::<ClothContactStarted>(&app).iter().map(|e| e.touch.other).collect();
    assert_eq!(started, [ball, ground]);
    assert!(seen::<ClothContactEnded>(&app).is_empty());
    let first = seen::<ClothContactStarted>(&app)[0];
    assert_eq!(first.entity, cloth);
    let touch = first.touch;
    assert!(touch.contacts >= 1 && touch.impulse > 0.0 && touch.since == 0.0, "{touch:?}");
    assert!(touch.normal.y > 0.9 && touch.point.distance(Vec3::new(0.0, 0.4, 0.0)) < 0.1, "{touch:?}");
    let touches = app.world().get::<ClothContacts>(cloth).expect("asked for").touches.clone();
    assert_eq!(touches.len(), 2, "{touches:?}");
    // The weight of 0.2 kg over a frame, at most.
    let most = touches.iter().map(|t| t.impulse * t.contacts as f32).sum::<f32>();
    assert!(most > 0.2 * 9.81 * FRAME, "{touches:?}");
}

#[test]
fn a_body_that_goes_has_ended_once() {
    let mut app = recorded();
    let ball = app.world_mut().spawn((Transform::default(), ClothCollider::ball(0.2))).id();
    let cloth = spawn(&mut app, sheet(10), (Transform::from_xyz(0.0, 0.25, 0.0), border(), ClothContactEvents::default()));
    run(&mut app, 60);
    assert_eq!(seen::<ClothContactStarted>(&app).len(), 1);
    app.world_mut().despawn(ball);
    run(&mut app, 60);
    let ended: Vec<(Entity, Entity)> = seen::<ClothContactEnded>(&app).iter().map(|e| (e.entity, e.other)).collect();
    assert_eq!(ended, [(cloth, ball)]);
    assert!(app.world().get::<ClothContacts>(cloth).expect("asked for").touches.is_empty());
}

#[test]
fn two_cloths_tell_of_each_other_to_those_who_ask() {
    let mut app = recorded();
    app.world_mut().spawn((Transform::default(), ClothCollider::ball(0.3)));
    let lower = spawn(&mut app, sheet(14), Transform::from_xyz(0.0, 0.33, 0.0));
    let upper = spawn(&mut app, sheet(14), (Transform::from_xyz(0.0, 0.40, 0.0), ClothContactEvents::default()));
    run(&mut app, 60);
    let of_cloth: Vec<&ClothContactStarted> =
        seen::<ClothContactStarted>(&app).iter().filter(|e| e.touch.other == lower).collect();
    assert_eq!(of_cloth.len(), 1, "{:?}", seen::<ClothContactStarted>(&app));
    let touch = of_cloth[0].touch;
    assert!(of_cloth[0].entity == upper && touch.normal.y > 0.5 && touch.impulse > 0.0, "{touch:?}");
}

#[test]
fn nobody_is_told_who_does_not_ask() {
    let mut app = recorded();
    app.world_mut().spawn(ClothCollider::ground());
    spawn(&mut app, sheet(6), Transform::from_xyz(0.0, 0.05, 0.0));
    run(&mut app, 60);
    assert!(seen::<ClothContactStarted>(&app).is_empty() && seen::<ClothContactEnded>(&app).is_empty());
}

#[test]
fn the_list_of_what_touches_comes_and_goes_with_the_asking() {
    let mut app = recorded();
    app.world_mut().spawn(ClothCollider::ground());
    let awake = ClothSleep { threshold: 0.0, ..default() };
    let cloth = spawn(&mut app, sheet(6), (Transform::from_xyz(0.0, 0.02, 0.0), awake));
    run(&mut app, 60);
    assert!(app.world().get::<ClothContacts>(cloth).is_none(), "nobody asked");
    for times in 1..=2 {
        app.world_mut().entity_mut(cloth).insert(ClothContactEvents::default());
        assert_eq!(app.world().get::<ClothContacts>(cloth), Some(&ClothContacts::default()));
        // Other settings leave the list alone.
        run(&mut app, 30);
        app.world_mut().entity_mut(cloth).insert(ClothContactEvents { patience: 0.2 });
        run(&mut app, 5);
        let touches = &app.world().get::<ClothContacts>(cloth).expect("asked for").touches;
        assert_eq!((touches.len(), seen::<ClothContactStarted>(&app).len()), (1, times), "{touches:?}");
        app.world_mut().entity_mut(cloth).remove::<ClothContactEvents>();
        run(&mut app, 5);
        assert!(app.world().get::<ClothContacts>(cloth).is_none(), "nobody asks any more");
    }
}

#[test]
fn a_cloth_that_falls_asleep_goes_on_touching() {
    let mut app = recorded();
    app.world_mut().spawn(ClothCollider::ground());
    let cloth = spawn(&mut app, sheet(6), (Transform::from_xyz(0.0, 0.05, 0.0), ClothContactEvents { patience: 0.0 }));
    run(&mut app, 300);
    assert!(report(&app, cloth).asleep, "{:?}", report(&app, cloth));
    assert!(seen::<ClothContactEnded>(&app).is_empty());
    assert_eq!(app.world().get::<ClothContacts>(cloth).expect("asked for").touches.len(), 1);
}

#[test]
fn a_body_that_leaves_does_not_double_the_ones_that_stay() {
    let mut app = recorded();
    let at = |x: f32| (Transform::from_xyz(x, -0.1, 0.0), ClothCollider::ball(0.1));
    let mut balls = [-0.3, 0.0, 0.3].map(|x| app.world_mut().spawn(at(x)).id());
    balls.sort_unstable();
    let cloth = spawn(&mut app, sheet(14), (Transform::from_xyz(0.0, 0.01, 0.0), border(), ClothContactEvents::default()));
    run(&mut app, 20);
    let touching = |app: &App| -> Vec<Entity> {
        app.world().get::<ClothContacts>(cloth).expect("asked for").touches.iter().map(|touch| touch.other).collect()
    };
    assert_eq!(touching(&app), balls);
    app.world_mut().despawn(balls[0]);
    for frame in 0..20 {
        run(&mut app, 1);
        let now = touching(&app);
        assert!(now == balls || now == balls[1..], "frame {frame}: {now:?} of {balls:?}");
    }
    let ended: Vec<Entity> = seen::<ClothContactEnded>(&app).iter().map(|e| e.other).collect();
    assert_eq!(ended, [balls[0]]);
    assert_eq!(seen::<ClothContactStarted>(&app).len(), 3);
}

#[test]
fn a_touch_of_a_height_field_has_the_normal_of_the_slope_there() {
    let mut app = recorded();
    let slope: Vec<f32> = (0..64 * 64).map(|i| 0.2 * (i / 64) as f32 / 63.0).collect();
    let field = ClothCollider::height_field(64, 64, slope, Vec3::new(4.0, 1.0, 4.0));
    app.world_mut().spawn(field);
    spawn(&mut app, sheet(10), (Transform::from_xyz(0.0, 0.2, 0.0), ClothContactEvents::default()));
    run(&mut app, 30);
    let [started] = seen::<ClothContactStarted>(&app) else { panic!("one touch") };
    let normal = started.touch.normal;
    assert!((normal.y - 0.05_f32.atan().cos()).abs() < 1.0e-3 && normal.is_normalized(), "{normal}");
}

#[test]
fn what_touched_a_cloth_that_is_no_longer_simulated_has_ended_once() {
    fn ends(stop: impl FnOnce(&mut App, Entity)) {
        let mut app = recorded();
        let ball = app.world_mut().spawn((Transform::default(), ClothCollider::ball(0.2))).id();
        let cloth = spawn(&mut app, sheet(10), (Transform::from_xyz(0.0, 0.25, 0.0), border(), ClothContactEvents::default()));
        run(&mut app, 60);
        assert_eq!(seen::<ClothContactStarted>(&app).len(), 1);
        stop(&mut app, cloth);
        run(&mut app, 3);
        let ended: Vec<(Entity, Entity)> = seen::<ClothContactEnded>(&app).iter().map(|e| (e.entity, e.other)).collect();
        assert_eq!(ended, [(cloth, ball)]);
        let left = app.world().get_entity(cloth).ok().and_then(|cloth| cloth.get::<ClothContacts>());
        assert!(left.is_none_or(|contacts| contacts.touches.is_empty()), "{left:?}");
    }
    ends(|app, cloth| _ = app.world_mut().entity_mut(cloth).insert(ClothDisabled));
    ends(|app, cloth| _ = app.world_mut().entity_mut(cloth).remove::<Cloth>());
    ends(|app, cloth| _ = app.world_mut().entity_mut(cloth).remove::<ClothContactEvents>());
    ends(|app, cloth| _ = app.world_mut().despawn(cloth));
    ends(|app, cloth| {
        let broken = add(app, Mesh::new(bevy::mesh::PrimitiveTopology::LineList, default()));
        app.world_mut().entity_mut(cloth).insert(Mesh3d(broken));
    });
}
