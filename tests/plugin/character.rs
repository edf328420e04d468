//! Colliders for the bones of skinned bodies.

use bevy::asset::RenderAssetUsages;
use bevy::mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes};
use bevy::mesh::{PrimitiveTopology, VertexAttributeValues};
use bevy::prelude::*;
use bevy_drape::prelude::*;

use crate::common::*;
use crate::warnings::warnings;

/// Length of each of the two parts of a leg [m].
const PART: f32 = 0.5;
/// How far cloth that is pushed may sink into a part [m].
const SUNK: f32 = 1.0e-2;
/// How far an end of a capsule may lie from where the tube ends less the radius [m]: refinement moves it by half the radius.
const SHIFT: f32 = 0.07;

/// A leg along x: tubes of `radius` around the joints in `parts`, the thigh (0) and the calf (1). Lengths in units of 1 /
/// `scale` metres.
fn leg(radius: f32, scale: f32, parts: &[u16]) -> Mesh {
    let (mut positions, mut joints) = (Vec::new(), Vec::new());
    for &part in parts {
        for ring in 0..=20 {
            for corner in 0..16 {
                let turn = corner as f32 / 16.0 * core::f32::consts::TAU;
                let x = PART * (f32::from(part) + ring as f32 / 20.0);
                positions.push((Vec3::new(x, radius * turn.cos(), radius * turn.sin()) * scale).to_array());
                joints.push([part, 0, 0, 0]);
            }
        }
    }
    let weights = vec![[1.0, 0.0, 0.0, 0.0]; positions.len()];
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, VertexAttributeValues::Uint16x4(joints))
        .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, weights)
}

/// A skeleton of two joints, the second below the first, in units of 1 / `scale` metres.
fn skeleton(app: &mut App, scale: f32) -> SkinnedMesh {
    let small = Transform::from_scale(Vec3::splat(1.0 / scale));
    let thigh = app.world_mut().spawn((Name::new("thigh"), small)).id();
    let place = Transform::from_xyz(PART * scale, 0.0, 0.0);
    let calf = app.world_mut().spawn((Name::new("calf"), place, ChildOf(thigh))).id();
    let binds = vec![Mat4::IDENTITY, Mat4::from_translation(Vec3::X * -PART * scale)];
    let inverse_bindposes =
        app.world_mut().resource_mut::<Assets<SkinnedMeshInverseBindposes>>().add(SkinnedMeshInverseBindposes::from(binds));
    SkinnedMesh { inverse_bindposes, joints: vec![thigh, calf] }
}

/// A leg of 0.1 m radius that cloth drapes over, and its joints.
fn body(app: &mut App, extra: impl Bundle) -> (Entity, Vec<Entity>) {
    let mesh = add(app, leg(0.1, 1.0, &[0, 1]));
    let skin = skeleton(app, 1.0);
    let joints = skin.joints.clone();
    (app.world_mut().spawn((Mesh3d(mesh), skin, ClothBody::default(), extra)).id(), joints)
}

/// Lines about one of the entities of these names. Systems of other tests may borrow this thread and warn, too.
fn about(lines: &[String], names: &[&str]) -> Vec<String> {
    lines.iter().filter(|line| names.iter().any(|name| line.contains(name))).cloned().collect()
}

/// Names of all colliders and their entities, by name.
fn colliders(app: &mut App) -> Vec<(String, Entity)> {
    let mut query = app.world_mut().query_filtered::<(Entity, &Name), With<ClothCollider>>();
    let mut all: Vec<_> = query.iter(app.world()).map(|(entity, name)| (name.to_string(), entity)).collect();
    all.sort();
    all
}

fn names(app: &mut App) -> Vec<String> {
    colliders(app).into_iter().map(|(name, _)| name).collect()
}

