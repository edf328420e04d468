//! Cloths of several materials: one is simulated, several meshes show it.

use bevy::asset::RenderAssetUsages;
use bevy::camera::visibility::NoAutoAabb;
use bevy::math::Vec3A;
use bevy::mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes};
use bevy::prelude::*;
use bevy_drape::prelude::*;

use crate::common::*;
use crate::warnings::warnings;

/// A sheet of half a metre by a metre, left or right of the plane x = 0.
fn half(side: f32) -> Mesh {
    Plane3d::default().mesh().size(0.5, 1.0).subdivisions(9).build().translated_by(Vec3::X * 0.25 * side)
}

/// Both halves in one mesh.
fn both() -> Mesh {
    let mut both = half(-1.0);
    both.merge(&half(1.0)).expect("meshes alike");
    both
}

/// A cloth that is pinned along one border, the two entities that show it, and their meshes.
fn spawn_pieces(app: &mut App) -> (Entity, [Entity; 2], [Handle<Mesh>; 2]) {
    let cloth = spawn(app, both(), border());
    let meshes = [half(-1.0), half(1.0)].map(|mesh| add(app, mesh));
    let firsts = [0, half(-1.0).count_vertices() as u32];
    let pieces = [0, 1].map(|k| {
        let piece = ClothPiece { cloth, first: firsts[k] };
        app.world_mut().spawn((Mesh3d(meshes[k].clone()), piece, ChildOf(cloth))).id()
    });
    (cloth, pieces, meshes)
}

fn mesh_of_entity(app: &App, entity: Entity) -> Handle<Mesh> {
    app.world().get::<Mesh3d>(entity).expect("a mesh").0.clone()
}

#[test]
fn pieces_show_one_cloth_and_hang_together() {
    let mut app = app();
    let (cloth, pieces, meshes) = spawn_pieces(&mut app);
    run(&mut app, 40);
    // Eleven vertices along the middle are in both halves.
    assert_eq!(particles(&app, cloth).len(), 21 * 11);
    for attribute in [Mesh::ATTRIBUTE_POSITION, Mesh::ATTRIBUTE_NORMAL] {
        let whole = vectors(shown(&app, cloth), attribute);
        let shown: Vec<Vec3> = pieces.iter().flat_map(|&piece| vectors(shown(&app, piece), attribute)).collect();
        assert_eq!(shown, whole, "{}", attribute.name);
    }
    let [left, right] = pieces.map(|piece| positions(&app, piece));
    let authored = half(-1.0);
    let seam = vectors(&authored, Mesh::ATTRIBUTE_POSITION)
        .iter()
        .zip(&left)
        .filter(|(at, _)| at.x > -1e-6)
        .map(|(_, x)| *x)
        .collect::<Vec<_>>();
    assert_eq!(seam.len(), 11);
    assert!(seam.iter().all(|x| right.contains(x)), "the seam is closed");
    assert!(lowest(&left) < -0.3 && lowest(&right) < -0.3, "they fall");
    assert_eq!(shown(&app, cloth).asset_usage, RenderAssetUsages::MAIN_WORLD, "the whole is not drawn");
    assert!(pieces.iter().all(|&piece| shown(&app, piece).asset_usage.contains(RenderAssetUsages::RENDER_WORLD)));
    let bounds = app.world().get::<bevy::camera::primitives::Aabb>(pieces[0]).expect("bounds");
    assert!(left.iter().all(|x| (Vec3A::from(*x) - bounds.center).abs().cmple(bounds.half_extents).all()));
    assert!(meshes.iter().zip(&pieces).all(|(mesh, &piece)| mesh_of_entity(&app, piece) != *mesh));
    assert_eq!(
        vectors(app.world().resource::<Assets<Mesh>>().get(&meshes[0]).expect("a mesh"), Mesh::ATTRIBUTE_POSITION),
        vectors(&authored, Mesh::ATTRIBUTE_POSITION),
        "what was authored is not written"
    );
}

#[test]
fn pieces_get_their_meshes_back() {
    let authored = |app: &App, piece: Entity, mesh: &Handle<Mesh>| {
        mesh_of_entity(app, piece) == *mesh && !app.world().entity(piece).contains::<NoAutoAabb>()
    };
    let mut app = app();
    let (cloth, pieces, meshes) = spawn_pieces(&mut app);
    run(&mut app, 5);
    app.world_mut().entity_mut(pieces[0]).remove::<ClothPiece>();
    run(&mut app, 2);
    assert!(authored(&app, pieces[0], &meshes[0]) && !authored(&app, pieces[1], &meshes[1]));
    app.world_mut().entity_mut(cloth).remove::<Cloth>();
    run(&mut app, 2);
    assert!(authored(&app, pieces[1], &meshes[1]));
    app.world_mut().entity_mut(cloth).insert((Cloth, border()));
    run(&mut app, 5);
    assert!(!authored(&app, pieces[1], &meshes[1]), "it follows again");
    app.world_mut().entity_mut(pieces[1]).remove::<ChildOf>();
    app.world_mut().despawn(cloth);
    run(&mut app, 2);
    assert!(authored(&app, pieces[1], &meshes[1]), "its cloth is gone");
    let other = add(&mut app, half(1.0));
    let (_, pieces, _) = spawn_pieces(&mut app);
    run(&mut app, 5);
    app.world_mut().get_mut::<Mesh3d>(pieces[1]).expect("a mesh").0 = other.clone();
    run(&mut app, 5);
    assert!(mesh_of_entity(&app, pieces[1]) != other, "another mesh follows as well");
    assert!(lowest(&positions(&app, pieces[1])) < -0.01);
}

