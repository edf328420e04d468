//! Any mesh becomes a cloth, or says why not.

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use bevy_drape::prelude::*;
use bevy_drape::{ClothBuildReport, ClothError, ClothErrorKind, ClothFailed, ClothRest, ClothWaitingFor};

use crate::common::*;

fn build(app: &App, entity: Entity) -> &ClothBuildReport {
    app.world().get::<ClothBuildReport>(entity).expect("a cloth")
}

fn error(app: &App, entity: Entity) -> Option<ClothErrorKind> {
    app.world().get::<ClothError>(entity).map(|e| e.kind)
}

fn mesh_of(topology: PrimitiveTopology, positions: Vec<[f32; 3]>, indices: Option<Indices>) -> Mesh {
    let mut mesh = Mesh::new(topology, RenderAssetUsages::default());
    mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, positions);
    if let Some(indices) = indices {
        mesh.insert_indices(indices);
    }
    mesh
}

fn quad() -> Vec<[f32; 3]> {
    vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0]]
}

#[test]
fn a_sheet_hangs_from_its_pins() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(12), border());
    run(&mut app, 120);
    assert_eq!(status(&app, cloth), ClothStatus::Active);
    let bottom = lowest(&world_positions(&app, cloth));
    assert!((-1.1..-0.8).contains(&bottom), "lowest point after 2 s: {bottom} m");
    assert!(report(&app, cloth).worst_edge < 1.1, "{:?}", report(&app, cloth));
}

#[test]
fn a_mesh_that_is_split_at_every_edge_hangs_in_one_piece() {
    let mut app = app();
    let mut split = sheet(8);
    split.duplicate_vertices();
    let cloth = spawn(&mut app, split, border());
    run(&mut app, 60);
    assert_eq!((build(&app, cloth).vertices, build(&app, cloth).particles), (7 * 7 * 6, 64));
    let rest = vectors(
        &{
            let mut m = sheet(8);
            m.duplicate_vertices();
            m
        },
        Mesh::ATTRIBUTE_POSITION,
    );
    let now = positions(&app, cloth);
    for i in 0..rest.len() {
        for j in 0..i {
            assert!(
                rest[i] != rest[j] || now[i] == now[j],
                "vertices {i} and {j} were together and are at {} and {}",
                now[i],
                now[j]
            );
        }
    }
    assert!(report(&app, cloth).worst_edge < 1.2, "{:?}", report(&app, cloth));
}

#[test]
fn bad_triangles_are_dropped_and_counted_and_drawing_keeps_them() {
    let mut app = app();
    let mut mesh = sheet(6);
    let mut points = vectors(&mesh, Mesh::ATTRIBUTE_POSITION).iter().map(Vec3::to_array).collect::<Vec<_>>();
    let isolated = points.len();
    points.push([0.3, 0.2, 0.1]);
    let mut indices: Vec<u32> = mesh.indices().expect("indices").iter().map(|i| i as u32).collect();
    let first = [indices[0], indices[1], indices[2]];
    indices.extend([first[0], first[0], first[1]]); // no area
    indices.extend([first[1], first[0], first[2]]); // back to back
    indices.extend([first[0], first[1], 9999]); // past the end
    let drawn = indices.len();
    mesh = mesh_of(PrimitiveTopology::TriangleList, points, Some(Indices::U32(indices)));
    let cloth = spawn(&mut app, mesh, border());
    run(&mut app, 60);
    assert_eq!(status(&app, cloth), ClothStatus::Active);
    let built = build(&app, cloth);
    assert_eq!((built.degenerate, built.duplicate, built.out_of_range, built.isolated), (1, 1, 1, 1), "{built:?}");
    assert_eq!(shown(&app, cloth).indices().map(Indices::len), Some(drawn));
    assert!(finite(&app, cloth));
    let rides = positions(&app, cloth)[isolated];
    assert!(rides.is_finite() && rides.length() < 3.0, "the isolated vertex is at {rides}");
}