/// Ends [m] and radius [m] of a capsule in the world.
fn capsule(app: &App, collider: Entity) -> (Vec3, Vec3, f32) {
    let shape = &app.world().get::<ClothCollider>(collider).expect("a collider").shape;
    let ClothColliderShape::Capsule { radius, length } = *shape else { panic!("{shape:?}") };
    let global = app.world().get::<GlobalTransform>(collider).expect("a transform");
    let [a, b] = [-0.5, 0.5].map(|side| global.transform_point(Vec3::Y * side * length));
    (a, b, radius * global.scale().max_element())
}

#[test]
fn each_part_of_a_body_gets_a_collider_under_its_joint() {
    let mut app = app();
    let layers = ClothCollisionLayers::new(0b10, 0b01);
    let settings = ClothBody { margin: 0.02, static_friction: 0.3, dynamic_friction: 0.2 };
    let (body, joints) = body(&mut app, layers);
    app.world_mut().entity_mut(body).insert(settings);
    run(&mut app, 1);
    assert_eq!(names(&mut app), ["calf collider", "thigh collider"]);
    let all = colliders(&mut app);
    for (joint, (_, collider)) in [(1, all[0].clone()), (0, all[1].clone())] {
        let start = Vec3::X * PART * joint as f32;
        let (a, b, radius) = capsule(&app, collider);
        let ends = [start + Vec3::X * radius, start + Vec3::X * (PART - radius)];
        assert!((0.08..0.12).contains(&radius), "joint {joint}: radius {radius} m");
        assert!(a.distance(ends[0]) < SHIFT && b.distance(ends[1]) < SHIFT, "joint {joint}: from {a} to {b}, not {ends:?}");
        let entity = app.world().entity(collider);
        assert_eq!(entity.get::<ChildOf>().map(ChildOf::parent), Some(joints[joint]));
        assert_eq!(entity.get::<ClothCollisionLayers>(), Some(&layers));
        assert_eq!(entity.get::<Transform>().map(|place| place.scale), Some(Vec3::ONE));
        let made = entity.get::<ClothCollider>().expect("a collider");
        assert_eq!((made.static_friction, made.dynamic_friction), (0.3, 0.2));
        assert!((0.02..0.06).contains(&made.margin), "joint {joint}: margin {} m", made.margin);
    }
}

#[test]
fn colliders_have_the_layers_of_their_joint_or_one_above_or_those_of_the_body() {
    let mut app = app();
    let [own, of_calf, of_thigh] = [1, 2, 3].map(|layer| ClothCollisionLayers::new(1 << layer, u32::MAX));
    let (_, joints) = body(&mut app, own);
    let [thigh, calf] = [joints[0], joints[1]];
    let layers = |app: &mut App| {
        run(app, 2);
        let all = colliders(app);
        assert_eq!(all.len(), 2, "{all:?}");
        [1, 0].map(|k| app.world().get::<ClothCollisionLayers>(all[k].1).copied())
    };
    assert_eq!(layers(&mut app), [Some(own); 2]);
    app.world_mut().entity_mut(calf).insert(of_calf);
    assert_eq!(layers(&mut app), [Some(own), Some(of_calf)]);
    app.world_mut().entity_mut(thigh).insert(of_thigh);
    assert_eq!(layers(&mut app), [Some(of_thigh), Some(of_calf)]);
    app.world_mut().entity_mut(calf).remove::<ClothCollisionLayers>();
    assert_eq!(layers(&mut app), [Some(of_thigh); 2]);
    app.world_mut().entity_mut(thigh).remove::<ClothCollisionLayers>();
    assert_eq!(layers(&mut app), [Some(own); 2]);
}