#[test]
fn skins_of_pieces_are_taken_off_while_they_follow() {
    let mut app = app();
    app.init_asset::<SkinnedMeshInverseBindposes>();
    let (cloth, pieces, _) = spawn_pieces(&mut app);
    let skin = SkinnedMesh { joints: vec![app.world_mut().spawn(Transform::default()).id()], ..default() };
    app.world_mut().entity_mut(pieces[0]).insert(skin);
    run(&mut app, 3);
    assert!(!app.world().entity(pieces[0]).contains::<SkinnedMesh>());
    app.world_mut().entity_mut(cloth).remove::<Cloth>();
    run(&mut app, 2);
    assert_eq!(app.world().get::<SkinnedMesh>(pieces[0]).expect("its skin").joints.len(), 1);
}

#[test]
fn pieces_that_show_nothing_are_told_of_once() {
    let lines = warnings(app(), |app| {
        let (cloth, pieces, _) = spawn_pieces(app);
        app.world_mut().entity_mut(pieces[1]).insert(ClothPiece { cloth, first: 200 });
        let other = app.world_mut().spawn(Name::new("Banner")).id();
        let mesh = add(app, half(1.0));
        app.world_mut().spawn((Name::new("Fringe"), Mesh3d(mesh), ClothPiece { cloth: other, first: 0 }));
        run(app, 10);
    });
    let told = |words: &[&str]| lines.iter().filter(|line| words.iter().all(|word| line.contains(word))).count();
    assert_eq!(told(&["121 vertices from number 200", "has 242", "`ClothPiece::first`"]), 1, "{lines:#?}");
    assert_eq!(told(&["`Fringe`", "`Banner`", "`Cloth`"]), 1, "{lines:#?}");
    assert_eq!(lines.len(), 2, "{lines:#?}");
}

#[test]
fn a_piece_whose_cloth_is_one_no_more_is_no_mistake_and_one_whose_cloth_is_gone_is_told_of() {
    let lines = warnings(app(), |app| {
        let (cloth, ..) = spawn_pieces(app);
        run(app, 10);
        app.world_mut().entity_mut(cloth).remove::<Cloth>();
        run(app, 10);
    });
    assert_eq!(lines, Vec::<String>::new());
    let lines = warnings(app(), |app| {
        let (cloth, pieces, _) = spawn_pieces(app);
        run(app, 10);
        app.world_mut().entity_mut(pieces[0]).remove::<ChildOf>();
        app.world_mut().despawn(cloth);
        run(app, 10);
    });
    assert_eq!(lines.len(), 1, "{lines:#?}");
    assert!(lines[0].contains("does not exist") && lines[0].contains("`ClothPiece::cloth`"), "{lines:#?}");
}

#[test]
fn a_piece_that_becomes_a_cloth_is_one() {
    let lines = warnings(app(), |app| {
        let (_, pieces, meshes) = spawn_pieces(app);
        run(app, 5);
        app.world_mut().entity_mut(pieces[0]).insert((Cloth, border()));
        run(app, 20);
        assert_eq!(status(app, pieces[0]), ClothStatus::Active);
        assert_eq!(particles(app, pieces[0]).len(), 11 * 11);
        assert!(app.world().entity(pieces[0]).contains::<NoAutoAabb>());
        app.world_mut().entity_mut(pieces[0]).remove::<ClothPiece>();
        run(app, 5);
        assert!(app.world().entity(pieces[0]).contains::<NoAutoAabb>(), "its bounds are those of the cloth");
        assert!(lowest(&positions(app, pieces[0])) < -0.1);
        app.world_mut().entity_mut(pieces[0]).remove::<Cloth>();
        run(app, 2);
        assert!(mesh_of_entity(app, pieces[0]) == meshes[0]);
    });
    assert_eq!(lines.len(), 1, "{lines:#?}");
    assert!(lines[0].contains("a cloth of its own"), "{lines:#?}");
}

#[test]
fn a_clone_of_a_cloth_and_its_pieces_has_bounds_of_its_own() {
    let mut app = app();
    let (_, pieces, meshes) = spawn_pieces(&mut app);
    run(&mut app, 5);
    let clone = app.world_mut().entity_mut(pieces[0]).clone_and_spawn();
    run(&mut app, 5);
    assert!(mesh_of_entity(&app, clone) != mesh_of_entity(&app, pieces[0]), "a mesh of its own");
    assert_eq!(positions(&app, clone), positions(&app, pieces[0]));
    app.world_mut().entity_mut(clone).remove::<ClothPiece>();
    run(&mut app, 2);
    assert!(mesh_of_entity(&app, clone) == meshes[0] && !app.world().entity(clone).contains::<NoAutoAabb>());
}