#[test]
fn strips_and_meshes_without_indices_are_cloths() {
    let strip = PrimitiveTopology::TriangleStrip;
    let list = PrimitiveTopology::TriangleList;
    let [a, b, c, d] = [quad()[0], quad()[1], quad()[2], quad()[3]];
    for (name, mesh) in [
        ("strip", mesh_of(strip, quad(), None)),
        ("indexed strip", mesh_of(strip, quad(), Some(Indices::U16(vec![0, 1, 2, 3])))),
        ("strip with a restart", mesh_of(strip, quad(), Some(Indices::U16(vec![0, 1, 2, u16::MAX, 2, 1, 3])))),
        ("list without indices", mesh_of(list, vec![a, b, c, c, b, d], None)),
        ("list with wide indices", mesh_of(list, quad(), Some(Indices::U32(vec![0, 1, 2, 2, 1, 3])))),
        ("list with a torn end", mesh_of(list, quad(), Some(Indices::U32(vec![0, 1, 2, 2, 1, 3, 0])))),
    ] {
        let mut app = app();
        let topology = mesh.primitive_topology();
        let cloth = spawn(&mut app, mesh, ClothPins::vertices([0]));
        run(&mut app, 10);
        assert_eq!(status(&app, cloth), ClothStatus::Active, "{name}: {:?}", app.world().get::<ClothError>(cloth));
        assert_eq!((build(&app, cloth).particles, build(&app, cloth).faces), (4, 2), "{name}");
        assert_eq!(shown(&app, cloth).primitive_topology(), topology, "{name}");
    }
}

#[test]
fn what_cannot_be_simulated_is_drawn_as_authored_and_says_why() {
    use ClothErrorKind::{BadMesh, NoPositions, NotTriangles};
    let list = PrimitiveTopology::TriangleList;
    let four = || Some(Indices::U16(vec![0, 1, 2, 2, 1, 3]));
    for (name, mesh, kind) in [
        ("lines", mesh_of(PrimitiveTopology::LineList, quad(), None), NotTriangles),
        ("points", mesh_of(PrimitiveTopology::PointList, quad(), None), NotTriangles),
        ("no positions", Mesh::new(list, RenderAssetUsages::default()), NoPositions),
        ("empty", mesh_of(list, vec![], None), BadMesh),
        ("one vertex", mesh_of(list, vec![[0.0; 3]], Some(Indices::U16(vec![0, 0, 0]))), BadMesh),
        ("no triangle", mesh_of(list, quad(), Some(Indices::U16(vec![]))), BadMesh),
        ("all past the end", mesh_of(list, quad(), Some(Indices::U16(vec![7, 8, 9]))), BadMesh),
        ("all at one place", mesh_of(list, vec![[1.0; 3]; 4], four()), BadMesh),
        (
            "absurdly far out",
            mesh_of(list, vec![[1.0e10, 0.0, 0.0], [0.0, 1.0e10, 0.0], [0.0; 3], [0.0, 0.0, 1.0e10]], four()),
            BadMesh,
        ),
        ("a position that is not a number", mesh_of(list, vec![[f32::NAN; 3]; 4], four()), BadMesh),
    ] {
        let mut app = app();
        record::<ClothFailed>(&mut app);
        let source = add(&mut app, mesh);
        let cloth = app.world_mut().spawn((Mesh3d(source.clone()), Cloth)).id();
        run(&mut app, 10);
        assert_eq!(status(&app, cloth), ClothStatus::Failed, "{name}");
        assert_eq!(error(&app, cloth), Some(kind), "{name}");
        let detail = &app.world().get::<ClothError>(cloth).expect("an error").detail;
        assert!(name != "absurdly far out" || detail.contains("vertex 0"), "{name}: {detail}");
        assert_eq!(app.world().get::<Mesh3d>(cloth).map(|m| m.0.id()), Some(source.id()), "{name}");
        assert_eq!(seen::<ClothFailed>(&app).len(), 1, "{name}: one event for one failure");
    }
}

