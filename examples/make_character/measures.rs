//! Measures of the figure: 1.75 m high, seven and a half heads.

use glam::{Vec3, vec3};

/// The left shoulder joint [m].
pub const SHOULDER: Vec3 = vec3(0.171, 1.395, -0.018);
/// The left elbow [m].
pub const ELBOW: Vec3 = vec3(0.364, 1.196, -0.026);
/// The left wrist [m].
pub const WRIST: Vec3 = vec3(0.543, 1.020, -0.004);
/// The left hip joint [m].
pub const HIP: Vec3 = vec3(0.090, 0.920, 0.0);
/// The left knee [m].
pub const KNEE: Vec3 = vec3(0.097, 0.500, 0.010);
/// The left ankle [m].
pub const ANKLE: Vec3 = vec3(0.100, 0.088, -0.022);
/// The ball of the left foot, where the toes bend [m].
pub const TOES: Vec3 = vec3(0.108, 0.026, 0.098);
/// The point of the left heel that strikes the ground [m].
pub const HEEL: Vec3 = vec3(0.100, 0.004, -0.090);
/// How far the arms hang out in the bind pose, from straight down [degrees].
pub const ARM_ANGLE: f32 = 45.0;
