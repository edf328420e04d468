//! Snapshots: what follows has the same bits as what followed the first time.

use bevy::ecs::component::Mutable;
use bevy::ecs::system::RunSystemOnce;
use bevy::prelude::*;
use bevy_drape::prelude::*;
use bevy_drape::{ClothParticles, ClothPose, ClothSnapshot};
use drape_scenes::Tangle;

use crate::bits::{InApp, in_apps, ten_before};
use crate::common::*;

/// An app and what the app itself does before each frame.
pub struct Played {
    pub app: App,
    pub happen: Box<dyn Fn(&mut App, u32)>,
}

/// What the app has to restore by itself.
struct Own {
    transforms: Vec<(Entity, Transform)>,
    grabs: Vec<(Entity, ClothGrab)>,
    solvers: Vec<(Entity, ClothSolver)>,
}

fn copies<T: Component + Clone>(app: &mut App) -> Vec<(Entity, T)> {
    app.world_mut().query::<(Entity, &T)>().iter(app.world()).map(|(entity, value)| (entity, value.clone())).collect()
}

/// Writes only what differs.
fn put<T: Component<Mutability = Mutable> + Clone + PartialEq>(app: &mut App, copies: &[(Entity, T)]) {
    for (entity, value) in copies {
        if let Some(mut now) = app.world_mut().get_mut::<T>(*entity) {
            now.set_if_neq(value.clone());
        }
    }
}

impl Own {
    fn of(app: &mut App) -> Self {
        Self { transforms: copies(app), grabs: copies(app), solvers: copies(app) }
    }

    fn restore(&self, app: &mut App) {
        put(app, &self.transforms);
        put(app, &self.grabs);
        put(app, &self.solvers);
    }
}

impl Played {
    fn new(app: App) -> Self {
        Self { app, happen: Box::new(|_, _| {}) }
    }

    /// Every bit of every frame.
    fn play(&mut self, frames: core::ops::Range<u32>) -> Vec<u32> {
        let mut bits = Vec::new();
        for frame in frames {
            (self.happen)(&mut self.app, frame);
            self.app.update();
            let mut cloths = self.app.world_mut().query::<(Entity, &ClothParticles, &ClothReport)>();
            let mut cloths: Vec<_> = cloths.iter(self.app.world()).collect();
            cloths.sort_by_key(|(entity, ..)| *entity);
            for (_, particles, report) in cloths {
                bits.extend(particles.shown_positions().flat_map(|x| x.as_vec3().to_array()).map(f32::to_bits));
                bits.push(report.worst_edge.to_bits());
                bits.extend([report.crossings, report.substeps, u32::from(report.asleep)]);
            }
        }
        bits
    }
}

fn moving(app: &mut App, step: impl Fn(&mut Transform)) {
    for mut transform in app.world_mut().query_filtered::<&mut Transform, With<Name>>().iter_mut(app.world_mut()) {
        step(&mut transform);
    }
}

