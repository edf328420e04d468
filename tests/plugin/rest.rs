//! What lies still stays still, without sleeping: the solver itself brings cloth to rest.

use std::sync::Arc;

use bevy_drape::solver::body::{Body, Pose, shape};
use bevy_drape::solver::rest::RestShape;
use drape_scenes::{self as scenes, Scene, SceneCloth, fabric, grid};
use glam::{Quat, Vec3};

/// Energy [J/kg] and longest way of a particle in a second [m], at their largest in the seconds from `from` to `to`.
fn unrest(scene: &mut Scene, from: usize, to: usize) -> (f32, f32) {
    let (mut energy, mut way) = (0.0_f32, 0.0_f32);
    for second in 0..to {
        let start: Vec<_> = scene.cloths.iter().map(|cloth| cloth.sim.state.positions.clone()).collect();
        for _ in 0..60 {
            scene.step(1.0 / 60.0);
            if second < from {
                continue;
            }
            for (cloth, start) in scene.cloths.iter().zip(&start) {
                let (state, areas) = (&cloth.sim.state, &cloth.rest.areas);
                let sum: f32 = areas.iter().enumerate().map(|(i, area)| 0.5 * area * state.velocity(i).length_squared()).sum();
                energy = energy.max(sum / areas.iter().sum::<f32>());
                let ways = start.iter().zip(&state.positions).map(|(a, b)| a.distance(*b));
                way = ways.fold(way, f32::max);
            }
        }
    }
    (energy, way)
}

fn self_colliding(scene: Scene) -> Scene {
    scene.untangled(Default::default(), Default::default(), true).expect("one cloth")
}

fn floor(n: u32) -> Scene {
    let mut scene = scenes::ball(n);
    scene.bodies =
        vec![Body::at_rest(shape::half_space(Vec3::Y).expect("a plane"), Pose::from_parts(Vec3::Y * 0.3, Quat::IDENTITY))];
    scene
}

#[test]
fn a_sheet_on_the_floor_is_at_rest_within_three_seconds_and_for_a_minute() {
    for n in [32, 64] {
        let (energy, way) = unrest(&mut self_colliding(floor(n)), 3, 60);
        assert!(energy < 1.0e-6 && way < 1.0e-4, "{n}: {energy} J/kg, {way} m in a second");
    }
}

/// Sheets of 1 m, each turned and 3 cm over the one below.
fn pile(sheets: u8, n: u32) -> Scene {
    let cloths = (0..sheets).map(f32::from).map(|i| {
        let turn = Quat::from_rotation_y(0.35 * i);
        sheet(n, turn, Vec3::new(0.03 * i, 0.6 + 0.03 * i, 0.02 * i))
    });
    on_the_ground(cloths.collect())
}

fn sheet(n: u32, turn: Quat, at: Vec3) -> SceneCloth {
    let mesh = grid(n, n, |u, v| turn * Vec3::new(u - 0.5, 0.0, v - 0.5));
    let (rest, _) = RestShape::build(&mesh).expect("a grid");
    SceneCloth::new(Arc::new(rest), fabric(), at, &[])
}

fn on_the_ground(cloths: Vec<SceneCloth>) -> Scene {
    let mut scene = Scene::new(cloths);
    scene.bodies.push(Body::at_rest(shape::half_space(Vec3::Y).expect("a plane"), Pose::IDENTITY));
    scene
}

/// A particle of the rim gives a little now and then, by 0.09 to 0.2 mm as it happens to lie.
#[test]
fn two_sheets_on_the_floor_are_at_rest_within_five_seconds() {
    for seed in 0..2 {
        let (energy, way) = unrest(&mut self_colliding(pile(2, 32).jittered(seed)), 5, 15);
        assert!(energy < 1.0e-6 && way < 2.5e-4, "start {seed}: {energy} J/kg, {way} m in a second");
    }
}

/// Thrown down at an angle it lies in folds that press on each other, and none goes on bouncing. Now and then a fold gives: of
/// twelve starts, by more than 0.25 mm in two, and by 0.97 mm at most.
#[test]
fn a_crumpled_sheet_on_the_floor_is_at_rest_within_ten_seconds() {
    let mut gave = Vec::new();
    for seed in [2, 9, 11] {
        let crumpled = on_the_ground(vec![sheet(64, Quat::from_rotation_x(0.6), Vec3::Y * 0.6)]);
        let (energy, way) = unrest(&mut self_colliding(crumpled.jittered(seed)), 10, 20);
        assert!(energy < 1.0e-6 && way < 1.5e-3, "start {seed}: {energy} J/kg, {way} m in a second");
        gave.extend((way > 2.5e-4).then_some(way));
    }
    assert!(gave.len() <= 1, "{gave:?} m in a second");
}

#[test]
fn a_sheet_over_a_ball_is_at_rest_within_twelve_seconds_and_for_a_minute() {
    for n in [32, 64] {
        let (energy, way) = unrest(&mut scenes::ball(n), 12, 60);
        assert!(energy < 1.0e-6 && way < 1.0e-4, "{n}: {energy} J/kg, {way} m in a second");
    }
}

#[test]
fn cloth_comes_to_rest_with_the_same_bits_on_any_number_of_threads() {
    let run = |threads: usize| {
        let pool = bevy::tasks::TaskPoolBuilder::new().num_threads(threads).build();
        let done: Vec<_> = pool.scope(|scope| {
            for _ in 0..3 {
                scope.spawn(async {
                    let mut scene = self_colliding(scenes::ball(20));
                    (0..300).for_each(|_| scene.step(1.0 / 60.0));
                    scene.cloths.remove(0).sim.state
                });
            }
        });
        done
    };
    assert!(run(1) == run(3), "threads changed the bits");
}
