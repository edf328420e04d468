//! Characters as artists make them.

use std::time::Instant;

use bevy_drape::character::{BoneCollider, BoneShape, FitSettings, SkinnedBody, fit, measure};
use glam::{Affine3A, Mat4, Vec3};

/// A character read from a file: all its meshes with a skin, except clothes: primitives of nodes.
struct Character {
    positions: Vec<Vec3>,
    joints: Vec<[u16; 4]>,
    weights: Vec<[f32; 4]>,
    inverse_binds: Vec<Affine3A>,
    parents: Vec<Option<usize>>,
    names: Vec<String>,
    unit: f32,
}

impl Character {
    fn read(name: &str, clothes: &[(&str, usize)], unit: f32) -> Option<Self> {
        let bytes = std::fs::read(drape_tests::data("characters")?.join(name)).expect("a file");
        let file = gltf::Gltf::from_slice(&bytes).expect("a glTF file");
        let blob = file.blob.as_deref();
        let skin = file.skins().next().expect("a skin");
        let binds = skin.reader(|_| blob).read_inverse_bind_matrices().expect("inverse bind matrices");
        let joints: Vec<gltf::Node> = skin.joints().collect();
        let is_parent = |parent: &gltf::Node, of: usize| parent.children().any(|child| child.index() == of);
        let parent = |joint: &gltf::Node| joints.iter().position(|other| is_parent(other, joint.index()));
        let mut character = Self {
            positions: Vec::new(),
            joints: Vec::new(),
            weights: Vec::new(),
            inverse_binds: binds.map(|bind| Affine3A::from_mat4(Mat4::from_cols_array_2d(&bind))).collect(),
            parents: joints.iter().map(parent).collect(),
            names: joints.iter().map(|joint| joint.name().unwrap_or_default().to_owned()).collect(),
            unit,
        };
        for node in file.nodes().filter(|node| node.skin().is_some()) {
            let name = node.name().unwrap_or_default();
            for primitive in node.mesh().iter().flat_map(gltf::Mesh::primitives) {
                if clothes.contains(&(name, primitive.index())) {
                    continue;
                }
                let reader = primitive.reader(|_| blob);
                character.positions.extend(reader.read_positions().expect("positions").map(Vec3::from));
                character.joints.extend(reader.read_joints(0).expect("joints").into_u16());
                character.weights.extend(reader.read_weights(0).expect("weights").into_f32());
            }
        }
        Some(character)
    }

    fn body(&self) -> SkinnedBody<'_> {
        SkinnedBody {
            positions: &self.positions,
            joints: &self.joints,
            weights: &self.weights,
            inverse_binds: &self.inverse_binds,
            parents: &self.parents,
            unit: self.unit,
        }
    }

    /// Colliders by default settings; prints a table of them and the time it took.
    #[expect(clippy::print_stdout, reason = "a table to read")]
    fn fitted(&self) -> Vec<BoneCollider> {
        let start = Instant::now();
        let colliders = fit(&self.body(), &FitSettings::default());
        let time = start.elapsed();
        println!("joint            radius  half length  margin    p50    p95    max [mm]");
        for BoneCollider { joint, shape, unit, margin, outside, .. } in &colliders {
            let shape = match shape {
                BoneShape::Capsule { a, b, radius } => {
                    format!("{:6.1} {:12.1}", radius * unit * 1e3, a.distance(*b) * unit * 500.0)
                }
                BoneShape::Hull { points } => format!("hull of {:2} corners", points.len()),
            };
            let [margin, p50, p95, max] = [*margin, outside.p50, outside.p95, outside.max].map(|length| length * 1e3);
            println!("{:15} {shape:19} {margin:7.1} {p50:6.1} {p95:6.1} {max:6.1}", self.names[*joint]);
        }
        let together = measure(&self.body(), &colliders);
        println!(
            "{} groups of {} joints, {} vertices, together {together:?}, in {time:?}",
            colliders.len(),
            self.names.len(),
            self.positions.len()
        );
        colliders
    }
}

fn largest_radius(colliders: &[BoneCollider]) -> f32 {
    let radius = |c: &BoneCollider| match c.shape {
        BoneShape::Capsule { radius, .. } => radius * c.unit,
        BoneShape::Hull { .. } => 0.0,
    };
    colliders.iter().map(radius).fold(0.0, f32::max)
}

#[test]
fn a_human_body_gets_a_capsule_for_each_part_of_it() {
    let Some(human) = Character::read("mannequin_clothes.glb", &[("Cape", 0), ("Skirt", 0)], 1.0) else {
        return;
    };
    let colliders = human.fitted();
    assert!((18..=21).contains(&colliders.len()), "{} groups", colliders.len());
    let together = measure(&human.body(), &colliders);
    assert!(together.p95 <= 0.020, "sticks out {together:?}");
    let largest = largest_radius(&colliders);
    assert!(largest <= 0.25, "a radius of {largest} m");
    for (name, radii) in
        [("thigh_l", 0.08..0.095), ("calf_l", 0.04..0.06), ("upperarm_l", 0.04..0.06), ("lowerarm_l", 0.035..0.055)]
    {
        let collider = colliders.iter().find(|c| human.names[c.joint] == name);
        let radius = collider.map(|c| largest_radius(std::slice::from_ref(c)));
        assert!(radius.is_some_and(|r| radii.contains(&r)), "{name}: radius {radius:?} m, not within {radii:?}");
    }
    let mean = colliders.iter().map(|c| c.outside.p95).sum::<f32>() / colliders.len() as f32;
    assert!(mean <= 0.020, "p95 of a part is {mean} m in the mean");
}

#[test]
fn stylized_characters_get_colliders_too() {
    // The second has a mesh in other units, under a node of scale 100, and a skirt of two primitives.
    let skirt = [("Witch_Legs", 0), ("Witch_Legs", 1)];
    for (name, clothes, unit, tall) in [("knight.glb", &[][..], 1.0, 2.3), ("witch.glb", &skirt[..], 100.0, 2.0)] {
        let Some(character) = Character::read(name, clothes, unit) else {
            continue;
        };
        let colliders = character.fitted();
        assert!((14..=21).contains(&colliders.len()), "{name}: {} groups", colliders.len());
        let largest = largest_radius(&colliders);
        assert!(largest < 0.25 * tall, "{name}: a radius of {largest} m");
        let together = measure(&character.body(), &colliders);
        assert!(together.p95 < 0.03, "{name}: sticks out {together:?}");
    }
}
