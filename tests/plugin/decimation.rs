//! Cloth that is coarser than its mesh.

use bevy::mesh::skinning::SkinnedMesh;
use bevy::prelude::*;
use bevy_drape::prelude::*;

use crate::common::*;
use crate::warnings::warnings;

/// Vertices along a side of a sheet of a metre, 17 mm apart.
const N: u32 = 60;

fn count(app: &App, cloth: Entity) -> usize {
    particles(app, cloth).len()
}

/// Longest and shortest distance between neighbours in rows of a sheet, over what it was.
fn stretch(points: &[Vec3]) -> (f32, f32) {
    let rest = vectors(&sheet(N), Mesh::ATTRIBUTE_POSITION);
    let pairs = (0..rest.len() - 1).filter(|i| (i + 1) % N as usize != 0);
    let ratios = pairs.map(|i| points[i].distance(points[i + 1]) / rest[i].distance(rest[i + 1]));
    ratios.fold((0.0, f32::INFINITY), |(most, least), r| (f32::max(most, r), f32::min(least, r)))
}

#[test]
fn a_fine_sheet_hangs_with_a_tenth_of_its_particles_and_is_drawn_as_fine_as_it_is() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(N), (ClothDecimation::new(0.05), border()));
    run(&mut app, 2);
    let at_first = positions(&app, cloth);
    for (now, authored) in at_first.iter().zip(vectors(&sheet(N), Mesh::ATTRIBUTE_POSITION)) {
        assert!(now.distance(authored) < 0.02, "{authored} begins at {now}");
    }
    run(&mut app, 150);
    assert!((150..500).contains(&count(&app, cloth)), "{} particles", count(&app, cloth));
    assert_eq!(shown(&app, cloth).count_vertices(), (N * N) as usize);
    let hanging = positions(&app, cloth);
    assert!(finite(&app, cloth) && lowest(&hanging) < -0.9, "it hangs: {}", lowest(&hanging));
    let (most, least) = stretch(&hanging);
    assert!(most < 1.25 && least > 0.6, "neighbours are {least} to {most} of what they were apart");
    // Its pinned border is where it was, and normals are of unit length and across the sheet.
    for (now, authored) in hanging.iter().zip(vectors(&sheet(N), Mesh::ATTRIBUTE_POSITION)) {
        let is_held = authored.z < -0.499;
        assert!(!is_held || now.distance(authored) < 5.0e-3, "{authored} is held at {now}");
    }
    let normals = vectors(shown(&app, cloth), Mesh::ATTRIBUTE_NORMAL);
    let across = normals.iter().filter(|n| n.z.abs() > 0.8).count();
    assert!(normals.iter().all(|n| (n.length() - 1.0).abs() < 1.0e-3) && across > normals.len() / 2, "{across} of {}", N * N);
}

