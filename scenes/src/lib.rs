//! Scenes to measure on, shared by tests, benchmarks and examples. Free of the engine: each is a [`Scene`], which steps itself.

pub mod checker;
mod crosswise;
pub mod curtain;
mod driven;
pub mod funnel;
pub mod heap;
pub mod needles;
mod obj;
mod pinch;
mod pressed;
mod reef_knot;
mod seeds;
pub mod shown;
pub mod skirt;
mod spin;
pub mod stack;
pub mod tablecloth;
mod tangles;
pub mod turning_ball;
pub mod twist;
mod twisted_tube;
mod units;

use std::sync::Arc;

use bevy_drape::solver::body::{Body, Pose, shape};
use bevy_drape::solver::evaluate::EvaluateSettings;
use bevy_drape::solver::island::UntangleSettings;
use bevy_drape::solver::rest::{RestShape, SourceMesh};
pub use bevy_drape::solver::scene::{GRAVITY, Scene, SceneCloth, StageTimes, Untangling, grid};
use bevy_drape::solver::settings::Fabric;
use bevy_drape::solver::wind::{Turbulence, Wind};
use glam::{Quat, Vec3, vec3};

pub use crosswise::crosswise;
pub use curtain::curtain;
pub use driven::driven;
pub use funnel::funnel;
pub use heap::heap;
pub use needles::needles;
pub use obj::obj;
pub use pinch::pinch;
pub use pressed::pressed;
pub use reef_knot::reef_knot;
pub use seeds::{Seed, SeedKind, SeedRun};
pub use skirt::skirt;
pub use spin::{spin, spin_of};
pub use stack::stack;
pub use tablecloth::tablecloth;
pub use tangles::Tangle;
pub use turning_ball::turning_ball;
pub use twist::twist;
pub use twisted_tube::twisted_tube;
pub use units::Unit;

/// The scene with default untangling from now on: each cloth with the others and, if `self_collision`, with itself.
///
/// # Panics
/// With more cloths or particles than an island takes.
#[must_use]
pub fn untangled(scene: Scene, self_collision: bool) -> Scene {
    scene.untangled(UntangleSettings::default(), EvaluateSettings::default(), self_collision).expect("a few cloths")
}

/// Areal density of the cloths in these scenes `[kg/m²]`.
pub const DENSITY: f32 = 0.3;

/// From 0 to 1 as `x` does, slow at both ends.
fn smooth(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// Material of the scenes: the default with [`DENSITY`].
#[must_use]
pub fn fabric() -> Fabric {
    Fabric { density: DENSITY, ..Fabric::default() }
}

fn sheet(n: u32) -> Arc<RestShape> {
    let mesh = grid(n, n, |u, v| vec3(u - 0.5, 0.0, v - 0.5));
    Arc::new(RestShape::build(&mesh).map(|(rest, _)| rest).unwrap_or_default())
}

/// A 1 m sheet of `n` x `n` vertices pinned at two corners, starting flat.
#[must_use]
pub fn hang(n: u32) -> Scene {
    curtains(1, n)
}

/// `k` sheets of [`hang`], 1.5 m apart.
#[must_use]
pub fn curtains(k: u32, n: u32) -> Scene {
    let rest = sheet(n);
    let cloth = |i: u32| SceneCloth::new(rest.clone(), fabric(), vec3(1.5 * i as f32, 0.0, 0.0), &[0, n.max(2) - 1]);
    Scene::new((0..k).map(cloth).collect())
}

/// A 1 m sheet dropped from 0.5 m above the centre of a ball of radius 0.3 m.
#[must_use]
pub fn ball(n: u32) -> Scene {
    let mut scene = Scene::new(vec![SceneCloth::new(sheet(n), fabric(), vec3(0.0, 0.5, 0.0), &[])]);
    scene.bodies.extend(shape::ball(0.3).ok().map(|ball| Body::at_rest(ball, Pose::IDENTITY)));
    scene
}

/// `k` flags of 1 m x 0.7 m, held along one side, in a gusty wind of 8 m/s.
#[must_use]
pub fn flags(k: u32, n: u32) -> Scene {
    let n = n.max(2);
    let mesh = grid(n, n, |u, v| vec3(u, -0.7 * v, 0.0));
    let rest = Arc::new(RestShape::build(&mesh).map(|(rest, _)| rest).unwrap_or_default());
    let pole: Vec<u32> = (0..n).collect();
    let mut scene =
        Scene::new((0..k).map(|i| SceneCloth::new(rest.clone(), fabric(), vec3(0.0, 2.0, 1.5 * i as f32), &pole)).collect());
    scene.wind = Wind {
        velocity: Quat::from_rotation_y(0.2) * vec3(8.0, 0.0, 0.0),
        turbulence: Turbulence { intensity: 0.2, length: 2.0, seed: 7, ..Turbulence::NONE },
        ..Wind::STILL
    };
    scene
}

/// Two 1 m sheets of `n` x `n` vertices, turned by 45 degrees against each other, dropped on a ball of radius 0.3 m.
#[must_use]
pub fn sheets(n: u32) -> Scene {
    layers(2, n)
}

/// `k` sheets of `n` x `n` vertices, 3 cm above each other and each turned by 45 degrees against the one below, dropped on a
/// ball.
#[must_use]
pub fn layers(k: u32, n: u32) -> Scene {
    let cloth = |i: u32| {
        let turn = Quat::from_rotation_y(core::f32::consts::FRAC_PI_4 * i as f32);
        let mesh = grid(n, n, |u, v| turn * vec3(u - 0.5, 0.0, v - 0.5));
        let rest = Arc::new(RestShape::build(&mesh).map(|(rest, _)| rest).unwrap_or_default());
        SceneCloth::new(rest, fabric(), vec3(0.004 * i as f32, 0.4 + 0.03 * i as f32, 0.003 * i as f32), &[])
    };
    let mut scene = Scene::new((0..k.max(1)).map(cloth).collect());
    scene.bodies.extend(shape::ball(0.3).ok().map(|ball| Body::at_rest(ball, Pose::IDENTITY)));
    scene
}

/// Two sheets that start in each other and float.
#[must_use]
pub fn tangle(tangle: Tangle, n: u32) -> Scene {
    let cloth = |mesh: SourceMesh| {
        let rest = Arc::new(RestShape::build(&mesh).map(|(rest, _)| rest).unwrap_or_default());
        SceneCloth::new(rest, fabric(), Vec3::ZERO, &[])
    };
    Scene { gravity: Vec3::ZERO, ..Scene::new(tangle.meshes(n).map(cloth).into()) }
}
