//! Where a cloth is held, and by what.

use bevy::camera::visibility::{DynamicSkinnedMeshBounds, NoAutoAabb};
use bevy::ecs::entity_disabling::Disabled;
use bevy::mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes};
use bevy::mesh::{MeshVertexAttribute, VertexFormat};
use bevy::prelude::*;
use bevy_drape::prelude::*;
use bevy_drape::{ClothBuildReport, ClothError, ClothErrorKind, ClothParticles, ClothTargetLost, ClothWaitingFor};

use crate::common::*;
use crate::warnings::warnings;

const PIN: MeshVertexAttribute = MeshVertexAttribute::new("_PIN", 0x00d1_a9e0_0001, VertexFormat::Float32);

fn pinned(app: &App, entity: Entity) -> u32 {
    report(app, entity).pinned
}

#[test]
fn pins_past_the_end_are_ignored_listed_and_told_of_once() {
    let lines = warnings(app(), |app| {
        let pins = ClothPins::vertices([0, 4, 25, 4_000_000_000]);
        let cloth = spawn(app, sheet(5), (pins, Name::new("past the end")));
        run(app, 30);
        assert_eq!(status(app, cloth), ClothStatus::Active);
        assert_eq!(app.world().get::<ClothBuildReport>(cloth).expect("a cloth").bad_pins, [25, 4_000_000_000]);
        assert_eq!(pinned(app, cloth), 2);
    });
    let about: Vec<&String> = lines.iter().filter(|line| line.contains("past the end")).collect();
    assert_eq!(about.len(), 1, "{lines:?}");
    assert!(
        about[0].contains("vertex 25") && about[0].contains("(25 vertices") && about[0].contains("2 of its pins"),
        "{about:?}"
    );
}

#[test]
fn pins_by_index_place_colour_and_attribute_hold_the_same_corners() {
    let rest = vectors(&sheet(6), Mesh::ATTRIBUTE_POSITION);
    let corner = |p: &Vec3| p.x.abs() > 0.49 && p.z < -0.49;
    let held: Vec<u32> = (0..).zip(&rest).filter(|(_, p)| corner(p)).map(|(i, _)| i).collect();
    let one = |p: &Vec3| if corner(p) { 1.0 } else { 0.0 };
    let mut mesh = sheet(6);
    mesh.insert_attribute(Mesh::ATTRIBUTE_COLOR, rest.iter().map(|p| [0.0, one(p), 0.0, 1.0]).collect::<Vec<_>>());
    mesh.insert_attribute(PIN, rest.iter().map(one).collect::<Vec<_>>());
    let mut shapes = Vec::new();
    for pins in [
        ClothPins::vertices(held.clone()),
        ClothPins::weights(held.iter().map(|&i| (i, 1.0))),
        ClothPins::where_position(move |p| corner(&p)),
        ClothPins::color(ClothColorChannel::G),
        ClothPins::attribute("_PIN"),
        ClothPins::attribute("pin"),
    ] {
        let mut app = app();
        let cloth = spawn(&mut app, mesh.clone(), pins);
        run(&mut app, 60);
        assert_eq!(pinned(&app, cloth), 2);
        let now = world_positions(&app, cloth);
        for &i in &held {
            assert!(now[i as usize].distance(rest[i as usize]) < 1.0e-5, "vertex {i} is at {}", now[i as usize]);
        }
        shapes.push(now);
    }
    assert!(shapes.iter().all(|s| *s == shapes[0]));
}

#[test]
fn pins_that_name_what_the_mesh_does_not_have_say_so() {
    for pins in [ClothPins::color(ClothColorChannel::R), ClothPins::attribute("_NOWHERE")] {
        let mut app = app();
        let cloth = spawn(&mut app, sheet(5), pins);
        run(&mut app, 3);
        let error = app.world().get::<ClothError>(cloth).expect("an error");
        assert_eq!(error.kind, ClothErrorKind::NoPinAttribute, "{error}");
        *app.world_mut().get_mut::<ClothPins>(cloth).expect("pins") = ClothPins::vertices([0]);
        run(&mut app, 3);
        assert_eq!(status(&app, cloth), ClothStatus::Active, "it lifts itself");
    }
}