#[test]
fn another_length_builds_it_anew_and_without_it_the_cloth_is_as_fine_as_its_mesh() {
    let mut app = app();
    let mesh = add(&mut app, sheet(N));
    let cloth = |app: &mut App, extra: ClothDecimation| app.world_mut().spawn((Mesh3d(mesh.clone()), Cloth, extra)).id();
    let [a, b] = [0.05, 0.05].map(|length| cloth(&mut app, ClothDecimation::new(length)));
    let c = app.world_mut().spawn((Mesh3d(mesh.clone()), Cloth)).id();
    run(&mut app, 2);
    let [one, other] = [a, b].map(|cloth| app.world().get::<ClothRest>(cloth).expect("a shape"));
    assert!(one.is_shared_with(other), "cloths alike share their shape");
    assert_eq!(count(&app, c), (N * N) as usize);
    let before = count(&app, a);
    app.world_mut().get_mut::<ClothDecimation>(a).expect("it").shortest_edge = 0.1;
    run(&mut app, 2);
    assert!(count(&app, a) * 3 < before && count(&app, b) == before, "{} of {before}", count(&app, a));
    app.world_mut().entity_mut(a).remove::<ClothDecimation>();
    app.world_mut().entity_mut(c).insert(ClothDecimation::new(0.05));
    run(&mut app, 30);
    assert_eq!([a, c].map(|cloth| count(&app, cloth)), [(N * N) as usize, before]);
    assert!([a, b, c].iter().all(|cloth| status(&app, *cloth) == ClothStatus::Active && finite(&app, *cloth)));
    // A clone is as coarse; a mesh that is written, or scaled, is coarse again.
    let clone = app.world_mut().entity_mut(b).clone_and_spawn();
    run(&mut app, 2);
    assert_eq!(count(&app, clone), before);
    app.world_mut().get_mut::<Transform>(b).expect("it").scale = Vec3::new(-2.0, 1.0, 0.5);
    run(&mut app, 30);
    assert!(finite(&app, b));
    assert_eq!(count(&app, b), before, "lengths are those of the mesh, whatever its scale");
    app.world_mut().resource_mut::<Assets<Mesh>>().insert(&mesh, sheet(N / 4)).expect("a mesh");
    run(&mut app, 30);
    // Its edges are longer.
    assert_eq!([a, b, c, clone].map(|cloth| count(&app, cloth)), [(N * N / 16) as usize; 4]);
    assert!([a, b, c, clone].iter().all(|cloth| finite(&app, *cloth) && shown(&app, *cloth).count_vertices() == 225));
    for cloth in [a, b, c, clone] {
        app.world_mut().entity_mut(cloth).remove::<Cloth>();
    }
    run(&mut app, 2);
    assert!([a, b, c, clone].iter().all(|cloth| app.world().get::<Mesh3d>(*cloth).expect("a mesh").0 == mesh));
}

#[test]
fn whichever_vertex_is_pinned_something_is_held_there() {
    let mut app = app();
    for vertex in [0, 1, 7, 61, 1830, 3599] {
        let pins = ClothPins::vertices([vertex]);
        let cloth = spawn(&mut app, sheet(N), (ClothDecimation::new(0.06), pins));
        run(&mut app, 60);
        assert_eq!(report(&app, cloth).pinned, 1, "vertex {vertex}");
        let authored = vectors(&sheet(N), Mesh::ATTRIBUTE_POSITION)[vertex as usize];
        let now = positions(&app, cloth)[vertex as usize];
        assert!(now.distance(authored) < 0.12, "vertex {vertex} hangs from its particle: {authored} is at {now}");
        app.world_mut().entity_mut(cloth).despawn();
    }
}

#[test]
fn it_follows_its_skin_and_what_is_painted_on_it() {
    let mut app = app();
    let limits = ClothLimits { max_distance: 0.02.into(), ..default() };
    let (cloth, joints) = crate::skinned::dressed(&mut app, N, (ClothDecimation::new(0.06), limits));
    run(&mut app, 3);
    assert!(count(&app, cloth) < 400);
    for k in 0..90 {
        let at = crate::skinned::dance(k as f32 / 60.0, 0.0);
        joints.iter().for_each(|joint| crate::skinned::put(&mut app, *joint, at));
        run(&mut app, 1);
        let rest = vectors(&sheet(N), Mesh::ATTRIBUTE_POSITION);
        let off = |(p, now): (&Vec3, Vec3)| at.transform_point(*p).distance(now);
        let farthest = rest.iter().zip(world_positions(&app, cloth)).map(off).fold(0.0, f32::max);
        assert!(farthest < 0.03, "frame {k}: {farthest} m from a skin that allows 20 mm");
    }
    app.world_mut().entity_mut(cloth).insert(ClothBlend { weight: 0.0, ..default() });
    run(&mut app, 30);
    assert!(app.world().get::<SkinnedMesh>(cloth).is_some(), "it is on its skin");
    app.world_mut().entity_mut(cloth).insert(ClothBlend::default());
    run(&mut app, 30);
    assert!(finite(&app, cloth) && count(&app, cloth) < 400);
}