#[test]
fn a_mesh_that_is_only_in_the_render_world_fails_with_the_cure_in_the_text() {
    let mut app = app();
    let mut mesh = sheet(5);
    mesh.asset_usage = RenderAssetUsages::RENDER_WORLD;
    mesh.take_gpu_data().expect("data to take");
    let cloth = spawn(&mut app, mesh, ());
    run(&mut app, 3);
    assert_eq!(error(&app, cloth), Some(ClothErrorKind::RenderWorldOnly));
    let detail = &app.world().get::<ClothError>(cloth).expect("an error").detail;
    assert!(detail.contains("RenderAssetUsages::default()"), "{detail}");
}

#[test]
fn a_failure_lifts_itself_when_the_mesh_is_fixed() {
    let mut app = app();
    let source = add(&mut app, mesh_of(PrimitiveTopology::TriangleList, vec![], None));
    let cloth = app.world_mut().spawn((Mesh3d(source.clone()), Cloth)).id();
    run(&mut app, 3);
    assert_eq!(status(&app, cloth), ClothStatus::Failed);
    *app.world_mut().resource_mut::<Assets<Mesh>>().get_mut(&source).expect("the mesh") = sheet(5);
    run(&mut app, 3);
    assert_eq!(status(&app, cloth), ClothStatus::Active);
    assert_eq!(error(&app, cloth), None);
}

#[test]
fn a_mesh_that_arrives_late_is_waited_for() {
    let mut app = app();
    let handle = app.world().resource::<Assets<Mesh>>().reserve_handle();
    let cloth = app.world_mut().spawn((Mesh3d(handle.clone()), Cloth, border())).id();
    run(&mut app, 5);
    assert_eq!(status(&app, cloth), ClothStatus::Waiting(ClothWaitingFor::Asset));
    app.world_mut().resource_mut::<Assets<Mesh>>().insert(handle.id(), sheet(5)).expect("a live handle");
    run(&mut app, 30);
    assert_eq!(status(&app, cloth), ClothStatus::Active);
    assert!(lowest(&world_positions(&app, cloth)) < -0.1);
}

#[test]
fn a_mesh_that_fails_to_load_is_an_error_and_not_waited_for() {
    let mut app = app();
    let handle = app.world().resource::<AssetServer>().load::<Mesh>("there_is/no_such.mesh");
    let cloth = app.world_mut().spawn((Mesh3d(handle), Cloth)).id();
    for _ in 0..200 {
        app.update();
        if status(&app, cloth) == ClothStatus::Failed {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    assert_eq!(error(&app, cloth), Some(ClothErrorKind::LoadFailed), "{:?}", status(&app, cloth));
}

#[test]
fn a_mesh_reloaded_with_the_same_triangles_keeps_the_state() {
    let mut app = app();
    let source = add(&mut app, sheet(8));
    let cloth = app.world_mut().spawn((Mesh3d(source.clone()), Cloth, border())).id();
    run(&mut app, 60);
    let before = particles(&app, cloth);
    let mut painted = sheet(8);
    painted.insert_attribute(Mesh::ATTRIBUTE_COLOR, vec![[1.0, 0.0, 0.0, 1.0]; 64]);
    *app.world_mut().resource_mut::<Assets<Mesh>>().get_mut(&source).expect("the mesh") = painted;
    run(&mut app, 2);
    let after = particles(&app, cloth);
    let moved = before.iter().zip(&after).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    assert!(moved < 0.2, "moved {moved} m by a reload");
    assert!(shown(&app, cloth).contains_attribute(Mesh::ATTRIBUTE_COLOR));
}

#[test]
fn a_mesh_reloaded_with_other_triangles_starts_anew() {
    let mut app = app();
    let source = add(&mut app, sheet(8));
    let cloth = app.world_mut().spawn((Mesh3d(source.clone()), Cloth, border())).id();
    run(&mut app, 60);
    *app.world_mut().resource_mut::<Assets<Mesh>>().get_mut(&source).expect("the mesh") = sheet(11);
    run(&mut app, 2);
    assert_eq!(build(&app, cloth).particles, 121);
    assert_eq!(shown(&app, cloth).count_vertices(), 121);
    assert!(lowest(&world_positions(&app, cloth)) > -0.05, "it starts from its pose at rest");
    run(&mut app, 60);
    assert!(finite(&app, cloth) && lowest(&world_positions(&app, cloth)) < -0.5);
}

#[test]
fn a_swapped_mesh_is_bound_and_the_old_instance_is_gone() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(8), border());
    run(&mut app, 10);
    let old = app.world().get::<Mesh3d>(cloth).expect("a mesh").0.id();
    let other = add(&mut app, sheet(5));
    app.world_mut().entity_mut(cloth).insert(Mesh3d(other.clone()));
    run(&mut app, 5);
    assert_eq!(build(&app, cloth).particles, 25);
    assert_ne!(app.world().get::<Mesh3d>(cloth).map(|m| m.0.id()), Some(other.id()), "the authored mesh is not written");
    assert!(!app.world().resource::<Assets<Mesh>>().contains(old), "the old instance mesh was left behind");
}