#[test]
fn a_collider_goes_where_its_joint_turns_and_pushes_the_cloth() {
    let mut app = app();
    app.insert_resource(ClothGravity(Vec3::ZERO));
    let alone = ClothCollision { self_collision: false, ..default() };
    let cloth = spawn(&mut app, sheet(20), (alone, Transform::from_xyz(0.5, 0.3, 0.0)));
    let (_, joints) = body(&mut app, ());
    run(&mut app, 3);
    assert_eq!(report(&app, cloth).bodies, 2);
    let height = |app: &App| particles(app, cloth).iter().map(|p| p.y).fold(f32::MIN, f32::max);
    assert!((height(&app) - 0.3).abs() < 1.0e-3, "nothing has touched it: {} m", height(&app));
    let angle = |frame: usize| 1.4 * frame as f32 / 60.0;
    let calf = colliders(&mut app)[0].1;
    for frame in 1..=60 {
        app.world_mut().get_mut::<Transform>(joints[1]).expect("a joint").rotation = Quat::from_rotation_z(angle(frame));
        run(&mut app, 1);
        let (a, b, radius) = capsule(&app, calf);
        for p in particles(&app, cloth) {
            let along = b - a;
            let nearest = a + along * ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
            assert!(p.distance(nearest) > radius - SUNK, "frame {frame}: {p} is {} m from the axis", p.distance(nearest));
        }
    }
    let (_, tip, radius) = capsule(&app, calf);
    let expected = Vec3::X * PART + Quat::from_rotation_z(angle(60)) * Vec3::X * (PART - radius);
    assert!(tip.distance(expected) < SHIFT, "the tip is at {tip}, not {expected}");
    assert!(height(&app) > 0.4, "pushed to {} m", height(&app));
}

#[test]
fn colliders_go_with_the_component_and_with_the_body() {
    let mut app = app();
    let (body, _) = body(&mut app, ());
    run(&mut app, 2);
    for _ in 0..2 {
        assert_eq!(names(&mut app).len(), 2);
        app.world_mut().entity_mut(body).remove::<ClothBody>();
        assert_eq!(names(&mut app).len(), 0, "removed");
        run(&mut app, 2);
        assert_eq!(names(&mut app).len(), 0, "removed");
        app.world_mut().entity_mut(body).insert(ClothBody::default());
        run(&mut app, 2);
    }
    app.world_mut().despawn(body);
    assert_eq!(names(&mut app).len(), 0, "despawned");
    run(&mut app, 2);
    assert_eq!(names(&mut app).len(), 0, "despawned");
}

#[test]
fn a_joint_takes_its_colliders_along_and_the_rest_is_fitted_without_it() {
    let lines = warnings(app(), |app| {
        let cloth = spawn(app, sheet(5), border());
        let (body, joints) = body(app, Name::new("amputee"));
        run(app, 2);
        app.world_mut().despawn(joints[1]);
        run(app, 2);
        assert_eq!(names(app), ["thigh collider"]);
        app.world_mut().get_mut::<ClothBody>(body).expect("a body").margin = 0.03;
        run(app, 2);
        assert_eq!(names(app), ["thigh collider"]);
        app.world_mut().despawn(joints[0]);
        run(app, 2);
        assert_eq!(names(app).len(), 0);
        app.world_mut().get_mut::<ClothBody>(body).expect("a body").margin = 0.02;
        run(app, 20);
        app.world_mut().despawn(body);
        run(app, 2);
        assert!(finite(app, cloth));
    });
    assert_eq!(about(&lines, &["`amputee`", "FittedTo"]), Vec::<String>::new());
}

#[test]
fn what_a_user_edits_or_despawns_stays_so_until_the_body_changes() {
    let mut app = app();
    let (body, _) = body(&mut app, ());
    run(&mut app, 2);
    let all = colliders(&mut app);
    app.world_mut().despawn(all[0].1);
    *app.world_mut().get_mut::<ClothCollider>(all[1].1).expect("a collider") = ClothCollider::ball(0.3);
    run(&mut app, 5);
    assert_eq!(colliders(&mut app), [all[1].clone()]);
    assert_eq!(app.world().get::<ClothCollider>(all[1].1), Some(&ClothCollider::ball(0.3)));
    app.world_mut().get_mut::<ClothBody>(body).expect("a body").margin = 0.03;
    run(&mut app, 2);
    assert_eq!(colliders(&mut app), [all[1].clone()]);
    let edited = app.world().get::<ClothCollider>(all[1].1).expect("a collider");
    assert_eq!((&edited.shape, edited.margin), (&ClothCollider::ball(0.3).shape, 0.03));
    let other = add(&mut app, leg(0.1, 1.0, &[0, 1]));
    app.world_mut().entity_mut(body).insert(Mesh3d(other));
    run(&mut app, 2);
    let anew = colliders(&mut app);
    assert_eq!(names(&mut app), ["calf collider", "thigh collider"]);
    assert!(anew.iter().all(|collider| !all.contains(collider)), "{anew:?}");
}