#[test]
fn pieces_of_several_materials_follow_one_coarse_cloth() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(N), (ClothDecimation::new(0.06), border()));
    let mesh = add(&mut app, sheet(N));
    let piece = app.world_mut().spawn((Mesh3d(mesh), ClothPiece { cloth, first: 0 }, ChildOf(cloth))).id();
    run(&mut app, 60);
    assert_eq!(positions(&app, piece), positions(&app, cloth));
    assert!(count(&app, cloth) < 400 && lowest(&positions(&app, piece)) < -0.5);
}

#[test]
fn lengths_that_are_none_are_told_once_and_any_other_gives_a_cloth() {
    let lines = warnings(app(), |app| {
        for length in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            let cloth = spawn(app, sheet(12), ClothDecimation::new(length));
            run(app, 3);
            assert_eq!((count(app, cloth), status(app, cloth)), (144, ClothStatus::Active), "{length}");
        }
        // Later, too: an insert.
        let cloth = spawn(app, sheet(12), border());
        run(app, 3);
        app.world_mut().entity_mut(cloth).insert(ClothDecimation::new(-2.0));
        run(app, 3);
        assert_eq!((count(app, cloth), status(app, cloth)), (144, ClothStatus::Active));
        for length in [1.0e-9, 0.3, 10.0, f32::MAX] {
            let cloth = spawn(app, sheet(12), (ClothDecimation::new(length), border()));
            run(app, 60);
            assert_eq!(status(app, cloth), ClothStatus::Active, "{length}");
            assert!(finite(app, cloth) && shown(app, cloth).count_vertices() == 144, "{length}");
        }
    });
    assert_eq!(lines.iter().filter(|line| line.contains("decimation.shortest_edge")).count(), 5, "{lines:#?}");
}

#[test]
fn one_that_fails_is_tried_again_when_its_length_changes_and_not_in_every_frame() {
    let mut app = app();
    let pins = ClothPins::from(ClothPinSelect::Attribute("_NOT_THERE".into()));
    let cloth = spawn(&mut app, sheet(N), (ClothDecimation::new(0.05), pins));
    run(&mut app, 3);
    assert_eq!(status(&app, cloth), ClothStatus::Failed);
    // What remembers the failure is written when it is tried.
    let tried = |app: &App| {
        let world = app.world();
        let binding = world.inspect_entity(cloth).expect("it").find(|info| info.name().to_string().ends_with("::Binding"));
        let id = binding.expect("what it was bound to").id();
        world.entity(cloth).get_change_ticks_by_id(id).expect("ticks").changed
    };
    let before = tried(&app);
    run(&mut app, 3);
    assert_eq!(before, tried(&app), "it is tried in every frame");
    app.world_mut().entity_mut(cloth).insert((ClothDecimation::new(0.08), ClothPins::NONE));
    run(&mut app, 3);
    assert_eq!(status(&app, cloth), ClothStatus::Active);
    app.world_mut().entity_mut(cloth).insert(ClothDisabled);
    run(&mut app, 10);
    app.world_mut().entity_mut(cloth).remove::<ClothDisabled>();
    run(&mut app, 10);
    assert!(finite(&app, cloth) && count(&app, cloth) < 400);
}

#[test]
fn a_pinned_patch_holds_the_particles_on_it_and_none_beyond() {
    let mut app = app();
    let pins = ClothPins::where_position(|p| p.z < -0.3);
    let cloth = spawn(&mut app, sheet(N), (ClothDecimation::new(0.06), pins));
    run(&mut app, 2);
    let at_first = particles(&app, cloth);
    let inside = at_first.iter().filter(|p| p.z < -0.3).count();
    assert!(report(&app, cloth).pinned as usize == inside, "{} for {inside}", report(&app, cloth).pinned);
    assert!(inside > 30);
}