#[test]
fn a_weight_between_gives_way() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(6), ClothPins::vertices([0, 5]).and(ClothPins::vertices([30, 35]).weighted(0.2)));
    run(&mut app, 120);
    assert_eq!(pinned(&app, cloth), 4);
    let rest = vectors(&sheet(6), Mesh::ATTRIBUTE_POSITION);
    let now = world_positions(&app, cloth);
    assert!(now[0].distance(rest[0]) < 1.0e-5 && now[5].distance(rest[5]) < 1.0e-5);
    let given = [30, 35].map(|i: usize| now[i].distance(rest[i]));
    assert!(given.iter().all(|way| (0.01..0.9).contains(way)), "{given:?} m: neither firm nor let go");
}

#[test]
fn a_set_that_is_held_more_firmly_is_drawn_there_and_not_thrown() {
    let mut app = app();
    let pins = |weight| ClothPins::vertices([0, 5]).and(ClothPins::vertices([30, 35]).weighted(weight));
    let cloth = spawn(&mut app, sheet(6), pins(0.05));
    run(&mut app, 120);
    let rest = vectors(&sheet(6), Mesh::ATTRIBUTE_POSITION);
    let off = |app: &App| world_positions(app, cloth)[30].distance(rest[30]);
    let start = off(&app);
    assert!(start > 0.1, "{start} m: it does not sag");
    *app.world_mut().get_mut::<ClothPins>(cloth).expect("pins") = pins(1.0);
    let mut last = start;
    for frame in 0..30 {
        run(&mut app, 1);
        let now = off(&app);
        assert!(last - now < 0.35 * start, "frame {frame}: from {last} to {now} m");
        last = now;
    }
    assert!(last < 1.0e-5, "{last} m from where it is held");
    assert_eq!(pinned(&app, cloth), 4);
}

#[test]
fn pinned_vertices_follow_an_anchor_at_twenty_metres_a_second_without_lag() {
    let mut app = app();
    let hand = app.world_mut().spawn(Transform::from_xyz(0.0, 1.0, 0.0)).id();
    let cloth = spawn(&mut app, sheet(8), border().to(hand));
    run(&mut app, 5);
    let rest = vectors(&sheet(8), Mesh::ATTRIBUTE_POSITION);
    for i in 1..120 {
        let way = Vec3::new(20.0 * FRAME * i as f32, 0.0, 0.0);
        app.world_mut().get_mut::<Transform>(hand).expect("a transform").translation = Vec3::Y + way;
        run(&mut app, 1);
        let now = world_positions(&app, cloth);
        for (p, now) in rest.iter().zip(&now).filter(|(p, _)| p.z < -0.499) {
            assert!((*p + way).distance(*now) < 1.0e-4, "frame {i}: {now} for {}", *p + way);
        }
    }
    assert!(report(&app, cloth).worst_edge < 1.2, "{:?}", report(&app, cloth));
}

#[test]
fn a_target_turns_and_scales_what_it_holds() {
    let mut app = app();
    let hand = app.world_mut().spawn(Transform::from_xyz(0.0, 0.0, -0.5)).id();
    let cloth = spawn(&mut app, sheet(5), border().to(hand));
    run(&mut app, 5);
    for i in 1..=40 {
        app.world_mut().get_mut::<Transform>(hand).expect("a transform").rotation = Quat::from_rotation_y(0.02 * i as f32);
        run(&mut app, 1);
    }
    let turn = Quat::from_rotation_y(0.8);
    let rest = vectors(&sheet(5), Mesh::ATTRIBUTE_POSITION);
    let now = world_positions(&app, cloth);
    for (p, now) in rest.iter().zip(&now).filter(|(p, _)| p.z < -0.499) {
        let expected = turn * (*p - Vec3::new(0.0, 0.0, -0.5)) + Vec3::new(0.0, 0.0, -0.5);
        assert!(expected.distance(*now) < 1.0e-4, "{now} for {expected}");
    }
}

#[test]
fn a_target_that_is_gone_holds_releases_or_despawns() {
    for reaction in [ClothOnTargetLost::Hold, ClothOnTargetLost::Release, ClothOnTargetLost::Despawn] {
        let mut app = app();
        record::<ClothTargetLost>(&mut app);
        let hand = app.world_mut().spawn(Transform::default()).id();
        let cloth = spawn(&mut app, sheet(6), border().to(hand).on_target_lost(reaction));
        run(&mut app, 30);
        app.world_mut().despawn(hand);
        run(&mut app, 60);
        assert_eq!(seen::<ClothTargetLost>(&app).len(), 1, "{reaction:?}: told once");
        let alive = app.world().get_entity(cloth).is_ok();
        assert_eq!(alive, reaction != ClothOnTargetLost::Despawn, "{reaction:?}");
        if alive {
            assert_eq!(pinned(&app, cloth), if reaction == ClothOnTargetLost::Hold { 6 } else { 0 }, "{reaction:?}");
            let top = world_positions(&app, cloth).iter().map(|p| p.y).fold(f32::NEG_INFINITY, f32::max);
            assert_eq!(top > -0.01, reaction == ClothOnTargetLost::Hold, "{reaction:?}: highest at {top}");
            assert!(finite(&app, cloth));
        }
    }
}

