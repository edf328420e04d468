//! The controls by which clips move the figure, and how they become a pose.

use glam::{EulerRot, Quat, Vec3, vec3};

use crate::field::step;
use crate::ik;
use crate::measures::{ANKLE, ARM_ANGLE, HEEL, TOES};
use crate::skeleton::{CHEST, HEAD, HIPS, NECK, Pose, ROOT, SPINE, arm, leg, mirrored, sign};

/// A rotation in degrees: to the left about Y, forward about X, and to the right side about Z, in this order.
pub type Turn = [f32; 3];

/// Controls of an arm [degrees]. All zero, it hangs straight down with the palm to the thigh.
#[derive(Clone, Copy, Default)]
pub struct Arm {
    /// To the front.
    pub swing: f32,
    /// Away from the body.
    pub lift: f32,
    /// About its own axis; above zero the bent forearm comes across the body.
    pub twist: f32,
    /// How far the elbow is bent.
    pub elbow: f32,
    /// Turn of the hand about the forearm.
    pub palm: f32,
    /// How far the hand is bent to the palm.
    pub wrist: f32,
    /// How far the shoulder is up.
    pub shrug: f32,
    /// How far the shoulder is to the front.
    pub reach: f32,
}

/// Controls of a leg.
#[derive(Clone, Copy, Default)]
pub struct Foot {
    /// From its place in the bind pose [m]: the sole while it is flat.
    pub at: Vec3,
    /// To the left [degrees].
    pub yaw: f32,
    /// Toes up, about the heel; below zero heel up, about the ball [degrees].
    pub pitch: f32,
    /// How far the toes are bent up [degrees].
    pub toes: f32,
    /// How far the knee points away from the other one [degrees].
    pub knee: f32,
}

impl Foot {
    /// The same foot, turned about its ball.
    pub fn pivoted(self, side: usize, yaw: f32) -> Self {
        let ball = mirrored(TOES - ANKLE, side);
        let turned = |degrees: f32| Quat::from_rotation_y(degrees.to_radians()) * ball;
        Self { at: self.at + turned(self.yaw) - turned(yaw), yaw, ..self }
    }
}

/// All controls.
#[derive(Clone, Copy, Default)]
pub struct Rig {
    /// Turn of the whole figure, to the left [degrees].
    pub spin: f32,
    /// Hips from their place in the bind pose [m].
    pub hips: Vec3,
    pub hips_turn: Turn,
    pub spine: Turn,
    pub chest: Turn,
    /// Where the head looks, against the direction of the chest.
    pub look: Turn,
    /// How much the head stays level while the chest tilts: 0 to 1.
    pub level: f32,
    pub arms: [Arm; 2],
    pub feet: [Foot; 2],
}

/// How many numbers a rig has.
pub const CONTROLS: usize = 1 + 3 + 4 * 3 + 1 + 2 * 8 + 2 * 7;
/// The first number of the feet.
pub const FEET: usize = CONTROLS - 2 * 7;
/// The first number of the arms.
pub const ARMS: usize = FEET - 2 * 8;

impl Rig {
    /// All controls as numbers.
    pub fn numbers(&self) -> [f32; CONTROLS] {
        let mut all = Vec::with_capacity(CONTROLS);
        all.push(self.spin);
        all.extend(self.hips.to_array());
        for turn in [self.hips_turn, self.spine, self.chest, self.look] {
            all.extend(turn);
        }
        all.push(self.level);
        for a in self.arms {
            all.extend([a.swing, a.lift, a.twist, a.elbow, a.palm, a.wrist, a.shrug, a.reach]);
        }
        for f in self.feet {
            all.extend(f.at.to_array());
            all.extend([f.yaw, f.pitch, f.toes, f.knee]);
        }
        std::array::from_fn(|i| all[i])
    }

