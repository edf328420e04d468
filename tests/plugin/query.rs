//! Rays and nearest points against shown cloth.

use bevy::prelude::*;
use bevy_drape::{ClothHit, ClothRest, prelude::*};

use crate::common::*;

fn ask(app: &mut App, ask: impl Fn(&ClothQuery) -> Option<ClothHit> + Send + Sync + 'static) -> Option<ClothHit> {
    app.world_mut().run_system_once(move |cloths: ClothQuery| ask(&cloths)).expect("a system")
}

use bevy::ecs::system::RunSystemOnce;

#[test]
fn a_ray_finds_the_triangle_that_is_drawn_there() {
    let mut app = app();
    // Far from the origin, turned and scaled.
    let place =
        Transform { translation: Vec3::new(100.0, 5.0, -30.0), rotation: Quat::from_rotation_y(0.7), scale: Vec3::splat(2.0) };
    let cloth = spawn(&mut app, sheet(12), (border(), place));
    run(&mut app, 40);
    let shown = world_positions(&app, cloth);
    let shape = app.world().get::<ClothRest>(cloth).expect("a cloth").shape().clone();
    for (face, t) in shape.topology.faces.iter().enumerate().step_by(17) {
        let corner = |p: u32| shown[shape.particle_of_vertex.iter().position(|&q| q == p).expect("a vertex")];
        let [a, b, c] = t.map(corner);
        let (middle, normal) = ((a + b + c) / 3.0, (b - a).cross(c - a).normalize());
        let from = middle + normal * 0.02;
        let hit =
            ask(&mut app, move |q| q.cast_ray(Ray3d::new(from, Dir3::new(-normal).expect("a direction")), 1.0)).expect("a hit");
        assert_eq!((hit.entity, hit.triangle, hit.particles), (cloth, face as u32, *t));
        assert!(hit.point.distance(middle) < 1.0e-3 && (hit.distance - 0.02).abs() < 1.0e-3, "{hit:?} for {middle}");
        assert!(
            hit.normal.dot(normal) > 0.999 && (hit.barycentric - Vec3::splat(1.0 / 3.0)).abs().max_element() < 0.02,
            "{hit:?}"
        );
        let near = ask(&mut app, move |q| q.nearest_point(from, 1.0)).expect("a point");
        assert!(near.distance <= 0.0201 && near.entity == cloth, "{near:?}");
    }
}

#[test]
fn the_nearer_of_two_cloths_is_found_and_a_filter_finds_the_other() {
    let mut app = app();
    let [low, high] =
        [0.0, 1.0].map(|y| spawn(&mut app, sheet(6), (Transform::from_xyz(0.0, y, 0.0), ClothPins::where_position(|_| true))));
    run(&mut app, 2);
    let ray = Ray3d::new(Vec3::new(0.1, 3.0, 0.13), Dir3::NEG_Y);
    let hit = ask(&mut app, move |q| q.cast_ray(ray, 10.0)).expect("a hit");
    assert!(hit.entity == high && (hit.distance - 2.0).abs() < 1.0e-4, "{hit:?}");
    let hit = ask(&mut app, move |q| q.cast_ray_if(ray, 10.0, |e| e == low)).expect("a hit");
    assert!(hit.entity == low && (hit.distance - 3.0).abs() < 1.0e-4, "{hit:?}");
    assert_eq!(ask(&mut app, move |q| q.cast_ray(ray, 1.9)), None);
    let near = ask(&mut app, |q| q.nearest_point(Vec3::new(2.0, 0.1, 0.0), 10.0)).expect("a point");
    assert!(near.entity == low && near.point.distance(Vec3::new(0.5, 0.0, 0.0)) < 1.0e-3, "{near:?}");
    assert_eq!(ask(&mut app, |q| q.nearest_point(Vec3::new(2.0, 0.1, 0.0), 1.0)), None);
}

#[test]
fn nonsense_finds_nothing() {
    let mut app = app();
    spawn(&mut app, sheet(6), border());
    run(&mut app, 2);
    let ray = |origin| Ray3d { origin, direction: Dir3::NEG_Y };
    assert_eq!(ask(&mut app, move |q| q.cast_ray(ray(Vec3::NAN), 10.0)), None);
    assert_eq!(ask(&mut app, move |q| q.cast_ray(ray(Vec3::Y), f32::NAN)), None);
    assert_eq!(ask(&mut app, |q| q.nearest_point(Vec3::NAN, 10.0)), None);
    assert_eq!(ask(&mut app, |q| q.nearest_point(Vec3::ZERO, -1.0)), None);
    assert_eq!(ask(&mut app, |q| q.nearest_point(Vec3::splat(3.0e38), f32::INFINITY)), None, "no distance is that far");
}

#[test]
fn a_cloth_that_is_switched_off_is_found_where_its_mesh_went() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(6), ClothPins::where_position(|_| true));
    run(&mut app, 2);
    app.world_mut().entity_mut(cloth).insert(ClothDisabled);
    app.world_mut().get_mut::<Transform>(cloth).expect("a transform").translation = Vec3::new(3.0, 1.0, 0.0);
    run(&mut app, 2);
    let down = |x: f32| Ray3d::new(Vec3::new(x, 3.0, 0.13), Dir3::NEG_Y);
    assert_eq!(ask(&mut app, move |q| q.cast_ray(down(0.1), 10.0)), None, "it is not there any more");
    let hit = ask(&mut app, move |q| q.cast_ray(down(3.1), 10.0)).expect("a hit");
    assert!(hit.entity == cloth && (hit.distance - 2.0).abs() < 1.0e-4, "{hit:?}");
}

#[test]
fn a_cloth_that_faded_into_its_skin_is_not_found() {
    let mut app = app();
    let (cloth, _) = crate::skinned::dressed(&mut app, 8, (ClothLimits::default(), ClothBlend::default()));
    run(&mut app, 10);
    assert!(ask(&mut app, |q| q.nearest_point(Vec3::ZERO, 1.0)).is_some());
    app.world_mut().get_mut::<ClothBlend>(cloth).expect("a blend").weight = 0.0;
    run(&mut app, 60);
    assert_eq!(report(&app, cloth).substeps, 0, "it is only animated");
    assert_eq!(ask(&mut app, |q| q.nearest_point(Vec3::ZERO, 1.0)), None);
}