#[test]
fn a_target_that_is_not_there_yet_is_waited_for() {
    let mut app = app();
    let hand = app.world_mut().spawn_empty().id();
    let cloth = spawn(&mut app, sheet(6), border().to(hand));
    run(&mut app, 5);
    assert_eq!(status(&app, cloth), ClothStatus::Waiting(ClothWaitingFor::Target));
    app.world_mut().entity_mut(hand).insert(Transform::default());
    run(&mut app, 5);
    assert_eq!(status(&app, cloth), ClothStatus::Active);
}

#[test]
fn pins_can_change_while_it_moves_and_hold_what_they_find() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(6), ClothPins::NONE);
    run(&mut app, 20);
    let before = world_positions(&app, cloth);
    *app.world_mut().get_mut::<ClothPins>(cloth).expect("pins") = ClothPins::vertices([0]);
    run(&mut app, 60);
    let now = world_positions(&app, cloth);
    assert!(now[0].distance(before[0]) < 0.2, "held at {}, was at {}", now[0], before[0]);
    *app.world_mut().get_mut::<ClothPins>(cloth).expect("pins") = ClothPins::NONE;
    run(&mut app, 60);
    assert!(lowest(&world_positions(&app, cloth)) < -3.0, "it falls again");
}

#[test]
fn pins_do_not_move_when_the_mesh_is_reloaded() {
    let mut app = app();
    let hand = app.world_mut().spawn(Transform::default()).id();
    let source = add(&mut app, sheet(6));
    let cloth = app.world_mut().spawn((Mesh3d(source.clone()), Cloth, border().to(hand))).id();
    run(&mut app, 5);
    app.world_mut().get_mut::<Transform>(hand).expect("a transform").translation = Vec3::new(0.5, 0.5, 0.0);
    run(&mut app, 20);
    let held = |app: &App| -> Vec<Vec3> {
        let rest = vectors(&sheet(6), Mesh::ATTRIBUTE_POSITION);
        world_positions(app, cloth).into_iter().zip(rest).filter(|(_, p)| p.z < -0.499).map(|(now, _)| now).collect()
    };
    let before = held(&app);
    *app.world_mut().resource_mut::<Assets<Mesh>>().get_mut(&source).expect("the mesh") = sheet(6);
    run(&mut app, 20);
    for (a, b) in before.iter().zip(held(&app)) {
        assert!(a.distance(b) < 1.0e-4, "{a} is at {b} after the reload");
    }
}

/// A sheet that hangs on two joints, both at the origin, by half each.
fn skinned(app: &mut App, extra: impl Bundle) -> (Entity, Vec<Entity>) {
    let mut mesh = sheet(6);
    let count = mesh.count_vertices();
    mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, bevy::mesh::VertexAttributeValues::Uint16x4(vec![[0, 1, 0, 0]; count]));
    mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, vec![[0.5, 0.5, 0.0, 0.0]; count]);
    let joints: Vec<Entity> = (0..2).map(|_| app.world_mut().spawn(Transform::default()).id()).collect();
    let inverse_bindposes = app
        .world_mut()
        .resource_mut::<Assets<SkinnedMeshInverseBindposes>>()
        .add(SkinnedMeshInverseBindposes::from(vec![Mat4::IDENTITY; 2]));
    let skin = SkinnedMesh { inverse_bindposes, joints: joints.clone() };
    (spawn(app, mesh, (border(), skin, extra)), joints)
}

