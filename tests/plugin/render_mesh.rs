//! Fine meshes that are drawn in place of a coarse cloth.

use bevy::asset::RenderAssetUsages;
use bevy::camera::primitives::Aabb;
use bevy::camera::visibility::NoAutoAabb;
use bevy::math::Vec3A;
use bevy::mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes};
use bevy::prelude::*;
use bevy_drape::prelude::*;

use crate::common::*;
use crate::warnings::warnings;

/// A fine sheet in the place of a coarse one.
fn fine() -> Mesh {
    sheet(41).with_generated_tangents().expect("normals and uv")
}

/// A coarse cloth that is pinned along one border, and what is drawn in its place.
fn dressed(app: &mut App, extra: impl Bundle) -> (Entity, Entity) {
    let cloth = spawn(app, sheet(11), border());
    let mesh = add(app, fine());
    let drawn = app.world_mut().spawn((Mesh3d(mesh), ClothRenderMesh { cloth }, extra)).id();
    (cloth, drawn)
}

/// How far the farthest vertex of a mesh is from the coarse cloth `[m]`, and the lowest one.
fn apart(app: &App, cloth: Entity, drawn: Entity) -> (f32, f32) {
    let mesh = shown(app, cloth);
    let coarse = world_positions(app, cloth);
    let faces: Vec<[usize; 3]> =
        mesh.indices().expect("indices").iter().collect::<Vec<_>>().chunks(3).map(|c| [c[0], c[1], c[2]]).collect();
    let shape = bevy_drape::solver::body::SharedShape::trimesh(
        coarse.iter().map(|p| p.to_array().into()).collect(),
        faces.iter().map(|face| face.map(|v| v as u32)).collect(),
    )
    .expect("a mesh");
    let drawn = world_positions(app, drawn);
    let distance = |p: &Vec3| shape.distance_to_local_point(p.to_array().into(), true);
    (drawn.iter().map(distance).fold(0.0, f32::max), lowest(&drawn))
}

#[test]
fn a_fine_mesh_follows_a_coarse_cloth_and_gets_its_own_back() {
    let mut app = app();
    let (cloth, drawn) = dressed(&mut app, ());
    let authored = app.world().get::<Mesh3d>(drawn).expect("a mesh").0.clone();
    for _ in 0..90 {
        run(&mut app, 1);
        // Facets of 0.1 m that fold by half a radian are 6 mm deep.
        let (far, _) = apart(&app, cloth, drawn);
        assert!(far < 0.015, "{far} m away");
    }
    let (_, low) = apart(&app, cloth, drawn);
    assert!(low < -0.5, "it hangs: {low}");
    let (mesh, at) = (shown(&app, drawn), positions(&app, drawn));
    let held = |(p, q): (&Vec3, &Vec3)| p.z > -0.499 || p.distance(*q) < 0.01;
    assert!(vectors(&fine(), Mesh::ATTRIBUTE_POSITION).iter().zip(&at).all(held), "the border hangs where it was");
    let normals = vectors(mesh, Mesh::ATTRIBUTE_NORMAL);
    assert!(normals.iter().all(|n| (n.length() - 1.0).abs() < 1.0e-3));
    let tangents = match mesh.attribute(Mesh::ATTRIBUTE_TANGENT) {
        Some(bevy::mesh::VertexAttributeValues::Float32x4(tangents)) => tangents.clone(),
        other => panic!("{other:?}"),
    };
    assert!(tangents.iter().zip(&normals).all(|(t, n)| Vec3::new(t[0], t[1], t[2]).dot(*n).abs() < 1.0e-3));
    assert_eq!(shown(&app, cloth).asset_usage, RenderAssetUsages::MAIN_WORLD, "the coarse one is not drawn");
    let bounds = app.world().get::<Aabb>(drawn).expect("bounds");
    assert!(at.iter().all(|x| (Vec3A::from(*x) - bounds.center).abs().cmple(bounds.half_extents + 1.0e-4).all()));

    app.world_mut().entity_mut(drawn).remove::<ClothRenderMesh>();
    run(&mut app, 2);
    let entity = app.world().entity(drawn);
    assert!(entity.get::<Mesh3d>().is_some_and(|mesh| mesh.0 == authored) && !entity.contains::<NoAutoAabb>());
    assert_eq!(positions(&app, drawn), vectors(&fine(), Mesh::ATTRIBUTE_POSITION), "what was authored is not written");
    app.world_mut().entity_mut(drawn).insert(ClothRenderMesh { cloth });
    run(&mut app, 2);
    assert!(apart(&app, cloth, drawn).1 < -0.5, "it follows again");
    app.world_mut().entity_mut(cloth).remove::<Cloth>();
    run(&mut app, 2);
    assert!(app.world().get::<Mesh3d>(drawn).is_some_and(|mesh| mesh.0 == authored));
}

