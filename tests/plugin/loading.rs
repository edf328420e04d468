//! Large meshes are prepared in the background.

use std::time::{Duration, Instant};

use bevy::prelude::*;
use bevy_drape::prelude::*;
use bevy_drape::solver::rest::RestShape;

use crate::common::*;

/// An app that prepares meshes of 100 vertices and more in the background.
fn loading() -> App {
    let mut app = app();
    app.insert_resource(ClothLoading { in_background_from: 100 });
    app
}

/// The shape at rest of a cloth.
fn shape(app: &App, cloth: Entity) -> &RestShape {
    app.world().get::<ClothRest>(cloth).expect("a bound cloth").shape()
}

/// Runs until a cloth waits for its mesh no more; how many frames it took.
fn until_built(app: &mut App, cloth: Entity) -> u32 {
    let start = Instant::now();
    let mut frames = 0;
    while status(app, cloth) == ClothStatus::Waiting(ClothWaitingFor::Build) {
        assert!(start.elapsed() < Duration::from_secs(60), "the mesh is never built");
        std::thread::sleep(Duration::from_millis(1));
        app.update();
        frames += 1;
    }
    frames
}

#[test]
fn a_large_mesh_is_shown_as_authored_while_it_is_built() {
    let mut app = loading();
    let mesh = add(&mut app, sheet(60));
    let cloth = app.world_mut().spawn((Mesh3d(mesh.clone()), Cloth, border())).id();
    app.update();
    assert_eq!(status(&app, cloth), ClothStatus::Waiting(ClothWaitingFor::Build));
    assert_eq!(app.world().get::<Mesh3d>(cloth).expect("a mesh").0, mesh, "the authored mesh");
    // The same mesh and scale are built once.
    let other = app.world_mut().spawn((Mesh3d(mesh), Cloth, border())).id();
    until_built(&mut app, cloth);
    app.update();
    assert_eq!([status(&app, cloth), status(&app, other)], [ClothStatus::Active; 2]);
    assert!(core::ptr::eq(shape(&app, cloth), shape(&app, other)));
    let built = shape(&app, cloth).clone();
    run(&mut app, 30);
    assert!(lowest(&particles(&app, cloth)) < -0.1, "it hangs");

    let mut at_once = self::app();
    let cloth = spawn(&mut at_once, sheet(60), border());
    at_once.update();
    assert_eq!(status(&at_once, cloth), ClothStatus::Active);
    assert!(built == *shape(&at_once, cloth), "the same shape");
}

#[test]
fn small_meshes_and_changes_of_scale_are_not_waited_for() {
    let mut app = loading();
    let small = spawn(&mut app, sheet(9), border());
    app.update();
    assert_eq!(status(&app, small), ClothStatus::Active);
    let large = spawn(&mut app, sheet(30), border());
    app.update();
    until_built(&mut app, large);
    for scale in [Vec3::splat(2.0), Vec3::new(2.0, 1.0, 3.0)] {
        app.world_mut().get_mut::<Transform>(large).expect("a transform").scale = scale;
        app.update();
        assert_eq!(status(&app, large), ClothStatus::Active);
    }
}

#[test]
fn what_is_despawned_swapped_or_changed_while_it_is_built_is_let_go_of() {
    let mut app = loading();
    let gone = spawn(&mut app, sheet(40), border());
    let changed = spawn(&mut app, sheet(40), border());
    let swapped = spawn(&mut app, sheet(40), border());
    app.update();
    app.world_mut().despawn(gone);
    let small = add(&mut app, sheet(9));
    app.world_mut().get_mut::<Mesh3d>(swapped).expect("a mesh").0 = small;
    let handle = app.world().get::<Mesh3d>(changed).expect("a mesh").0.clone();
    *app.world_mut().resource_mut::<Assets<Mesh>>().get_mut(&handle).expect("a mesh") = sheet(20);
    app.update();
    assert_eq!(status(&app, swapped), ClothStatus::Active);
    // What it was may be built before anyone is told that it changed.
    app.update();
    until_built(&mut app, changed);
    assert_eq!(status(&app, changed), ClothStatus::Active);
    assert_eq!(particles(&app, changed).len(), 400, "the mesh as it is now");
    run(&mut app, 10);
    assert!(finite(&app, changed) && finite(&app, swapped));
}

#[test]
fn a_large_mesh_that_is_no_cloth_says_so() {
    let mut app = loading();
    let mesh = mesh_of(&bevy_drape::solver::rest::SourceMesh { positions: vec![Vec3::ONE; 300], ..Default::default() });
    let cloth = spawn(&mut app, mesh, ());
    app.update();
    until_built(&mut app, cloth);
    assert_eq!(status(&app, cloth), ClothStatus::Failed);
    let error = app.world().get::<ClothError>(cloth).expect("an error");
    assert_eq!(error.kind, ClothErrorKind::BadMesh);
}

#[test]
fn a_large_cloth_that_turns_or_grows_while_it_is_built_begins() {
    let mut app = loading();
    let turning = spawn(&mut app, sheet(60), border());
    let growing = spawn(&mut app, sheet(60), border());
    let squashed = spawn(&mut app, sheet(60), border());
    let cloths = [turning, growing, squashed];
    let start = Instant::now();
    let mut frames = 0;
    while cloths.iter().any(|&cloth| status(&app, cloth) != ClothStatus::Active) {
        assert!(start.elapsed() < Duration::from_secs(60), "{:?}", cloths.map(|cloth| status(&app, cloth)));
        frames += 1;
        let mut change = |cloth: Entity, transform: Transform| {
            *app.world_mut().get_mut::<Transform>(cloth).expect("a transform") = transform;
        };
        let (angle, size) = (0.02 * frames as f32, 1.0 + 0.01 * frames as f32);
        change(turning, Transform::from_rotation(Quat::from_axis_angle(Vec3::new(1.0, 2.0, 3.0).normalize(), angle)));
        change(growing, Transform::from_scale(Vec3::splat(size)));
        change(squashed, Transform::from_scale(Vec3::new(1.0, size, 1.0 / size)));
        app.update();
    }
    assert!(cloths.iter().all(|&cloth| finite(&app, cloth)));
}

#[test]
fn a_mesh_that_is_written_in_every_frame_without_being_changed_is_built() {
    let mut app = loading();
    let cloth = spawn(&mut app, sheet(60), border());
    let handle = app.world().get::<Mesh3d>(cloth).expect("a mesh").0.clone();
    let start = Instant::now();
    app.update();
    while status(&app, cloth) == ClothStatus::Waiting(ClothWaitingFor::Build) {
        assert!(start.elapsed() < Duration::from_secs(60), "the mesh is never built");
        // Its normals, say.
        app.world_mut().resource_mut::<Assets<Mesh>>().get_mut(&handle).expect("a mesh").compute_normals();
        app.update();
    }
    assert_eq!(status(&app, cloth), ClothStatus::Active);
}
