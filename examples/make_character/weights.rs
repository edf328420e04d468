//! Which joints move a point of the skin, and how much.

use glam::Vec3;

use crate::anatomy::{Anatomy, folded};
use crate::field::step;
use crate::measures::{ANKLE, ELBOW, KNEE, SHOULDER, TOES, WRIST};
use crate::mesh::Mesh;
use crate::skeleton::{CHEST, COUNT, HEAD, HIPS, NECK, SPINE, arm, leg};

/// Shares of all joints; they sum to 1.
pub type Shares = [f32; COUNT];

/// Shares at a point near the skin.
pub fn shares(anatomy: &Anatomy, p: Vec3) -> Shares {
    let mut shares = [0.0; COUNT];
    let side = usize::from(p.x < 0.0);
    let q = folded(p);
    let arm_share = arm_share(anatomy, q);
    let leg_share = leg_share(q) * (1.0 - arm_share);
    let trunk = 1.0 - arm_share - leg_share;
    trunk_shares(&mut shares, q, side, trunk);
    arm_shares(anatomy, &mut shares, q, side, arm_share);
    let left = step(-0.022, 0.022, p.x);
    for (side, part) in [(0, left), (1, 1.0 - left)] {
        leg_shares(&mut shares, q, side, leg_share * part);
    }
    shares
}

/// How much a point belongs to the arm below the shoulder joint.
fn arm_share(anatomy: &Anatomy, q: Vec3) -> f32 {
    let nearer = anatomy.torso(q).min(anatomy.leg(q)) - anatomy.arm(q).min(anatomy.hand(q));
    step(-0.035, 0.045, nearer) * step(-0.055, 0.060, anatomy.along_upper_arm(q))
}

/// How much a point belongs to a leg below the hip joint: below a line from the groin up to the hip bone.
fn leg_share(q: Vec3) -> f32 {
    let line = 0.850 + 0.42 * (q.x - 0.03).max(0.0) + 0.15 * q.z.max(-0.08);
    step(-0.075, 0.070, line - q.y)
}

fn trunk_shares(shares: &mut Shares, q: Vec3, side: usize, whole: f32) {
    let y = q.y - 0.4 * (q.z + 0.01).min(0.0).abs() * step(1.40, 1.50, q.y);
    let spine = step(0.985, 1.095, y);
    let chest = step(1.115, 1.245, y);
    let neck = step(1.425, 1.495, y + (0.05 - q.x.min(0.10)) * 0.25);
    let head = step(1.515, 1.575, y + 0.35 * q.z.max(0.0));
    let mut rest = whole;
    shares[HEAD] += rest * head;
    rest *= 1.0 - head;
    shares[NECK] += rest * neck;
    rest *= 1.0 - neck;
    let clavicle = step(0.05, 0.15, q.x) * step(1.26, 1.40, q.y) * 0.85;
    shares[arm(side)] += rest * clavicle;
    rest *= 1.0 - clavicle;
    shares[CHEST] += rest * chest;
    rest *= 1.0 - chest;
    shares[SPINE] += rest * spine;
    shares[HIPS] += rest * (1.0 - spine);
}

fn arm_shares(anatomy: &Anatomy, shares: &mut Shares, q: Vec3, side: usize, whole: f32) {
    let length = SHOULDER.distance(ELBOW);
    let lower = step(-0.050, 0.050, anatomy.along_upper_arm(q) - length);
    let hand = step(-0.030, 0.024, anatomy.along_lower_arm(q) - ELBOW.distance(WRIST));
    shares[arm(side) + 1] += whole * (1.0 - lower);
    shares[arm(side) + 2] += whole * lower * (1.0 - hand);
    shares[arm(side) + 3] += whole * lower * hand;
}

fn leg_shares(shares: &mut Shares, q: Vec3, side: usize, whole: f32) {
    let lower = step(-0.060, 0.060, KNEE.y - q.y);
    let foot = step(-0.045, 0.030, ANKLE.y - q.y + 0.35 * (q.z - ANKLE.z - 0.04).max(0.0));
    let toes = step(-0.022, 0.022, q.z - TOES.z) * step(0.12, 0.08, q.y);
    shares[leg(side)] += whole * (1.0 - lower);
    shares[leg(side) + 1] += whole * lower * (1.0 - foot);
    shares[leg(side) + 2] += whole * lower * foot * (1.0 - toes);
    shares[leg(side) + 3] += whole * lower * foot * toes;
}

/// The four largest shares of each vertex.
pub fn strongest(all: &[Shares]) -> (Vec<[u8; 4]>, Vec<[f32; 4]>) {
    all.iter()
        .map(|shares| {
            let mut order: Vec<usize> = (0..COUNT).collect();
            order.sort_by(|&a, &b| shares[b].total_cmp(&shares[a]));
            let top = [order[0], order[1], order[2], order[3]];
            // The last of the four fades out where a fifth is as strong, so that nothing pops in between neighbours.
            let fifth = shares[order[4]];
            let values = top.map(|j| (shares[j] - fifth).max(0.0));
            let sum: f32 = values.iter().sum();
            let kept = values.map(|w| if w / sum < 0.002 { 0.0 } else { w });
            let sum: f32 = kept.iter().sum();
            let joints: [u8; 4] = std::array::from_fn(|k| if kept[k] > 0.0 { top[k] as u8 } else { 0 });
            (joints, kept.map(|w| w / sum))
        })
        .unzip()
}

/// The skin of the body with its shares: cloth that lies on it copies them.
pub struct Skin {
    /// Places of the vertices [m].
    pub positions: Vec<Vec3>,
    /// Their shares.
    pub shares: Vec<Shares>,
}

impl Skin {
    /// Shares of the nearest vertices, the nearer the more.
    pub fn copied(&self, p: Vec3) -> Shares {
        const NEAREST: usize = 6;
        let mut near: Vec<(f32, usize)> = Vec::with_capacity(NEAREST + 1);
        for (i, at) in self.positions.iter().enumerate() {
            let distance = at.distance_squared(p);
            if near.len() == NEAREST && distance >= near[NEAREST - 1].0 {
                continue;
            }
            let slot = near.partition_point(|(d, _)| *d < distance);
            near.insert(slot, (distance, i));
            near.truncate(NEAREST);
        }
        let mut sum = [0.0; COUNT];
        let whole: f32 = near.iter().map(|(d, _)| 1.0 / d).sum();
        for (d, i) in near {
            (0..COUNT).for_each(|k| sum[k] += self.shares[i][k] / (d * whole));
        }
        sum
    }
}

/// Shares at the vertices of a mesh, smoothed along it.
pub fn over(anatomy: &Anatomy, mesh: &Mesh, rounds: usize) -> Vec<Shares> {
    mesh.smoothed(mesh.positions.iter().map(|&p| shares(anatomy, p)).collect(), rounds)
}
