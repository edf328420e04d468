//! The joints and their places in the bind pose, an A-pose: feet on y = 0, face to +Z, left side at +X.

use glam::{Quat, Vec3, vec3};

use crate::measures::{ANKLE, ELBOW, HIP, KNEE, SHOULDER, TOES, WRIST};

/// How many joints there are.
pub const COUNT: usize = 22;

pub const ROOT: usize = 0;
pub const HIPS: usize = 1;
pub const SPINE: usize = 2;
pub const CHEST: usize = 3;
pub const NECK: usize = 4;
pub const HEAD: usize = 5;

/// The first joint of an arm: shoulder, upper arm, lower arm and hand follow one another. Side 0 is left.
pub const fn arm(side: usize) -> usize {
    6 + 4 * side
}

/// The first joint of a leg: upper leg, lower leg, foot and toes follow one another. Side 0 is left.
pub const fn leg(side: usize) -> usize {
    14 + 4 * side
}

/// Names of the joints, in their order.
pub const NAMES: [&str; COUNT] = [
    "root",
    "hips",
    "spine",
    "chest",
    "neck",
    "head",
    "shoulder.L",
    "upper_arm.L",
    "lower_arm.L",
    "hand.L",
    "shoulder.R",
    "upper_arm.R",
    "lower_arm.R",
    "hand.R",
    "upper_leg.L",
    "lower_leg.L",
    "foot.L",
    "toes.L",
    "upper_leg.R",
    "lower_leg.R",
    "foot.R",
    "toes.R",
];

/// The joint above each joint; the root is its own.
pub const PARENTS: [usize; COUNT] = [0, 0, 1, 2, 3, 4, 3, 6, 7, 8, 3, 10, 11, 12, 1, 14, 15, 16, 1, 18, 19, 20];

/// +1 on the left, -1 on the right.
pub const fn sign(side: usize) -> f32 {
    if side == 0 { 1.0 } else { -1.0 }
}

/// A place of the left side, or its mirror image on the right.
pub fn mirrored(place: Vec3, side: usize) -> Vec3 {
    vec3(place.x * sign(side), place.y, place.z)
}

/// Places of the joints in the bind pose [m]. All are turned alike: along the axes of the world.
pub fn bind() -> [Vec3; COUNT] {
    let mut places = [Vec3::ZERO; COUNT];
    places[HIPS] = vec3(0.0, 0.95, 0.0);
    places[SPINE] = vec3(0.0, 1.06, -0.008);
    places[CHEST] = vec3(0.0, 1.20, -0.012);
    places[NECK] = vec3(0.0, 1.455, -0.022);
    places[HEAD] = vec3(0.0, 1.545, -0.008);
    for side in 0..2 {
        let arms = [vec3(0.03, 1.405, -0.005), SHOULDER, ELBOW, WRIST];
        let legs = [HIP, KNEE, ANKLE, TOES];
        for part in 0..4 {
            places[arm(side) + part] = mirrored(arms[part], side);
            places[leg(side) + part] = mirrored(legs[part], side);
        }
    }
    places
}

/// How the joints are placed at one moment.
#[derive(Clone)]
pub struct Pose {
    /// How far the hips are from their place in the bind pose [m].
    pub shift: Vec3,
    /// Rotation of each joint against its parent.
    pub rotations: [Quat; COUNT],
}

impl Default for Pose {
    fn default() -> Self {
        Self { shift: Vec3::ZERO, rotations: [Quat::IDENTITY; COUNT] }
    }
}

/// Where joints are in the world: place [m] and rotation.
pub type Places = [(Vec3, Quat); COUNT];

impl Pose {
    /// Where the joints are. Parents come first, so a part of a pose can be placed before the rest is known.
    pub fn places(&self) -> Places {
        let bind = bind();
        let mut places = [(Vec3::ZERO, Quat::IDENTITY); COUNT];
        places[ROOT].1 = self.rotations[ROOT];
        for joint in 1..COUNT {
            let (at, turn) = places[PARENTS[joint]];
            let arm = bind[joint] - bind[PARENTS[joint]] + if joint == HIPS { self.shift } else { Vec3::ZERO };
            places[joint] = (at + turn * arm, (turn * self.rotations[joint]).normalize());
        }
        places
    }
}