/// Apps with cloth that does what cloth does.
pub fn played() -> Vec<(&'static str, Played)> {
    let mut over_ball = app();
    over_ball.world_mut().spawn((Transform::default(), ClothCollider::ball(0.3)));
    spawn(&mut over_ball, sheet(16), Transform::from_xyz(0.0, 0.4, 0.0));
    spawn(&mut over_ball, sheet(12), Transform::from_xyz(0.0, 0.5, 0.0));
    let mut windy = app();
    windy.insert_resource(ClothGlobalWind { velocity: Vec3::X * 8.0, turbulence: 0.5, ..default() });
    spawn(&mut windy, sheet(14), border());
    spawn(&mut windy, sheet(12), (border(), Transform::from_xyz(0.3, 0.0, 3.0)));
    let mut net = app();
    let body = (
        Transform::from_xyz(0.1, 0.4, 0.05),
        ClothCollider::ball(0.15),
        ClothCoupling::TwoWay,
        ClothRigidBody { inverse_mass: Vec3::splat(2.0), ..default() },
    );
    net.world_mut().spawn(body);
    spawn(&mut net, sheet(14), (border(), ClothMaterial::RUBBER));
    let mut carried = app();
    spawn(&mut carried, sheet(12), (border(), Name::new("moves")));
    carried.world_mut().spawn((Transform::from_xyz(0.3, -0.4, 0.3), ClothCollider::ball(0.2), Name::new("moves")));
    let mut tangled = app();
    for mesh in Tangle::FullCut.meshes(14) {
        spawn(&mut tangled, mesh_of(&mesh), Transform::from_xyz(0.0, 1.0, 0.0));
    }
    let mut grabbed = app();
    spawn(&mut grabbed, sheet(12), border());
    run(&mut grabbed, 2);
    let hit = grabbed.world_mut().run_system_once(|cloths: ClothQuery| cloths.nearest_point(Vec3::new(0.1, 0.0, 0.3), 1.0));
    grabbed.world_mut().spawn(ClothGrab::at(&hit.expect("a system").expect("a cloth")));
    let mut asleep = app();
    asleep.world_mut().spawn(ClothCollider::ground());
    let [sleeper, other] = [0.01, 0.02].map(|y| spawn(&mut asleep, sheet(10), Transform::from_xyz(0.0, y, 0.0)));
    spawn(&mut asleep, sheet(8), Transform::from_xyz(3.0, 0.3, 0.0));
    run(&mut asleep, 300);
    assert!(report(&asleep, sleeper).asleep && report(&asleep, other).asleep);
    let mut ticks = app_with(ClothPlugin::new(FixedPostUpdate));
    spawn(&mut ticks, sheet(12), border());
    vec![
        ("over a ball", Played::new(over_ball)),
        ("asleep", Played::new(asleep)),
        ("fixed schedule", Played::new(ticks)),
        ("windy", Played::new(windy)),
        ("net", Played::new(net)),
        (
            "carried",
            Played {
                app: carried,
                happen: Box::new(|app, frame| {
                    moving(app, |at| at.translation.x += if frame == 70 { 500.0 } else { 0.02 });
                }),
            },
        ),
        ("tangled", Played::new(tangled)),
        (
            "grabbed",
            Played {
                app: grabbed,
                happen: Box::new(|app, frame| {
                    for mut grab in app.world_mut().query::<&mut ClothGrab>().iter_mut(app.world_mut()) {
                        grab.target.y += 0.005 * (0.1 * frame as f32).sin();
                    }
                }),
            },
        ),
    ]
}

/// Goes back to snapshots of some `frames`, ascending, and plays `after` frames from each, as often as that.
fn goes_back(name: &str, scene: &mut Played, frames: &[u32], after: u32, times: u32) {
    let mut at = 0;
    for &frame in frames {
        scene.play(at..frame);
        let (snapshot, own) = (ClothSnapshot::capture(scene.app.world_mut()), Own::of(&mut scene.app));
        let first = scene.play(frame..frame + after);
        let back = |scene: &mut Played| {
            snapshot.restore(scene.app.world_mut()).expect("the same cloths");
            own.restore(&mut scene.app);
        };
        for again in 0..times {
            back(scene);
            let differs = scene.play(frame..frame + after).iter().zip(&first).position(|(a, b)| a != b);
            assert_eq!(differs, None, "{name}: frame {frame}, time {again}, of {}", first.len());
        }
        back(scene);
        at = frame;
    }
}

#[test]
fn what_follows_a_restored_snapshot_has_the_same_bits_as_before() {
    for (name, mut scene) in played() {
        goes_back(name, &mut scene, &[1, 2, 5, 17, 40, 64, 90, 133], 60, 2);
    }
}

#[test]
fn every_hashed_app_goes_back_to_ten_frames_and_on_with_the_same_bits() {
    for (seed, InApp { name, app, frames, happen }) in (0..).zip(in_apps()) {
        goes_back(name, &mut Played { app, happen }, &ten_before(frames, seed), 120, 1);
    }
}

