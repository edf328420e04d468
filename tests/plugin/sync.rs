//! What is shown: vertices, normals, tangents, bounds, and nothing else touched.

use bevy::camera::primitives::Aabb;
use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;
use bevy_drape::prelude::*;

use crate::common::*;

#[test]
fn normals_are_those_of_the_shown_surface() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(10), border());
    run(&mut app, 60);
    let mut expected = shown(&app, cloth).clone();
    expected.compute_area_weighted_normals();
    let ours = vectors(shown(&app, cloth), Mesh::ATTRIBUTE_NORMAL);
    for (i, (a, b)) in ours.iter().zip(vectors(&expected, Mesh::ATTRIBUTE_NORMAL)).enumerate() {
        assert!(a.distance(b) < 1.0e-3, "vertex {i}: {a} for {b}");
    }
}

#[test]
fn normals_are_right_under_an_uneven_scale() {
    let mut app = app();
    let transform = Transform { scale: Vec3::new(2.0, 0.5, 1.0), rotation: Quat::from_rotation_x(0.5), ..default() };
    let cloth = spawn(&mut app, sheet(10), (border(), transform));
    run(&mut app, 60);
    let affine = app.world().get::<GlobalTransform>(cloth).expect("a transform").affine();
    let mut world = shown(&app, cloth).clone();
    let points: Vec<[f32; 3]> = world_positions(&app, cloth).iter().map(Vec3::to_array).collect();
    world.insert_attribute(Mesh::ATTRIBUTE_POSITION, points);
    world.compute_area_weighted_normals();
    let to_world = affine.matrix3.inverse().transpose();
    for (n, expected) in vectors(shown(&app, cloth), Mesh::ATTRIBUTE_NORMAL).iter().zip(vectors(&world, Mesh::ATTRIBUTE_NORMAL))
    {
        let n = Vec3::from(to_world * Vec3A::from(*n)).normalize();
        assert!(n.distance(expected) < 2.0e-3, "{n} for {expected}");
    }
}

#[test]
fn tangents_lie_in_the_surface_and_keep_their_handedness() {
    let mut app = app();
    let mesh = sheet(10).with_generated_tangents().expect("tangents");
    let cloth = spawn(&mut app, mesh, border());
    run(&mut app, 1);
    run(&mut app, 60);
    let shown = shown(&app, cloth);
    let Ok(VertexAttributeValues::Float32x4(tangents)) = shown.try_attribute(Mesh::ATTRIBUTE_TANGENT) else {
        panic!("tangents are gone")
    };
    let regenerated = shown.clone().with_generated_tangents().expect("tangents");
    let Ok(VertexAttributeValues::Float32x4(expected)) = regenerated.try_attribute(Mesh::ATTRIBUTE_TANGENT) else {
        panic!("tangents are gone")
    };
    for ((t, n), e) in tangents.iter().zip(vectors(shown, Mesh::ATTRIBUTE_NORMAL)).zip(expected) {
        let (t, e) = (Vec4::from_array(*t), Vec4::from_array(*e));
        assert!(t.truncate().dot(n).abs() < 1.0e-3 && (t.truncate().length() - 1.0).abs() < 1.0e-3, "{t} on {n}");
        assert!(t.truncate().dot(e.truncate()) > 0.97 && t.w == e.w, "{t} for {e}");
    }
}

#[test]
fn every_other_attribute_is_untouched() {
    let mut app = app();
    let mut mesh = sheet(6);
    mesh.insert_attribute(Mesh::ATTRIBUTE_COLOR, (0..36).map(|i| [i as f32 / 36.0, 0.2, 0.3, 1.0]).collect::<Vec<_>>());
    let cloth = spawn(&mut app, mesh.clone(), border());
    run(&mut app, 30);
    let shown = shown(&app, cloth);
    for attribute in [Mesh::ATTRIBUTE_UV_0, Mesh::ATTRIBUTE_COLOR] {
        assert_eq!(shown.attribute(attribute), mesh.attribute(attribute), "{}", attribute.name);
    }
    assert_eq!(shown.indices(), mesh.indices());
    assert_eq!(shown.attributes().count(), mesh.attributes().count());
}