#[test]
fn settings_of_a_body_change_its_colliders_and_cloth_keeps_its_hold() {
    let mut app = app();
    let (body, _) = body(&mut app, ());
    let cloth = spawn(&mut app, sheet(16), (ClothSleepDisabled, Transform::from_xyz(0.5, 0.2, 0.0)));
    run(&mut app, 600);
    let (all, before) = (colliders(&mut app), positions(&app, cloth));
    let touching = report(&app, cloth).body_contacts;
    assert!(touching > 20, "{touching} contacts with the leg");
    for frame in 0..120_u32 {
        let mut settings = app.world_mut().get_mut::<ClothBody>(body).expect("a body");
        let share = frame as f32 / 119.0;
        (settings.margin, settings.static_friction) = (0.015 + 0.005 * share, 0.5 + 0.5 * share);
        run(&mut app, 1);
        assert_eq!(colliders(&mut app), all);
        let still = report(&app, cloth).body_contacts;
        assert!(2 * still > touching, "frame {frame}: {still} contacts of {touching}");
    }
    let made = app.world().get::<ClothCollider>(all[0].1).expect("a collider");
    assert!((made.margin - 0.02).abs() < 1.0e-6 && made.static_friction == 1.0, "{made:?}");
    let after = positions(&app, cloth);
    let farthest = before.iter().zip(&after).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    assert!((0.003..0.02).contains(&farthest), "{farthest} m");
}

#[test]
fn another_mesh_and_a_mesh_that_changes_are_fitted_anew() {
    let mut app = app();
    let (body, _) = body(&mut app, ());
    run(&mut app, 3);
    let radius = |app: &mut App| {
        let all = colliders(app);
        assert_eq!(all.len(), 2);
        capsule(app, all[1].1).2
    };
    let first = radius(&mut app);
    let thin = add(&mut app, leg(0.05, 1.0, &[0, 1]));
    app.world_mut().entity_mut(body).insert(Mesh3d(thin.clone()));
    run(&mut app, 2);
    let second = radius(&mut app);
    *app.world_mut().resource_mut::<Assets<Mesh>>().get_mut(&thin).expect("the mesh") = leg(0.15, 1.0, &[0, 1]);
    run(&mut app, 3);
    let third = radius(&mut app);
    assert!(second < 0.7 * first && third > 1.2 * first, "{first} {second} {third} m");
}

#[test]
fn a_mesh_that_comes_late_is_waited_for() {
    let lines = warnings(app(), |app| {
        let cloth = spawn(app, sheet(5), border());
        let late = app.world().resource::<Assets<Mesh>>().reserve_handle();
        let skin = skeleton(app, 1.0);
        app.world_mut().spawn((Mesh3d(late.clone()), skin, ClothBody::default(), Name::new("latecomer")));
        run(app, 30);
        assert_eq!(report(app, cloth).bodies, 0);
        app.world_mut().resource_mut::<Assets<Mesh>>().insert(late.id(), leg(0.1, 1.0, &[0, 1])).expect("a live handle");
        run(app, 2);
        assert_eq!(report(app, cloth).bodies, 2);
    });
    assert_eq!(about(&lines, &["`latecomer`"]), Vec::<String>::new());
}