#[test]
fn a_clone_of_a_skinned_cloth_has_its_skin() {
    let mut app = app();
    let (cloth, joints) = skinned(&mut app, DynamicSkinnedMeshBounds);
    run(&mut app, 5);
    let clone = app.world_mut().entity_mut(cloth).clone_and_spawn();
    run(&mut app, 5);
    assert_eq!(status(&app, clone), ClothStatus::Active);
    for _ in 0..50 {
        app.world_mut().get_mut::<Transform>(joints[0]).expect("a joint").translation.y += 0.02;
        run(&mut app, 1);
    }
    let held = |app: &App, cloth| world_positions(app, cloth).into_iter().filter(|p| p.y > 0.499).count();
    assert_eq!((held(&app, cloth), held(&app, clone)), (6, 6));
    for cloth in [clone, cloth] {
        app.world_mut().entity_mut(cloth).remove::<Cloth>();
        run(&mut app, 1);
        let entity = app.world().entity(cloth);
        assert!(entity.contains::<SkinnedMesh>() && entity.contains::<DynamicSkinnedMeshBounds>(), "the skin comes back");
        assert!(!entity.contains::<NoAutoAabb>(), "its bounds are its own again");
        assert!(shown(&app, cloth).contains_attribute(Mesh::ATTRIBUTE_JOINT_INDEX));
    }
}

#[test]
fn a_disabled_cloth_gets_its_mesh_and_skin_back() {
    let mut app = app();
    let (cloth, _) = skinned(&mut app, ());
    let authored = app.world().get::<Mesh3d>(cloth).expect("a mesh").0.id();
    run(&mut app, 5);
    app.world_mut().entity_mut(cloth).insert(Disabled);
    run(&mut app, 1);
    app.world_mut().entity_mut(cloth).remove::<Cloth>();
    run(&mut app, 1);
    let entity = app.world().entity(cloth);
    assert_eq!(entity.get::<Mesh3d>().expect("a mesh").0.id(), authored);
    assert!(entity.contains::<SkinnedMesh>() && !entity.contains::<NoAutoAabb>() && !entity.contains::<ClothParticles>());
}

#[test]
fn a_skinned_mesh_is_simulated_in_place_of_being_skinned_and_its_pins_follow_the_skin() {
    let mut app = app();
    let rest = vectors(&sheet(6), Mesh::ATTRIBUTE_POSITION);
    let (cloth, joints) = skinned(&mut app, ());
    run(&mut app, 5);
    assert_eq!(status(&app, cloth), ClothStatus::Active);
    assert!(app.world().get::<SkinnedMesh>(cloth).is_none(), "it would be skinned twice");
    assert!(!shown(&app, cloth).contains_attribute(Mesh::ATTRIBUTE_JOINT_INDEX));
    for i in 1..=50 {
        app.world_mut().get_mut::<Transform>(joints[1]).expect("a joint").translation.y = 0.02 * i as f32;
        run(&mut app, 1);
    }
    let now = world_positions(&app, cloth);
    for (p, now) in rest.iter().zip(&now).filter(|(p, _)| p.z < -0.499) {
        assert!((*p + Vec3::Y * 0.5).distance(*now) < 1.0e-4, "{now} for {}", *p + Vec3::Y * 0.5);
    }
    app.world_mut().entity_mut(cloth).remove::<Cloth>();
    run(&mut app, 1);
    assert!(app.world().get::<SkinnedMesh>(cloth).is_some(), "the skin comes back");
    assert!(shown(&app, cloth).contains_attribute(Mesh::ATTRIBUTE_JOINT_INDEX));
}

#[test]
fn a_pinned_sheet_that_is_turned_is_not_dragged_into_place_in_its_first_frame() {
    use core::f32::consts::FRAC_PI_2;
    for turn in [Quat::from_rotation_y(FRAC_PI_2), Quat::from_rotation_x(FRAC_PI_2), Quat::from_rotation_z(2.0)] {
        let mut app = app();
        let at = Transform { translation: Vec3::new(3.0, 1.0, -2.0), rotation: turn, ..default() };
        let cloth = spawn(&mut app, sheet(16), (border(), at));
        run(&mut app, 1);
        assert!(report(&app, cloth).worst_edge < 1.05, "{turn}: {:?}", report(&app, cloth));
        let rest = vectors(&sheet(16), Mesh::ATTRIBUTE_POSITION);
        for (p, now) in rest.iter().zip(world_positions(&app, cloth)).filter(|(p, _)| p.z < -0.499) {
            assert!(at.transform_point(*p).distance(now) < 1.0e-4, "{turn}: {now} for {}", at.transform_point(*p));
        }
    }
}