#[test]
fn a_render_mesh_may_have_a_transform_of_its_own_and_go_anywhere() {
    let mut app = app();
    let (cloth, still) = dressed(&mut app, ());
    let place = Transform::from_xyz(3.0, -1.0, 2.0).with_rotation(Quat::from_rotation_y(1.0)).with_scale(Vec3::splat(2.0));
    let mesh = add(&mut app, fine().transformed_by(Transform::from_matrix(place.to_matrix().inverse())));
    let placed = app.world_mut().spawn((Mesh3d(mesh), ClothRenderMesh { cloth }, place)).id();
    let same = |app: &App| {
        let [a, b] = [still, placed].map(|drawn| world_positions(app, drawn));
        a.iter().zip(b).map(|(a, b)| a.distance(b)).fold(0.0, f32::max)
    };
    run(&mut app, 30);
    assert!(same(&app) < 1.0e-4, "{}", same(&app));
    *app.world_mut().get_mut::<Transform>(placed).expect("a transform") = Transform::from_xyz(-50.0, 0.0, 0.0);
    run(&mut app, 10);
    assert!(same(&app) < 1.0e-4, "{}", same(&app));
    // The cloth is scaled: what is drawn is, too.
    app.world_mut().get_mut::<Transform>(cloth).expect("a transform").scale = Vec3::splat(1.5);
    run(&mut app, 60);
    let (far, low) = apart(&app, cloth, still);
    assert!(far < 0.025 && low < -0.8, "{far} m away, {low}");
}

#[test]
fn a_skinned_render_mesh_gets_its_skin_back_where_the_cloth_is_left_to_its_own() {
    let mut app = app();
    app.init_asset::<SkinnedMeshInverseBindposes>();
    let (cloth, drawn) = dressed(&mut app, Transform::from_xyz(0.0, 7.0, 0.0));
    let joint = app.world_mut().spawn(Transform::default()).id();
    let inverse_bindposes = app.world_mut().resource_mut::<Assets<SkinnedMeshInverseBindposes>>().add(vec![Mat4::IDENTITY]);
    let skin = SkinnedMesh { inverse_bindposes, joints: vec![joint] };
    let mesh = {
        let mesh = sheet(11);
        let vertices = mesh.count_vertices();
        mesh.with_inserted_attribute(
            Mesh::ATTRIBUTE_JOINT_INDEX,
            bevy::mesh::VertexAttributeValues::Uint16x4(vec![[0; 4]; vertices]),
        )
        .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, vec![[1.0_f32, 0.0, 0.0, 0.0]; vertices])
    };
    let mesh = add(&mut app, mesh);
    app.world_mut().entity_mut(cloth).insert((Mesh3d(mesh), skin.clone()));
    app.world_mut().entity_mut(drawn).insert(skin);
    run(&mut app, 60);
    assert!(!app.world().entity(drawn).contains::<SkinnedMesh>());
    let (far, low) = apart(&app, cloth, drawn);
    assert!(far < 0.015 && low < -0.3, "{far} m away, {low}: the transform of a skinned mesh does not count");
    app.world_mut().entity_mut(cloth).insert(ClothBlend { weight: 0.0, rate: 100.0 });
    run(&mut app, 10);
    assert!([cloth, drawn].iter().all(|&entity| app.world().entity(entity).contains::<SkinnedMesh>()));
    app.world_mut().entity_mut(cloth).insert(ClothBlend { weight: 1.0, rate: 100.0 });
    run(&mut app, 60);
    assert!(!app.world().entity(drawn).contains::<SkinnedMesh>() && apart(&app, cloth, drawn).0 < 0.015);
}

#[test]
fn a_large_render_mesh_is_hung_in_the_background() {
    let mut app = app();
    app.insert_resource(ClothLoading { in_background_from: 1000 });
    let (cloth, drawn) = dressed(&mut app, ());
    let start = std::time::Instant::now();
    while !app.world().entity(drawn).contains::<NoAutoAabb>() {
        assert!(start.elapsed().as_secs() < 60, "it never follows");
        assert_eq!(positions(&app, drawn), vectors(&fine(), Mesh::ATTRIBUTE_POSITION), "as authored meanwhile");
        run(&mut app, 1);
    }
    run(&mut app, 2);
    assert!(apart(&app, cloth, drawn).0 < 0.015);
}

#[test]
fn render_meshes_that_cannot_follow_are_told_of_once() {
    let lines = warnings(app(), |app| {
        let (cloth, far) = dressed(app, (Name::new("Far"), Transform::from_xyz(0.0, 20.0, 0.0)));
        let mesh = add(app, fine());
        let banner = app.world_mut().spawn(Name::new("Banner")).id();
        app.world_mut().spawn((Name::new("Fringe"), Mesh3d(mesh), ClothRenderMesh { cloth: banner }));
        let mut broken = fine();
        broken.insert_attribute(Mesh::ATTRIBUTE_POSITION, vec![[f32::NAN; 3]; 41 * 41]);
        let broken = add(app, broken);
        let broken = app.world_mut().spawn((Name::new("Broken"), Mesh3d(broken.clone()), ClothRenderMesh { cloth })).id();
        app.world_mut().entity_mut(cloth).insert((Name::new("Both"), ClothRenderMesh { cloth }));
        run(app, 20);
        assert!(finite(app, cloth) && positions(app, far).iter().all(|p| p.is_finite()));
        assert!(!app.world().entity(broken).contains::<NoAutoAabb>(), "it stays as it was authored");
    });
    let told = |words: &[&str]| lines.iter().filter(|line| words.iter().all(|word| line.contains(word))).count();
    for words in [
        &["`Far`", "m away", "in the same place"][..],
        &["`Fringe`", "`Banner`", "`ClothRenderMesh::cloth`"],
        &["`Broken`", "not finite"],
        &["`Both`", "a cloth of its own"],
    ] {
        assert_eq!(told(words), 1, "{words:?} in {lines:#?}");
    }
    assert_eq!(lines.len(), 4, "{lines:#?}");
}
