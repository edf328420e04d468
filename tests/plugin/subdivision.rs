//! Cloth that is finer than its mesh.

use bevy::ecs::entity_disabling::Disabled;
use bevy::mesh::VertexAttributeValues;
use bevy::mesh::skinning::SkinnedMesh;
use bevy::prelude::*;
use bevy_drape::ClothPlugin;
use bevy_drape::prelude::*;

use crate::common::{add, app, app_with, finite, frame_length, lowest, positions, report, run, shown, spawn, status};
use crate::warnings::warnings;

/// A plane of four vertices.
fn plane() -> Mesh {
    Plane3d::default().mesh().size(1.0, 1.0).build()
}

fn vertices(app: &App, cloth: Entity) -> usize {
    shown(app, cloth).count_vertices()
}

/// The mesh that an entity has, by its handle.
fn handle(app: &App, cloth: Entity) -> Handle<Mesh> {
    app.world().get::<Mesh3d>(cloth).expect("a mesh").0.clone()
}

#[test]
fn a_plane_of_four_vertices_hangs_as_cloth_and_keeps_its_pins() {
    let mut app = app();
    let border = ClothPins::where_position(|p| p.z < -0.499);
    let corners = [0, 1];
    let by_place = spawn(&mut app, plane(), (ClothSubdivision::new(0.1), border));
    let by_number = spawn(
        &mut app,
        plane(),
        (ClothSubdivision::new(0.1), ClothPins::vertices(corners), Transform::from_xyz(5.0, 0.0, 0.0)),
    );
    run(&mut app, 120);
    for cloth in [by_place, by_number] {
        assert_eq!(status(&app, cloth), ClothStatus::Active);
        assert!(vertices(&app, cloth) > 100 && finite(&app, cloth), "{} vertices", vertices(&app, cloth));
        assert!(lowest(&positions(&app, cloth)) < -0.8, "it hangs: {}", lowest(&positions(&app, cloth)));
    }
    assert!(report(&app, by_place).pinned > 10, "what is between is held, too: {}", report(&app, by_place).pinned);
    assert_eq!(report(&app, by_number).pinned, 2);
}

#[test]
fn cloths_with_the_same_mesh_and_length_share_what_is_made_and_give_their_mesh_back() {
    let mut app = app();
    let mesh = add(&mut app, plane());
    let cloth =
        |app: &mut App, longest: f32| app.world_mut().spawn((Mesh3d(mesh.clone()), Cloth, ClothSubdivision::new(longest))).id();
    let [a, b, c, d] = [0.1, 0.1, 0.2, 10.0].map(|longest| cloth(&mut app, longest));
    run(&mut app, 2);
    let meshes = |app: &App| app.world().resource::<Assets<Mesh>>().len();
    // The mesh, two that are finer, and one for each cloth.
    assert_eq!(meshes(&app), 1 + 2 + 4);
    assert_eq!([a, b, c, d].map(|cloth| vertices(&app, cloth) > 4), [true, true, true, false]);
    assert_eq!(vertices(&app, a), vertices(&app, b));
    app.world_mut().entity_mut(a).remove::<Cloth>();
    app.world_mut().entity_mut(b).remove::<ClothSubdivision>();
    assert!(handle(&app, a) == mesh && handle(&app, b) == mesh);
    run(&mut app, 2);
    assert_eq!((vertices(&app, a), vertices(&app, b)), (4, 4));
    assert_eq!(status(&app, b), ClothStatus::Active);
    app.world_mut().entity_mut(a).insert(Cloth);
    run(&mut app, 2);
    assert!(vertices(&app, a) > 4);
    for cloth in [a, b, c, d] {
        app.world_mut().entity_mut(cloth).despawn();
    }
    run(&mut app, 3);
    assert_eq!(meshes(&app), 1, "nothing of ours is left");
}

#[test]
fn another_length_and_another_mesh_are_made_anew() {
    let mut app = app();
    let mesh = add(&mut app, plane());
    let cloth = app.world_mut().spawn((Mesh3d(mesh.clone()), Cloth, ClothSubdivision::new(0.2))).id();
    run(&mut app, 2);
    let before = vertices(&app, cloth);
    app.world_mut().get_mut::<ClothSubdivision>(cloth).expect("it").longest_edge = 0.1;
    run(&mut app, 2);
    let finer = vertices(&app, cloth);
    assert!(finer > 3 * before, "{before} and {finer}");
    // The asset is written.
    let larger = Plane3d::default().mesh().size(2.0, 1.0).build();
    app.world_mut().resource_mut::<Assets<Mesh>>().insert(&mesh, larger).expect("a mesh");
    run(&mut app, 3);
    assert!(vertices(&app, cloth) > finer, "{} and {finer}", vertices(&app, cloth));
    // Another one in its place.
    let small = add(&mut app, Plane3d::default().mesh().size(0.05, 0.05).build());
    app.world_mut().get_mut::<Mesh3d>(cloth).expect("it").0 = small.clone();
    run(&mut app, 2);
    assert_eq!(vertices(&app, cloth), 4);
    let clone = app.world_mut().entity_mut(cloth).clone_and_spawn();
    run(&mut app, 2);
    assert_eq!((vertices(&app, clone), status(&app, clone)), (4, ClothStatus::Active));
}