#[test]
fn pins_that_change_while_the_cloth_has_to_wait_are_not_forgotten() {
    let mut app = app();
    let hand = app.world_mut().spawn_empty().id();
    let cloth = spawn(&mut app, sheet(6), border());
    run(&mut app, 10);
    *app.world_mut().get_mut::<ClothPins>(cloth).expect("pins") = ClothPins::vertices([0]).to(hand);
    run(&mut app, 5);
    assert_eq!(status(&app, cloth), ClothStatus::Waiting(ClothWaitingFor::Target));
    app.world_mut().entity_mut(hand).insert(Transform::default());
    run(&mut app, 5);
    assert_eq!((status(&app, cloth), pinned(&app, cloth)), (ClothStatus::Active, 1));

    app.world_mut().get_mut::<Transform>(cloth).expect("a transform").scale = Vec3::ZERO;
    *app.world_mut().get_mut::<ClothPins>(cloth).expect("pins") = ClothPins::vertices([0, 5]);
    run(&mut app, 5);
    assert_eq!(status(&app, cloth), ClothStatus::Waiting(ClothWaitingFor::Transform));
    app.world_mut().get_mut::<Transform>(cloth).expect("a transform").scale = Vec3::ONE;
    run(&mut app, 5);
    assert_eq!((status(&app, cloth), pinned(&app, cloth)), (ClothStatus::Active, 2));
}

#[test]
fn pin_sets_that_change_places_or_targets_do_not_drag_what_they_hold() {
    let mut app = app();
    let [a, b] = [-1.0, 1.0].map(|x| app.world_mut().spawn(Transform::from_xyz(x, 1.0, 0.0)).id());
    let (first, second) = (|| ClothPins::vertices([0]), || ClothPins::vertices([5]));
    let cloth = spawn(&mut app, sheet(6), first().to(a).and(second().to(b)));
    run(&mut app, 10);
    for _ in 0..20 {
        app.world_mut().get_mut::<Transform>(a).expect("a transform").translation += Vec3::new(0.005, 0.01, 0.0);
        app.world_mut().get_mut::<Transform>(b).expect("a transform").translation += Vec3::new(-0.005, 0.01, 0.005);
        run(&mut app, 1);
    }
    let before = world_positions(&app, cloth);
    let (swapped, reordered) = (first().to(b).and(second().to(a)), second().to(a).and(first().to(b)));
    for pins in [swapped, reordered, second().and(first().to(b)), first().and(second())] {
        *app.world_mut().get_mut::<ClothPins>(cloth).expect("pins") = pins;
        run(&mut app, 5);
        let now = world_positions(&app, cloth);
        for v in [0, 5] {
            assert!(before[v].distance(now[v]) < 1.0e-4, "vertex {v} was at {} and is at {}", before[v], now[v]);
        }
    }
}

#[test]
fn a_skinned_cloth_whose_first_joint_breaks_or_goes_stays_where_the_joint_was() {
    let mut app = app();
    let mut mesh = sheet(6);
    mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, bevy::mesh::VertexAttributeValues::Uint16x4(vec![[0, 1, 0, 0]; 36]));
    mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, vec![[0.5, 0.5, 0.0, 0.0]; 36]);
    let joints: Vec<Entity> = (0..2).map(|_| app.world_mut().spawn(Transform::from_xyz(0.0, 1.0, 0.0)).id()).collect();
    let inverse_bindposes = app
        .world_mut()
        .resource_mut::<Assets<SkinnedMeshInverseBindposes>>()
        .add(SkinnedMeshInverseBindposes::from(vec![Mat4::IDENTITY; 2]));
    let skin = SkinnedMesh { inverse_bindposes, joints: joints.clone() };
    let cloth = spawn(&mut app, mesh, (border(), skin));
    run(&mut app, 30);
    let before = world_positions(&app, cloth);
    let held = |app: &App| {
        assert_eq!(status(app, cloth), ClothStatus::Active);
        let now = world_positions(app, cloth);
        assert!(before[0].distance(now[0]) < 1.0e-4 && finite(app, cloth), "{} was at {}", now[0], before[0]);
    };
    app.world_mut().get_mut::<Transform>(joints[0]).expect("a joint").translation = Vec3::NAN;
    run(&mut app, 5);
    held(&app);
    app.world_mut().despawn(joints[0]);
    run(&mut app, 5);
    held(&app);
    // Pins that change meanwhile are bound with the last matrices.
    *app.world_mut().get_mut::<ClothPins>(cloth).expect("pins") = ClothPins::vertices([0, 5]);
    run(&mut app, 30);
    held(&app);
    assert_eq!(pinned(&app, cloth), 2);
}
