//! Puts body, garments and clips together into one file.

use glam::{Mat4, Vec3};
use serde_json::json;

use crate::anatomy::Anatomy;
use crate::body::{self, REGIONS, Region};
use crate::clips;
use crate::eyes;
use crate::garments::{self, Garment};
use crate::glb::Glb;
use crate::glb::clip::Channel;
use crate::glb::skinned::{Primitive, SkinnedSurface};
use crate::mesh::Mesh;
use crate::skeleton::{self, COUNT, HIPS, NAMES, PARENTS, arm};
use crate::tint;
use crate::weights::{self, Skin};

/// Rounds in which the shares of the body are smoothed.
const SMOOTHING: usize = 5;

/// Layer of forearms and hands; what hangs from the waist lets them through. Swinging along, they pinch it to the thighs.
const HANDS: u32 = 1;

/// The whole file.
pub fn make() -> Vec<u8> {
    let anatomy = Anatomy::default();
    let mut glb = Glb::default();
    let armature = glb.joint("Armature", Vec3::ZERO);
    let bind = skeleton::bind();
    let joints: Vec<usize> =
        (0..COUNT).map(|j| glb.joint(NAMES[j], if j == 0 { Vec3::ZERO } else { bind[j] - bind[PARENTS[j]] })).collect();
    glb.attach(joints[0], armature);
    (1..COUNT).for_each(|j| glb.attach(joints[j], joints[PARENTS[j]]));
    for side in 0..2 {
        // With the hands below them.
        glb.describe(joints[arm(side) + 2], json!({ "collision_memberships": HANDS }));
    }
    let skin = glb.skin(&joints, &bind.map(Mat4::from_translation));

    let (mesh, regions) = body::mesh(&anatomy);
    let worn = Skin { shares: weights::over(&anatomy, &mesh, SMOOTHING), positions: mesh.positions.clone() };
    let body = body_node(&mut glb, mesh, &regions, &worn, skin);
    glb.attach(body, armature);
    for garment in garments::all(&anatomy, &worn) {
        let node = garment_node(&mut glb, garment, skin);
        glb.attach(node, armature);
    }
    for clip in clips::all() {
        let poses = clip.poses();
        let channels: Vec<Channel> = (0..COUNT)
            .map(|j| Channel {
                node: joints[j],
                rotations: rotations(&poses, j),
                translations: if j == HIPS { poses.iter().map(|pose| bind[HIPS] + pose.shift).collect() } else { Vec::new() },
            })
            .collect();
        glb.clip(clip.name, &clip.times(), &channels);
    }
    glb.finish(json!({}))
}

/// Rotations of a joint over time, each in the half of its double cover that is nearest to the one before.
fn rotations(poses: &[skeleton::Pose], joint: usize) -> Vec<glam::Quat> {
    let mut all: Vec<glam::Quat> = poses.iter().map(|pose| pose.rotations[joint].normalize()).collect();
    for i in 1..all.len() {
        if all[i].dot(all[i - 1]) < 0.0 {
            all[i] = -all[i];
        }
    }
    all
}

fn body_node(glb: &mut Glb, mesh: Mesh, regions: &[Region], worn: &Skin, skin: usize) -> usize {
    let (joints, weights) = weights::strongest(&worn.shares);
    let normals = mesh.normals();
    let colors = mesh.positions.iter().map(|&p| tint::of(p)).collect();
    let mut surface = SkinnedSurface { normals, colors, joints, weights, positions: mesh.positions, ..Default::default() };
    let mut primitives: Vec<Primitive> = REGIONS
        .iter()
        .map(|&region| Primitive {
            triangles: mesh.triangles.iter().zip(regions).filter(|(_, r)| **r == region).map(|(t, _)| *t).collect(),
            material: region_material(glb, region),
        })
        .collect();
    let white = glb.named_material("Eyes", [0.78, 0.76, 0.74], 0.25, false);
    let dark = glb.named_material("Iris", [0.045, 0.026, 0.016], 0.15, false);
    let [whites, irises] = eyes::add(&mut surface);
    primitives.push(Primitive { triangles: whites, material: white });
    primitives.push(Primitive { triangles: irises, material: dark });
    let mesh = glb.skinned_mesh("Body", &surface, &primitives);
    glb.skinned_node("Body", mesh, skin, json!({ "collider": "skeleton" }))
}

fn region_material(glb: &mut Glb, region: Region) -> usize {
    let (name, color, roughness) = match region {
        Region::Skin => ("Skin", [0.60, 0.34, 0.235], 0.55),
        Region::Hair => ("Hair", [0.050, 0.026, 0.016], 0.50),
        Region::Boots => ("Boots", [0.055, 0.032, 0.022], 0.45),
        Region::Leggings => ("Leggings", [0.035, 0.037, 0.045], 0.80),
        Region::Top => ("Top", [0.085, 0.088, 0.098], 0.85),
    };
    glb.named_material(name, color, roughness, false)
}

fn garment_node(glb: &mut Glb, garment: Garment, skin: usize) -> usize {
    let material = glb.named_material(garment.name, garment.color, 0.85, true);
    let mesh = glb.skinned_mesh(garment.name, &garment.surface, &[Primitive { triangles: garment.triangles, material }]);
    glb.skinned_node(garment.name, mesh, skin, garment.extras)
}
