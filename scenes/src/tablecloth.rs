//! A cloth on a table that is pulled off by one side, fast, as if what stood on it were to stay.

use glam::{Vec3, vec3};

use super::{Scene, SceneCloth, fabric, sheet};
use bevy_drape::solver::body::{Body, Pose, shape};

/// Half of the sides of the table `[m]`; its top is in the plane y = 0.
pub const TABLE: Vec3 = vec3(0.3, 0.02, 0.3);
/// When it is pulled, and how long that takes to its full speed `[s]`; that speed `[m/s]`.
pub const PULL: (f32, f32, f32) = (1.5, 0.1, 3.0);
/// How far it is pulled `[m]`.
const WAY: f32 = 1.5;
/// Friction of the table: polished wood (dimensionless).
const FRICTION: f32 = 0.3;

/// How far the held side has gone after `time` `[s]`.
#[must_use]
pub fn pulled(time: f32) -> f32 {
    let (start, ramp, speed) = PULL;
    let t = (time - start).max(0.0);
    let way = if t < ramp { 0.5 * t * t / ramp } else { t - 0.5 * ramp };
    (speed * way).min(WAY)
}

/// A 1 m sheet of `n` x `n` vertices over the table, held along the side at `x = 0.5`.
#[must_use]
pub fn tablecloth(n: u32) -> Scene {
    let n = n.max(2);
    let held: Vec<u32> = (n * n - n..n * n).collect();
    let mut scene = Scene::new(vec![SceneCloth::new(sheet(n), fabric(), Vec3::Y * 0.01, &held)]);
    let [x, y, z] = TABLE.to_array();
    scene.bodies.extend(shape::cuboid(vec3(x, y, z)).ok().map(|table| Body {
        static_friction: FRICTION,
        dynamic_friction: FRICTION,
        ..Body::at_rest(table, Pose::from_translation(Vec3::NEG_Y * y))
    }));
    scene.drive = Some(|scene, time| {
        for SceneCloth { rest, anchors, .. } in &mut scene.cloths {
            for (&p, to) in anchors.particles.iter().zip(&mut anchors.to) {
                *to = rest.positions[p as usize] + vec3(pulled(time), 0.01, 0.0);
            }
        }
    });
    scene
}