#[test]
fn bodies_with_one_skeleton_are_fitted_as_one() {
    let mut app = app();
    let skin = skeleton(&mut app, 1.0);
    let spawn = |app: &mut App, parts: &[u16]| {
        let mesh = add(app, leg(0.1, 1.0, parts));
        app.world_mut().spawn((Mesh3d(mesh), skin.clone(), ClothBody::default())).id()
    };
    let thigh = spawn(&mut app, &[0]);
    run(&mut app, 2);
    assert_eq!(names(&mut app), ["thigh collider"]);
    let calf = spawn(&mut app, &[1]);
    let whole = spawn(&mut app, &[0, 1]);
    run(&mut app, 2);
    assert_eq!(names(&mut app), ["calf collider", "thigh collider"]);
    app.world_mut().despawn(whole);
    run(&mut app, 2);
    assert_eq!(names(&mut app), ["calf collider", "thigh collider"]);
    app.world_mut().entity_mut(thigh).remove::<ClothBody>();
    run(&mut app, 2);
    assert_eq!(names(&mut app), ["calf collider"]);
    app.world_mut().entity_mut(thigh).insert(ClothBody::default());
    run(&mut app, 2);
    assert_eq!(names(&mut app), ["calf collider", "thigh collider"]);
    // What is set otherwise is another body.
    app.world_mut().entity_mut(thigh).insert(ClothCollisionLayers::new(0b10, 0b10));
    run(&mut app, 2);
    let with_layers =
        colliders(&mut app).iter().filter(|(_, c)| app.world().entity(*c).contains::<ClothCollisionLayers>()).count();
    assert_eq!((names(&mut app).len(), with_layers), (2, 1));
    for body in [thigh, calf] {
        app.world_mut().despawn(body);
        run(&mut app, 2);
    }
    assert_eq!(names(&mut app).len(), 0);
}

#[test]
fn a_clone_shares_the_colliders_of_shared_joints_and_has_its_own_on_its_own_joints() {
    let mut app = app();
    let (first, _) = body(&mut app, ());
    run(&mut app, 2);
    let clone = app.world_mut().entity_mut(first).clone_and_spawn();
    run(&mut app, 3);
    assert_eq!(names(&mut app).len(), 2, "two on a joint would be one too many");
    let skin = skeleton(&mut app, 1.0);
    app.world_mut().entity_mut(clone).insert(skin);
    run(&mut app, 2);
    assert_eq!(names(&mut app).len(), 4);
    app.world_mut().despawn(first);
    run(&mut app, 2);
    assert_eq!(names(&mut app), ["calf collider", "thigh collider"]);
}

#[test]
fn a_body_in_centimetres_has_the_same_size() {
    let mut app = app();
    let mesh = add(&mut app, leg(0.1, 100.0, &[0, 1]));
    let skin = skeleton(&mut app, 100.0);
    app.world_mut().spawn((Mesh3d(mesh), skin, ClothBody::default()));
    run(&mut app, 2);
    let all = colliders(&mut app);
    assert_eq!(all.len(), 2);
    let (a, b, radius) = capsule(&app, all[0].1);
    assert!((0.08..0.12).contains(&radius) && a.x > PART && (0.2..0.5).contains(&a.distance(b)), "{radius} m from {a} to {b}");
    let margin = app.world().get::<ClothCollider>(all[0].1).expect("a collider").margin;
    assert!((0.015..0.06).contains(&margin), "{margin} m");
}

