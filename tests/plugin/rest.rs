//! What lies still stays still, without sleeping: the solver itself brings cloth to rest.

use bevy_drape::scenes::{self, Scene};
use bevy_drape::solver::body::{Body, Pose, shape};
use glam::{Quat, Vec3};

/// Energy [J/kg] and longest way of a particle in a second [m], at their largest in the seconds from `from` to `to`.
fn unrest(scene: &mut Scene, from: usize, to: usize) -> (f32, f32) {
    let (mut energy, mut way) = (0.0_f32, 0.0_f32);
    for second in 0..to {
        let start = scene.cloths[0].state.positions.clone();
        for _ in 0..60 {
            scene.step(1.0 / 60.0);
            if second < from {
                continue;
            }
            let cloth = &scene.cloths[0];
            let state = &cloth.state;
            let sum: f32 =
                cloth.rest.areas.iter().enumerate().map(|(i, area)| 0.5 * area * state.velocity(i).length_squared()).sum();
            energy = energy.max(sum / cloth.rest.areas.iter().sum::<f32>());
            let ways = start.iter().zip(&state.positions).map(|(a, b)| a.distance(*b));
            way = ways.fold(way, f32::max);
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
                    scene.cloths.remove(0).state
                });
            }
        });
        done
    };
    assert!(run(1) == run(3), "threads changed the bits");
}