#[test]
fn what_slept_on_something_that_is_gone_falls() {
    let mut app = app();
    app.world_mut().spawn(ClothCollider::ground());
    let lower = spawn(&mut app, sheet(10), Transform::from_xyz(0.0, 0.01, 0.0));
    let upper = spawn(&mut app, sheet(10), Transform::from_xyz(0.0, 0.02, 0.0));
    run(&mut app, 300);
    assert!(report(&app, lower).asleep && report(&app, upper).asleep);
    let snapshot = ClothSnapshot::capture(app.world_mut());
    app.world_mut().despawn(lower);
    run(&mut app, 60);
    let error = snapshot.restore(app.world_mut()).expect_err("one is gone");
    assert_eq!(error.cloths, [lower]);
    let high = lowest(&particles(&app, upper));
    run(&mut app, 60);
    assert!(lowest(&particles(&app, upper)) < high - 0.003, "from {high} to {}", lowest(&particles(&app, upper)));
}

#[test]
fn a_cloth_that_failed_goes_back_to_when_it_had_not() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(10), border());
    run(&mut app, 30);
    let (snapshot, before) = (ClothSnapshot::capture(app.world_mut()), particles(&app, cloth));
    for _ in 0..80 {
        let mut particles = app.world_mut().get_mut::<ClothParticles>(cloth).expect("a cloth");
        particles.state_mut().positions[50].x = f32::NAN;
        app.update();
    }
    assert_eq!(status(&app, cloth), ClothStatus::Failed);
    snapshot.restore(app.world_mut()).expect("its shape at rest is the same");
    assert_eq!((status(&app, cloth), particles(&app, cloth)), (ClothStatus::Active, before));
    run(&mut app, 30);
    assert!(
        status(&app, cloth) == ClothStatus::Active
            && finite(&app, cloth)
            && !app.world().entity(cloth).contains::<ClothError>()
    );
}

#[test]
fn nothing_is_in_a_snapshot_of_a_world_without_cloth_and_nothing_of_another_is_restored() {
    let mut empty = World::new();
    let nothing = ClothSnapshot::capture(&mut empty);
    assert_eq!(nothing.cloths().count(), 0);
    nothing.restore(&mut empty).expect("nothing to do");
    let mut app = app();
    let cloth = spawn(&mut app, sheet(6), border());
    run(&mut app, 5);
    let snapshot = ClothSnapshot::capture(app.world_mut());
    assert_eq!(snapshot.restore(&mut empty).expect_err("another world").cloths, [cloth]);
    let mut twin = crate::common::app();
    spawn(&mut twin, sheet(6), border());
    run(&mut twin, 9);
    assert_eq!(snapshot.restore(twin.world_mut()).expect_err("another world").cloths, [cloth]);
}

/// In the order of entities.
fn sorted<const N: usize>(mut entities: [Entity; N]) -> [Entity; N] {
    entities.sort_unstable();
    entities
}

#[test]
fn what_cannot_be_put_back_is_named_and_the_rest_is() {
    let mut app = app();
    let [stays, goes, changes, later] = [0.0, 0.2, 3.0, 6.0].map(|x| Transform::from_xyz(x, 0.0, 0.0));
    let stays = spawn(&mut app, sheet(10), (border(), stays));
    let goes = spawn(&mut app, sheet(10), (border(), goes));
    let changes = spawn(&mut app, sheet(10), (border(), changes));
    run(&mut app, 20);
    let snapshot = ClothSnapshot::capture(app.world_mut());
    assert_eq!(snapshot.cloths().collect::<Vec<_>>(), sorted([stays, goes, changes]));
    let before = particles(&app, stays);
    app.world_mut().despawn(goes);
    let mesh = add(&mut app, sheet(6));
    app.world_mut().entity_mut(changes).insert(Mesh3d(mesh));
    let later = spawn(&mut app, sheet(8), (border(), later));
    run(&mut app, 20);
    let changed = particles(&app, changes);
    let error = snapshot.restore(app.world_mut()).expect_err("two are not what they were");
    assert_eq!(error.cloths, sorted([goes, changes]));
    assert_eq!((particles(&app, stays), particles(&app, changes)), (before, changed));
    run(&mut app, 20);
    for cloth in [stays, changes, later] {
        assert!(finite(&app, cloth) && status(&app, cloth) == ClothStatus::Active);
    }
}