#[test]
fn lengths_that_are_none_and_meshes_that_cannot_be_split_are_told_once() {
    let lines = warnings(app(), |app| {
        for longest in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            let cloth = spawn(app, plane(), ClothSubdivision::new(longest));
            run(app, 3);
            assert_eq!((vertices(app, cloth), status(app, cloth)), (4, ClothStatus::Active), "{longest}");
        }
        frame_length(app, 0.0);
        let cloth = spawn(app, plane(), ClothSubdivision::new(1.0e-5));
        run(app, 3);
        assert!(vertices(app, cloth) > 10_000);
        let mut points = plane();
        points.remove_attribute(Mesh::ATTRIBUTE_POSITION);
        let nothing = spawn(app, points, ClothSubdivision::new(0.1));
        run(app, 3);
        assert_eq!(status(app, nothing), ClothStatus::Failed);
    });
    let of = |words: &str| lines.iter().filter(|line| line.contains(words)).count();
    assert_eq!((of("a length of more than 0"), of("more than 50000 vertices"), of("no positions")), (4, 1, 1), "{lines:#?}");
}

#[test]
fn maps_are_finer_too() {
    let mut app = app();
    let mut mesh = plane();
    let Some(VertexAttributeValues::Float32x3(at)) = mesh.attribute(Mesh::ATTRIBUTE_POSITION) else { panic!("positions") };
    let red: Vec<[f32; 4]> = at.iter().map(|p| [f32::from(p[2] < 0.0), 0.0, 0.0, 1.0]).collect();
    mesh.insert_attribute(Mesh::ATTRIBUTE_COLOR, red);
    let cloth = spawn(&mut app, mesh, (ClothSubdivision::new(0.1), ClothPins::color(ClothColorChannel::R)));
    run(&mut app, 60);
    // All along the red side, and weaker from there on.
    assert!(report(&app, cloth).pinned > 50, "{}", report(&app, cloth).pinned);
    assert!(finite(&app, cloth));
}

#[test]
fn a_mesh_that_comes_later_is_made_finer_and_one_that_was_switched_off_meanwhile_is_made_anew() {
    for mut app in [app(), app_with(ClothPlugin::new(FixedPostUpdate))] {
        let late = app.world().resource::<Assets<Mesh>>().reserve_handle();
        let cloth = app.world_mut().spawn((Mesh3d(late.clone()), Cloth, ClothSubdivision::new(0.1))).id();
        run(&mut app, 3);
        assert_eq!(status(&app, cloth), ClothStatus::Waiting(ClothWaitingFor::Asset));
        let write =
            |app: &mut App, mesh: Mesh| app.world_mut().resource_mut::<Assets<Mesh>>().insert(&late, mesh).expect("a mesh");
        write(&mut app, plane());
        run(&mut app, 4);
        let count = vertices(&app, cloth);
        assert!(count > 100 && status(&app, cloth) == ClothStatus::Active, "{count}");
        app.world_mut().entity_mut(cloth).insert(Disabled);
        write(&mut app, Plane3d::default().mesh().size(2.0, 1.0).build());
        run(&mut app, 3);
        app.world_mut().entity_mut(cloth).remove::<Disabled>();
        run(&mut app, 3);
        assert!(vertices(&app, cloth) > count, "{count} and {}", vertices(&app, cloth));
    }
}

#[test]
fn a_clone_is_as_fine_and_gives_the_same_mesh_back() {
    let mut app = app();
    let mesh = add(&mut app, plane());
    let cloth = app.world_mut().spawn((Mesh3d(mesh.clone()), Cloth, ClothSubdivision::new(0.1))).id();
    run(&mut app, 2);
    let clone = app.world_mut().entity_mut(cloth).clone_and_spawn();
    run(&mut app, 2);
    assert_eq!(vertices(&app, clone), vertices(&app, cloth));
    app.world_mut().entity_mut(clone).remove::<ClothSubdivision>();
    assert!(handle(&app, clone) == mesh);
    run(&mut app, 2);
    assert_eq!((vertices(&app, clone), status(&app, clone)), (4, ClothStatus::Active));
    assert!(vertices(&app, cloth) > 100);
}

#[test]
fn a_skin_is_as_fine_as_its_cloth_and_is_bounded_where_it_is_drawn_itself() {
    let mut app = app();
    let (cloth, _) = crate::skinned::dressed(&mut app, 3, (ClothSubdivision::new(0.1), ClothLimits::default()));
    let source = handle(&app, cloth);
    app.world_mut()
        .resource_mut::<Assets<Mesh>>()
        .get_mut(&source)
        .expect("a mesh")
        .generate_skinned_mesh_bounds()
        .expect("a skin");
    run(&mut app, 3);
    assert!(vertices(&app, cloth) > 100 && status(&app, cloth) == ClothStatus::Active);
    app.world_mut().entity_mut(cloth).insert(ClothBlend { weight: 0.0, ..default() });
    run(&mut app, 30);
    assert!(app.world().get::<SkinnedMesh>(cloth).is_some(), "it is on its skin");
    assert!(vertices(&app, cloth) > 100 && shown(&app, cloth).skinned_mesh_bounds().is_some());
    app.world_mut().entity_mut(cloth).remove::<ClothSubdivision>();
    assert!(handle(&app, cloth) == source);
    run(&mut app, 30);
    assert_eq!((vertices(&app, cloth), status(&app, cloth)), (9, ClothStatus::Active));
}

#[test]
fn what_pieces_draw_is_not_made_finer_and_that_is_told_once() {
    let lines = warnings(app(), |app| {
        let whole = add(app, plane());
        let cloth = app.world_mut().spawn((Mesh3d(whole.clone()), Cloth, ClothSubdivision::new(0.1))).id();
        app.world_mut().spawn((Mesh3d(whole), ClothPiece { cloth, first: 0 }));
        run(app, 5);
        assert_eq!((vertices(app, cloth), status(app, cloth)), (4, ClothStatus::Active));
    });
    assert_eq!(lines.iter().filter(|line| line.contains("drawn by pieces")).count(), 1, "{lines:#?}");
}
