//! A sheet on a ball that begins to turn on a floor: it winds round the ball and folds on itself (Bridson et al. 2002, "Robust
//! treatment of collisions, contact and friction for cloth animation", figure 1).

use glam::{Quat, Vec3, vec3};

use super::{Scene, SceneCloth, fabric, sheet};
use bevy_drape::solver::body::{Body, Pose, shape};

/// Radius of the ball, which lies on the floor in the plane y = 0 `[m]`.
pub const BALL: f32 = 0.3;
/// When it begins to turn, and how long it takes to its full speed `[s]`; turns per second then `[1/s]`.
pub const SPIN: (f32, f32, f32) = (1.5, 1.0, 0.5);
/// Friction of ball and floor (dimensionless).
const FRICTION: f32 = 0.8;

/// How far the ball has turned after `time` `[s]`.
#[must_use]
pub fn turned(time: f32) -> f32 {
    let (start, ramp, speed) = SPIN;
    let t = (time - start).max(0.0);
    let way = if t < ramp { t * t * t * (1.0 - 0.5 * t / ramp) / (ramp * ramp) } else { t - 0.5 * ramp };
    core::f32::consts::TAU * speed * way
}

/// A 1 m sheet of `n` x `n` vertices, dropped on the ball.
#[must_use]
pub fn turning_ball(n: u32) -> Scene {
    let at = Vec3::Y * BALL;
    let mut scene = Scene::new(vec![SceneCloth::new(sheet(n), fabric(), vec3(0.0, 2.0 * BALL + 0.05, 0.0), &[])]);
    let rough = |body: Body| Body { static_friction: FRICTION, dynamic_friction: FRICTION, ..body };
    let ball = shape::ball(BALL).ok().map(|ball| rough(Body::at_rest(ball, Pose::from_translation(at))));
    let floor = shape::half_space(Vec3::Y).ok().map(|floor| rough(Body::at_rest(floor, Pose::IDENTITY)));
    scene.bodies.extend(ball.into_iter().chain(floor));
    scene.drive = Some(|scene, time| {
        if let Some(ball) = scene.bodies.first_mut() {
            ball.to = Pose::from_parts(Vec3::Y * BALL, Quat::from_rotation_y(turned(time)));
        }
    });
    scene
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ball_is_at_full_speed_after_its_ramp_and_never_jumps() {
        let speed = |time: f32| (turned(time + 0.01) - turned(time)) / 0.01 / core::f32::consts::TAU;
        let (start, ramp, full) = SPIN;
        assert_eq!(turned(start), 0.0);
        assert!((speed(start + ramp + 0.1) - full).abs() < 1.0e-3 && (speed(start + ramp - 0.01) - full).abs() < 0.02);
    }
}