#[test]
fn our_own_writing_does_not_bind_again() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(8), border());
    run(&mut app, 5);
    let rest = app.world().get::<ClothRest>(cloth).expect("a rest shape").clone();
    let mesh = app.world().get::<Mesh3d>(cloth).expect("a mesh").0.id();
    for _ in 0..30 {
        app.update();
        assert!(app.world().get::<ClothRest>(cloth).is_some_and(|now| now.is_shared_with(&rest)));
        assert_eq!(app.world().get::<Mesh3d>(cloth).map(|m| m.0.id()), Some(mesh));
    }
}

#[test]
fn two_cloths_of_one_mesh_share_the_rest_shape_and_not_the_mesh() {
    let mut app = app();
    let source = add(&mut app, sheet(8));
    let mut pair = || app.world_mut().spawn((Mesh3d(source.clone()), Cloth)).id();
    let (a, b) = (pair(), pair());
    let pinned = app.world_mut().spawn((Mesh3d(source.clone()), Cloth, border())).id();
    run(&mut app, 30);
    let rest = |e| app.world().get::<ClothRest>(e).expect("a rest shape");
    assert!(rest(a).is_shared_with(rest(b)) && rest(a).is_shared_with(rest(pinned)));
    let id = |e| app.world().get::<Mesh3d>(e).map(|m| m.0.id());
    assert!(id(a) != id(b) && id(a) != Some(source.id()));
    assert_eq!(
        vectors(app.world().resource::<Assets<Mesh>>().get(&source).expect("the source"), Mesh::ATTRIBUTE_POSITION),
        vectors(&sheet(8), Mesh::ATTRIBUTE_POSITION)
    );
    // They start in the same place: which of the two gets past the one that hangs is not said.
    let low = |e| lowest(&world_positions(&app, e));
    assert!(low(a).min(low(b)) < low(pinned), "one falls, one hangs");
}

#[test]
fn a_transform_without_scale_is_waited_for() {
    for scale in [Vec3::ZERO, Vec3::new(1.0, 0.0, 1.0), Vec3::splat(f32::NAN)] {
        let mut app = app();
        let cloth = spawn(&mut app, sheet(5), Transform::from_scale(scale));
        run(&mut app, 5);
        assert_eq!(status(&app, cloth), ClothStatus::Waiting(ClothWaitingFor::Transform), "scale {scale}");
        *app.world_mut().get_mut::<Transform>(cloth).expect("a transform") = Transform::default();
        run(&mut app, 5);
        assert_eq!(status(&app, cloth), ClothStatus::Active, "after scale {scale}");
        assert!(finite(&app, cloth));
    }
}