#[test]
fn one_cloth_goes_back_and_its_neighbour_does_not() {
    let mut app = app();
    app.world_mut().spawn((Transform::default(), ClothCollider::ball(0.3)));
    let lower = spawn(&mut app, sheet(12), Transform::from_xyz(0.0, 0.32, 0.0));
    let upper = spawn(&mut app, sheet(12), Transform::from_xyz(0.0, 0.36, 0.0));
    run(&mut app, 10);
    let snapshot = ClothSnapshot::capture_of(app.world_mut(), &[upper]);
    let before = particles(&app, upper);
    run(&mut app, 60);
    let below = particles(&app, lower);
    snapshot.restore(app.world_mut()).expect("it is there");
    assert_eq!((particles(&app, upper), particles(&app, lower)), (before, below));
    run(&mut app, 60);
    assert!(finite(&app, upper) && report(&app, upper).worst_edge < 1.3);
}

#[test]
fn pins_that_were_not_bound_yet_are_bound_after_it_went_back() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(10), border());
    run(&mut app, 20);
    app.world_mut().entity_mut(cloth).insert(ClothPins::default());
    let snapshot = ClothSnapshot::capture(app.world_mut());
    run(&mut app, 10);
    snapshot.restore(app.world_mut()).expect("it is there");
    run(&mut app, 1);
    assert_eq!(report(&app, cloth).pinned, 0);
}

#[test]
fn pins_set_since_hold_the_cloth_as_it_was() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(10), border());
    run(&mut app, 20);
    let snapshot = ClothSnapshot::capture(app.world_mut());
    app.world_mut().entity_mut(cloth).insert(ClothPins::default());
    run(&mut app, 10);
    assert_eq!(report(&app, cloth).pinned, 0);
    snapshot.restore(app.world_mut()).expect("it is there");
    run(&mut app, 1);
    assert_eq!(report(&app, cloth).pinned, 0);
    app.world_mut().entity_mut(cloth).insert(border());
    snapshot.restore(app.world_mut()).expect("it is there");
    run(&mut app, 1);
    assert!(report(&app, cloth).pinned > 0);
}

/// The pose of a cloth, through a file.
fn saved(app: &App, cloth: Entity) -> ClothPose {
    let pose = app.world().get::<ClothParticles>(cloth).expect("a cloth").pose();
    let mut file = Vec::new();
    ciborium::into_writer(&pose, &mut file).expect("memory");
    let read = ciborium::from_reader(&*file).expect("a pose");
    assert!(pose == read, "a number changed on its way");
    read
}

/// How far apart the particles of two cloths are at most [m].
fn apart(a: &[Vec3], b: &[Vec3]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
}

#[test]
fn a_pose_goes_through_a_file_into_another_world_and_on_as_before() {
    for fixed in [false, true] {
        let clock = || if fixed { ClothPlugin::new(FixedPostUpdate) } else { ClothPlugin::default() };
        let start = || {
            let mut app = app_with(clock());
            app.world_mut().spawn((Transform::default(), ClothCollider::ball(0.3)));
            let cloth = spawn(&mut app, sheet(16), Transform::from_xyz(0.0, 0.4, 0.0));
            (app, cloth)
        };
        let (mut app, cloth) = start();
        run(&mut app, 40);
        let pose = saved(&app, cloth);
        // At once, before it is bound, and after it lay still for a while.
        for frames in [0, 1, 400] {
            let (mut other, loaded) = start();
            run(&mut other, frames);
            other.world_mut().entity_mut(loaded).insert(pose.clone());
            run(&mut other, 2);
            assert!(!other.world().entity(loaded).contains::<ClothPose>());
            let moved = apart(&particles(&app, cloth), &particles(&other, loaded));
            assert!(moved < 0.06, "{frames}: {moved} m in the first frames");
            run(&mut other, 18);
            let (mut first, at) = (start(), 60);
            run(&mut first.0, at);
            let off = apart(&particles(&first.0, first.1), &particles(&other, loaded));
            assert!(off < 0.03 && report(&other, loaded).restores == 0, "{frames}: {off} m after a third of a second");
        }
    }
}

