//! Characters among others, and what is asked of the skin beneath cloth.

use bevy::ecs::system::RunSystemOnce;
use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_drape::ClothSkinQuery;
use bevy_drape::prelude::*;

use crate::common::*;

/// A character with a ball for a bone at `at`, and its bone.
fn character(app: &mut App, at: Vec3) -> (Entity, Entity) {
    let root = app.world_mut().spawn((Transform::from_translation(at), ClothCharacter)).id();
    let bone = app.world_mut().spawn((Transform::default(), ClothCollider::ball(0.2), ChildOf(root))).id();
    (root, bone)
}

/// A sheet on the head of a character; another one, spawned before it, passes by at arm's length, or not. Where the sheet is at
/// the end, and how many bodies it could meet in each frame.
fn passed(passes: bool) -> (Vec<Vec3>, Vec<u32>) {
    let mut app = app();
    let (other, _) = character(&mut app, Vec3::Z * 40.0);
    app.world_mut().spawn((Transform::from_xyz(0.0, -1.0, 0.0), ClothCollider::ground()));
    let (wearer, _) = character(&mut app, Vec3::ZERO);
    let above = Transform::from_xyz(0.0, 0.25, 0.0);
    let cloth = spawn(&mut app, sheet(12), (above, ClothSleepDisabled, ChildOf(wearer)));
    let mut bodies = Vec::new();
    for frame in 0..120 {
        let nears = passes && (50..80).contains(&frame);
        let at = if nears { Vec3::new(1.1, -0.5, 0.0) } else { Vec3::Z * 40.0 };
        app.world_mut().get_mut::<Transform>(other).expect("a character").translation = at;
        run(&mut app, 1);
        bodies.push(report(&app, cloth).bodies);
    }
    (particles(&app, cloth), bodies)
}

#[test]
fn bones_of_others_count_only_where_they_are_near_and_what_is_known_of_bodies_stays() {
    let (alone, bodies) = passed(false);
    assert!(bodies.iter().all(|bodies| *bodies == 2), "{bodies:?}");
    let (passed, bodies) = passed(true);
    assert!((bodies[40], bodies[60], bodies[110]) == (2, 3, 2), "{bodies:?}");
    let apart = alone.iter().zip(&passed).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    assert!(lowest(&alone) > -0.9 && apart < 1.0e-3, "who only passes by moved it by {apart} m");
}

#[test]
fn the_skin_and_depths_in_bodies_are_told() {
    let mut app = app();
    app.world_mut().spawn((Transform::from_xyz(3.0, 0.0, 0.0), ClothCollider::ball(0.3)));
    let at = Transform::from_xyz(3.0, 1.0, 0.0);
    let limits = ClothLimits { max_distance: ClothMap::Uniform(0.1), ..default() };
    let cloth = spawn(&mut app, sheet(5), (at, limits));
    run(&mut app, 10);
    let points = [DVec3::new(3.0, 0.0, 0.0), DVec3::new(3.0, 0.2, 0.0), DVec3::new(3.0, 0.5, 0.0)];
    let told = app.world_mut().run_system_once(move |skins: ClothSkinQuery| {
        let places: Vec<DVec3> = skins.places(cloth).expect("a bound cloth").collect();
        let distance = skins.skinned(cloth).map(|skinned| skinned.distance(0));
        (places, distance, skins.depths(cloth, points).expect("a bound cloth"), skins.places(Entity::PLACEHOLDER).is_some())
    });
    let (places, distance, depths, is_nobody) = told.expect("a system");
    assert!(places.len() == 25 && places.iter().all(|place| (place.y - 1.0).abs() < 1.0e-5), "{places:?}");
    assert_eq!((distance, is_nobody), (Some(0.1), false));
    for (depth, expected) in depths.iter().zip([0.3, 0.1, 0.0]) {
        assert!((depth - expected).abs() < 1.0e-5, "{depths:?}");
    }
}