#[test]
fn a_body_without_joints_or_to_be_a_cloth_is_one_warning_with_name_and_cure() {
    let lines = warnings(app(), |app| {
        let skin = skeleton(app, 1.0);
        let bare = add(app, sheet(5));
        app.world_mut().spawn((Mesh3d(bare), skin.clone(), ClothBody::default(), Name::new("statue")));
        let mut gone = leg(0.1, 1.0, &[0, 1]);
        gone.asset_usage = RenderAssetUsages::RENDER_WORLD;
        let _ = gone.take_gpu_data();
        let gone = add(app, gone);
        app.world_mut().spawn((Mesh3d(gone), skin.clone(), ClothBody::default(), Name::new("ghost")));
        let mut light = leg(0.1, 1.0, &[0, 1]);
        light.insert_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, vec![[0.0_f32; 4]; light.count_vertices()]);
        let light = add(app, light);
        let own = skeleton(app, 1.0);
        app.world_mut().spawn((Mesh3d(light), own, ClothBody::default(), Name::new("feather")));
        let cape = add(app, sheet(5).with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, vec![[1.0_f32, 0.0, 0.0, 0.0]; 25]));
        app.world_mut().spawn((Mesh3d(cape), skin, Cloth, ClothBody::default(), Name::new("cape")));
        run(app, 100);
        assert_eq!(names(app).len(), 0);
    });
    for (name, cure) in [
        ("`statue`", "`Mesh::ATTRIBUTE_JOINT_INDEX`"),
        ("`ghost`", "`RenderAssetUsages::default()`"),
        ("`feather`", "weights above 0"),
        ("`cape`", "put `ClothBody` on the mesh that wears it"),
    ] {
        let of: Vec<_> = lines.iter().filter(|line| line.contains(name)).collect();
        assert!(of.len() == 1 && of[0].contains(cure), "{name} and {cure}: {lines:#?}");
    }
}

#[test]
fn a_body_that_lacks_something_is_one_warning_after_five_seconds() {
    let lines = |frames: usize| {
        warnings(app(), |app| {
            let mesh = add(app, leg(0.1, 1.0, &[0, 1]));
            app.world_mut().spawn((Mesh3d(mesh.clone()), ClothBody::default(), Name::new("plain")));
            let skin = skeleton(app, 1.0);
            app.world_mut().spawn((skin.clone(), ClothBody::default(), Name::new("bodiless")));
            let absent = SkinnedMesh { inverse_bindposes: Handle::default(), ..skin.clone() };
            app.world_mut().spawn((Mesh3d(mesh.clone()), absent, ClothBody::default(), Name::new("unbound")));
            let nowhere = app.world_mut().spawn_empty().id();
            let limp = SkinnedMesh { joints: vec![nowhere, skin.joints[1]], ..skin };
            app.world_mut().spawn((Mesh3d(mesh), limp, ClothBody::default(), Name::new("limp")));
            run(app, frames);
        })
    };
    let silent = about(&lines(280), &["`plain`", "`bodiless`", "`unbound`", "`limp`"]);
    assert_eq!(silent, Vec::<String>::new(), "within 5 s");
    let lines = lines(900);
    for (name, cure) in [
        ("`plain`", "no `SkinnedMesh`"),
        ("`bodiless`", "no `Mesh3d`"),
        ("`unbound`", "`SkinnedMesh::inverse_bindposes`"),
        ("`limp`", "give it a `Transform`"),
    ] {
        let of: Vec<_> = lines.iter().filter(|line| line.contains(name)).collect();
        assert!(of.len() == 1 && of[0].contains(cure), "{name} and {cure}: {lines:#?}");
    }
}

#[test]
fn settings_out_of_range_are_clamped_and_named_once() {
    let lines = warnings(app(), |app| {
        let (body, _) = body(app, Name::new("leg"));
        app.world_mut().entity_mut(body).insert(ClothBody { margin: -1.0, static_friction: f32::NAN, dynamic_friction: 20.0 });
        run(app, 20);
        let all = colliders(app);
        assert_eq!(all.len(), 2);
        let made = app.world().get::<ClothCollider>(all[0].1).expect("a collider");
        assert!(made.margin >= 0.0 && (made.static_friction, made.dynamic_friction) == (0.5, 10.0), "{made:?}");
    });
    let lines = about(&lines, &["`leg`"]);
    for field in ["`body.margin`", "`body.static_friction`", "`body.dynamic_friction`"] {
        let of = lines.iter().filter(|line| line.contains(field)).count();
        assert_eq!(of, 1, "{field}: {lines:#?}");
    }
    assert_eq!(lines.len(), 3, "{lines:#?}");
}