#[test]
fn a_pose_goes_with_the_transform_that_is_loaded_along_with_it() {
    let (mut app, mut other) = (app(), app());
    let [cloth, loaded] = [&mut app, &mut other].map(|app| spawn(app, sheet(12), border()));
    run(&mut app, 30);
    app.world_mut().get_mut::<Transform>(cloth).expect("one").translation = Vec3::new(40.0, 1.0, -7.0);
    run(&mut app, 30);
    let (pose, place) = (saved(&app, cloth), *app.world().get::<Transform>(cloth).expect("one"));
    run(&mut other, 5);
    other.world_mut().entity_mut(loaded).insert((place, pose));
    run(&mut other, 1);
    run(&mut app, 1);
    let off = apart(&particles(&app, cloth), &particles(&other, loaded));
    assert!(off < 1.0e-3, "{off} m");
}

#[test]
fn a_pose_beyond_a_thin_body_stays_there_and_speed_comes_with_it() {
    let mut app = app();
    let (corners, faces) =
        (vec![Vec3::new(-9.0, 0.0, -9.0), Vec3::new(9.0, 0.0, -9.0), Vec3::new(0.0, 0.0, 12.0)], vec![[0, 2, 1]]);
    app.world_mut().spawn(ClothCollider::tri_mesh(corners, faces));
    let cloth = spawn(&mut app, sheet(10), Transform::from_xyz(0.0, 0.02, 0.0));
    run(&mut app, 60);
    let mut pose = saved(&app, cloth);
    assert!(pose.positions.iter().all(|p| p.y > 0.0));
    pose.positions.iter_mut().for_each(|p| p.y -= 0.03);
    pose.velocities.fill(Vec3::NEG_Y * 3.0);
    app.world_mut().entity_mut(cloth).insert(pose);
    run(&mut app, 12);
    let low = lowest(&particles(&app, cloth));
    assert!((-1.2..-0.25).contains(&low), "{low} m");
}

#[test]
fn a_pose_that_does_not_fit_changes_nothing_and_is_taken_off() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet(8), border());
    run(&mut app, 300);
    let (before, pose) = (particles(&app, cloth), saved(&app, cloth));
    let fewer = ClothPose { positions: pose.positions[1..].to_vec(), ..pose.clone() };
    let wrong = [(f64::NAN, 0.0), (1.0e9, 0.0), (0.0, f32::INFINITY)].map(|(bad, velocity)| {
        let mut wrong = pose.clone();
        (wrong.positions[30].x, wrong.velocities[30].y) = (bad, velocity);
        wrong
    });
    for bad in wrong.into_iter().chain([fewer, ClothPose::default()]) {
        app.world_mut().entity_mut(cloth).insert(bad);
        run(&mut app, 1);
        assert!(!app.world().entity(cloth).contains::<ClothPose>());
        assert!(apart(&particles(&app, cloth), &before) < 0.02);
    }
}

#[test]
fn a_cloth_that_faded_into_its_skin_since_goes_back_to_when_it_was_simulated() {
    let mut app = app();
    let (cloth, joints) = crate::skinned::dressed(&mut app, 8, (ClothLimits::default(), ClothBlend::default()));
    let frames = |app: &mut App, from: u32, count: u32| {
        for frame in from..from + count {
            (0..2).for_each(|i| crate::skinned::put(app, joints[i], crate::skinned::dance(frame as f32 / 60.0, i as f32)));
            run(app, 1);
        }
    };
    let set = |app: &mut App, weight: f32| {
        app.world_mut().get_mut::<ClothBlend>(cloth).expect("a blend").set_if_neq(ClothBlend { weight, ..default() });
    };
    frames(&mut app, 0, 60);
    let poses: Vec<(Entity, Transform)> = copies::<Transform>(&mut app);
    let before = ClothSnapshot::capture(app.world_mut());
    frames(&mut app, 60, 20);
    let first = particles(&app, cloth);
    set(&mut app, 0.0);
    frames(&mut app, 80, 60);
    assert_eq!(report(&app, cloth).substeps, 0, "it is only animated");
    set(&mut app, 1.0);
    put(&mut app, &poses);
    before.restore(app.world_mut()).expect("all cloths");
    frames(&mut app, 60, 20);
    assert!(particles(&app, cloth) == first, "other bits");
    assert!(app.world().get::<bevy::mesh::skinning::SkinnedMesh>(cloth).is_none());
}