#[test]
fn scale_is_in_the_rest_lengths_and_a_new_scale_makes_new_ones() {
    let mut app = app();
    // A sheet that shrinks to a third at once crumples; what touched would hold its folds.
    let alone = ClothCollision { self_collision: false, ..default() };
    let cloth = spawn(&mut app, sheet(9), (border(), alone, Transform::from_scale(Vec3::new(2.0, 1.0, 3.0))));
    run(&mut app, 120);
    let bottom = lowest(&world_positions(&app, cloth));
    assert!((-3.3..-2.3).contains(&bottom), "3 m long, lowest point {bottom} m");
    assert!(report(&app, cloth).worst_edge < 1.15, "{:?}", report(&app, cloth));
    app.world_mut().get_mut::<Transform>(cloth).expect("a transform").scale = Vec3::ONE;
    run(&mut app, 120);
    let bottom = lowest(&world_positions(&app, cloth));
    assert!((-1.15..-0.8).contains(&bottom), "1 m long, lowest point {bottom} m");
    assert!(report(&app, cloth).worst_edge < 1.15, "{:?}", report(&app, cloth));
}

#[test]
fn a_mirrored_cloth_keeps_its_normals_outside() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(5), (border(), Transform::from_scale(Vec3::new(-1.0, 1.0, 1.0))));
    run(&mut app, 1);
    for n in vectors(shown(&app, cloth), Mesh::ATTRIBUTE_NORMAL) {
        assert!(n.y > 0.9, "normal {n}");
    }
}

#[test]
fn both_widths_of_indices_are_kept_and_large_meshes_work() {
    let mut app = app();
    let mut narrow = sheet(5);
    narrow.insert_indices(Indices::U16(narrow.indices().expect("indices").iter().map(|i| i as u16).collect()));
    let narrow = spawn(&mut app, narrow, border());
    let wide = spawn(&mut app, sheet(260), border());
    run(&mut app, 3);
    assert!(matches!(shown(&app, narrow).indices(), Some(Indices::U16(_))));
    assert!(matches!(shown(&app, wide).indices(), Some(Indices::U32(_))));
    assert_eq!(build(&app, wide).particles, 260 * 260);
    assert!(finite(&app, wide) && lowest(&world_positions(&app, wide)) < 0.0);
}

#[test]
fn a_scale_at_which_fewer_vertices_are_welded_starts_anew() {
    let mut app = app();
    // A hem so fine that it is one line while the cloth is folded flat along x.
    let columns = [0.0, 0.25, 0.5, 0.75, 1.0, 1.002, 1.004];
    let points: Vec<[f32; 3]> = (0..5).flat_map(|z| columns.map(|x| [x, 0.0, 0.25 * z as f32])).collect();
    let faces = (0..4_u32).flat_map(|z| (0..6).map(move |x| 7 * z + x));
    let indices = faces.flat_map(|v| [v, v + 7, v + 1, v + 1, v + 7, v + 8]).collect();
    let mesh = mesh_of(PrimitiveTopology::TriangleList, points, Some(Indices::U32(indices)));
    let everywhere = ClothPins::where_position(|p| p.z < 0.01);
    let cloth = spawn(&mut app, mesh, (everywhere, Transform::from_scale(Vec3::new(2.0e-3, 1.0, 1.0))));
    run(&mut app, 5);
    assert_eq!(build(&app, cloth).particles, 25);
    for (scale, particles) in [(1.0, 35), (2.0e-3, 25), (-1.0, 35)] {
        app.world_mut().get_mut::<Transform>(cloth).expect("a transform").scale.x = scale;
        run(&mut app, 5);
        assert_eq!((status(&app, cloth), build(&app, cloth).particles), (ClothStatus::Active, particles));
        let time = report(&app, cloth).time;
        run(&mut app, 5);
        assert!(report(&app, cloth).time > time && finite(&app, cloth), "it starts anew once, not in every frame");
    }
}

#[test]
fn a_new_scale_takes_the_pins_along() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(9), (border(), Transform::from_xyz(2.0, 0.0, 0.0).with_scale(Vec3::splat(2.0))));
    run(&mut app, 60);
    app.world_mut().get_mut::<Transform>(cloth).expect("a transform").scale = Vec3::ONE;
    run(&mut app, 1);
    assert!(report(&app, cloth).worst_edge < 1.1, "{:?}", report(&app, cloth));
    assert!(report(&app, cloth).time > 0.5, "it goes on");
}