    /// Controls from their numbers.
    pub fn from_numbers(n: &[f32; CONTROLS]) -> Self {
        let turn = |i: usize| [n[i], n[i + 1], n[i + 2]];
        let arm = |i: usize| Arm {
            swing: n[i],
            lift: n[i + 1],
            twist: n[i + 2],
            elbow: n[i + 3],
            palm: n[i + 4],
            wrist: n[i + 5],
            shrug: n[i + 6],
            reach: n[i + 7],
        };
        let foot = |i: usize| Foot {
            at: vec3(n[i], n[i + 1], n[i + 2]),
            yaw: n[i + 3],
            pitch: n[i + 4],
            toes: n[i + 5],
            knee: n[i + 6],
        };
        Self {
            spin: n[0],
            hips: vec3(n[1], n[2], n[3]),
            hips_turn: turn(4),
            spine: turn(7),
            chest: turn(10),
            look: turn(13),
            level: n[16],
            arms: [arm(ARMS), arm(ARMS + 8)],
            feet: [foot(FEET), foot(FEET + 7)],
        }
    }

    /// The pose of these controls. Feet stand in the frame of the root, whatever the hips do.
    pub fn pose(&self) -> Pose {
        let mut pose = Pose { shift: self.hips, ..Pose::default() };
        pose.rotations[ROOT] = Quat::from_rotation_y(self.spin.to_radians());
        pose.rotations[HIPS] = turn(self.hips_turn);
        pose.rotations[SPINE] = turn(self.spine);
        pose.rotations[CHEST] = turn(self.chest);
        self.head(&mut pose);
        for side in 0..2 {
            self.arm(&mut pose, side);
            self.leg(&mut pose, side);
        }
        pose
    }

    fn head(&self, pose: &mut Pose) {
        let chest = pose.places()[CHEST].1;
        let front = chest * Vec3::Z;
        let upright = Quat::from_rotation_y(front.x.atan2(front.z));
        let kept = chest.slerp(upright, self.level);
        let local = chest.inverse() * kept * turn(self.look);
        let half = Quat::IDENTITY.slerp(local, 0.45);
        pose.rotations[NECK] = half;
        pose.rotations[HEAD] = half.inverse() * local;
    }

    fn arm(&self, pose: &mut Pose, side: usize) {
        let s = sign(side);
        let a = self.arms[side];
        let angle = |degrees: f32| degrees.to_radians();
        let hang = Quat::from_rotation_z(-s * angle(ARM_ANGLE));
        let shoulder = Quat::from_rotation_z(s * angle(a.shrug)) * Quat::from_rotation_y(-s * angle(a.reach));
        let upper = Quat::from_rotation_x(-angle(a.swing))
            * Quat::from_rotation_z(s * angle(a.lift))
            * Quat::from_rotation_y(-s * angle(a.twist))
            * hang;
        let in_hang = |q: Quat| hang.inverse() * q * hang;
        pose.rotations[arm(side)] = shoulder;
        pose.rotations[arm(side) + 1] = upper;
        let twist = Quat::from_rotation_y(-s * angle(a.palm));
        // Half of the turn of the hand is in the forearm, as two bones cross there.
        let half = Quat::IDENTITY.slerp(twist, 0.5);
        pose.rotations[arm(side) + 2] = in_hang(Quat::from_rotation_x(-angle(a.elbow)) * half);
        pose.rotations[arm(side) + 3] = in_hang(half * Quat::from_rotation_z(-s * angle(a.wrist)));
    }

    fn leg(&self, pose: &mut Pose, side: usize) {
        let foot = self.feet[side];
        let root = pose.rotations[ROOT];
        let yaw = Quat::from_rotation_y(foot.yaw.to_radians());
        let turned = yaw * Quat::from_rotation_x(-foot.pitch.to_radians());
        let (ankle, heel, ball) = (mirrored(ANKLE, side), mirrored(HEEL, side), mirrored(TOES, side));
        // The sole rolls about the heel or about the ball; between them the change is soft.
        let share = step(-ROLL, ROLL, foot.pitch);
        let pivot = ball.lerp(heel, share);
        let flat = ankle + foot.at;
        let target = root * (flat + yaw * (pivot - ankle) + turned * (ankle - pivot));
        let outward = sign(side) * foot.knee.to_radians();
        ik::leg(pose, side, target, root * turned, outward);
        pose.rotations[leg(side) + 3] = Quat::from_rotation_x(-foot.toes.to_radians());
    }
}

/// Half of the range in which the sole changes from heel to ball [degrees].
const ROLL: f32 = 6.0;

fn turn([yaw, forward, side]: Turn) -> Quat {
    Quat::from_euler(EulerRot::YXZ, yaw.to_radians(), forward.to_radians(), side.to_radians())
}