#[test]
fn bounds_hold_every_vertex_and_follow_it() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(8), Transform::from_scale(Vec3::splat(0.5)));
    for _ in 0..60 {
        run(&mut app, 1);
        let aabb = app.world().get::<Aabb>(cloth).expect("bounds");
        for p in positions(&app, cloth) {
            assert!(
                ((Vec3A::from(p) - aabb.center).abs() - aabb.half_extents).max_element() <= 0.0,
                "{p} is outside of {aabb:?}"
            );
        }
        assert!(aabb.half_extents.is_finite() && aabb.half_extents.max_element() < 1.0, "{aabb:?}");
    }
    assert!(app.world().get::<Aabb>(cloth).expect("bounds").center.y < -2.0);
}

#[test]
fn moving_the_entity_of_a_free_cloth_does_not_move_what_is_shown() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(8), ());
    run(&mut app, 10);
    let before = particles(&app, cloth);
    app.world_mut().get_mut::<Transform>(cloth).expect("a transform").translation.x += 0.5;
    run(&mut app, 1);
    let moved = before.iter().zip(particles(&app, cloth)).map(|(a, b)| (b - *a).x.abs()).fold(0.0, f32::max);
    assert!(moved < 0.01, "the world moved by {moved} m");
    let shown = world_positions(&app, cloth);
    let simulated = particles(&app, cloth);
    let far = shown.iter().map(|s| simulated.iter().map(|p| p.distance(*s)).fold(f32::INFINITY, f32::min)).fold(0.0, f32::max);
    assert!(far < 1.0e-4, "a vertex is shown {far} m from its particle");
}

#[test]
fn nothing_is_written_when_nothing_moves() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(4), ClothPins::where_position(|_| true));
    run(&mut app, 5);
    let mut cursor = app.world().resource::<Messages<AssetEvent<Mesh>>>().get_cursor_current();
    run(&mut app, 10);
    let written = cursor.read(app.world().resource::<Messages<AssetEvent<Mesh>>>()).count();
    assert_eq!(written, 0, "a cloth that is pinned everywhere was written");
    assert_eq!(status(&app, cloth), ClothStatus::Active);
}

#[test]
fn in_a_fixed_schedule_what_is_shown_lies_between_two_ticks() {
    let mut app = app_with(ClothPlugin::new(FixedPostUpdate));
    frame_length(&mut app, 1.0 / 200.0);
    let cloth = spawn(&mut app, sheet(5), ());
    run(&mut app, 40);
    let mut heights = Vec::new();
    for _ in 0..60 {
        run(&mut app, 1);
        heights.push(lowest(&world_positions(&app, cloth)));
    }
    let steps: Vec<f32> = heights.windows(2).map(|w| w[0] - w[1]).collect();
    let (least, most) = steps.iter().fold((f32::INFINITY, 0.0_f32), |(l, m), &s| (l.min(s), m.max(s)));
    assert!(least > 0.0, "it stood still for a frame: {steps:?}");
    assert!(most / least < 3.0, "it moves in jerks: {steps:?}");
}

#[test]
fn in_a_fixed_schedule_a_cloth_that_is_stopped_stands_still() {
    let mut app = app_with(ClothPlugin::new(FixedPostUpdate));
    frame_length(&mut app, 1.0 / 200.0);
    let cloth = spawn(&mut app, sheet(5), ());
    run(&mut app, 40);
    app.world_mut().get_mut::<ClothSolver>(cloth).expect("a solver").time_scale = 0.0;
    run(&mut app, 8);
    let still = positions(&app, cloth);
    for frame in 0..20 {
        run(&mut app, 1);
        assert_eq!(positions(&app, cloth), still, "frame {frame}");
    }
}
