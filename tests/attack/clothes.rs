//! Cloths that come in.

use bevy::camera::primitives::MeshAabb;
use bevy::mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes};
use bevy::prelude::*;
use bevy_drape::prelude::*;
use fastrand::Rng;

use super::damage::{self, PAINT};
use super::mirror::{self, Wildness};
use super::shapes;
use super::stage::Stage;
use super::wild::{number, once_in, one_of, signed, size, span, turn, vector, wild_vector};

/// Where something stands: around the origin, or far from it.
pub fn place(rng: &mut Rng, spread: f32) -> Transform {
    let at = vector(rng, spread) + if once_in(rng, 12) { vector(rng, 1.0e4) } else { Vec3::ZERO };
    let scale = if once_in(rng, 4) { Vec3::splat(size(rng)) } else { Vec3::ONE };
    let rotation = if rng.bool() { Quat::IDENTITY } else { turn(rng) };
    Transform { translation: at, rotation, scale }
}

/// What a cloth hangs on.
pub fn pins(stage: &Stage, other: usize, rng: &mut Rng) -> ClothPins {
    let below = one_of(rng, &[3, 9, 30, 100]);
    let pins = match rng.u32(0..8) {
        0 => return ClothPins::NONE,
        1 => ClothPins::vertices((0..rng.u32(0..6)).map(|_| rng.u32(0..below)).collect::<Vec<u32>>()),
        2 => ClothPins::weights((0..rng.u32(0..6)).map(|_| (rng.u32(0..below), rng.f32())).collect::<Vec<_>>()),
        3 => ClothPins::color(one_of(rng, &[ClothColorChannel::R, ClothColorChannel::A])),
        4 => ClothPins::attribute(one_of(rng, &[PAINT.name, "_NONE", ""])),
        5 => ClothPins::where_position(|p| p.z < -0.499),
        6 => ClothPins::where_position(|_| true),
        _ => ClothPins::where_position(|p| p.x < 0.0).and(ClothPins::vertices([0, 7])),
    };
    let pins = if once_in(rng, 3) { pins.to(stage.some(other)) } else { pins };
    let pins = if once_in(rng, 6) { pins.weighted(number(rng)) } else { pins };
    pins.on_target_lost(one_of(rng, &[ClothOnTargetLost::Hold, ClothOnTargetLost::Release, ClothOnTargetLost::Despawn]))
}

/// More components, at random.
pub fn more(stage: &mut Stage, entity: Entity, other: usize, rng: &mut Rng) -> String {
    let mut names = String::new();
    for _ in 0..rng.u32(0..4) {
        let kind = one_of(rng, &stage.kinds);
        let wildly = once_in(rng, 4);
        let how = Wildness { once_in: 4, wildly, entity: stage.some(other) };
        mirror::put(stage.world(), entity, &kind, how, rng);
        names = format!("{names} {}{}", if wildly { "wild " } else { "" }, kind.name);
    }
    names
}

/// A cloth with a sheet, or with any mesh.
pub fn cloth(stage: &mut Stage, slot: usize, other: usize, wildly: bool, rng: &mut Rng) -> String {
    let (mesh, what) = damage::mesh(rng, wildly);
    let longest =
        once_in(rng, 8).then(|| one_of(rng, &[0.1, 0.3]) * mesh.compute_aabb().map_or(1.0, |b| b.half_extents.length()));
    let mesh = stage.add(mesh);
    let pins = pins(stage, other, rng);
    let (name, material) = one_of(rng, &ClothMaterial::PRESETS);
    let told = format!("{slot}: cloth of {name}, {what}, {pins:?}");
    let bundle = (Mesh3d(mesh), Cloth, place(rng, 1.0), material, pins, Name::new(format!("slot {slot}")));
    let entity = stage.world().spawn(bundle).id();
    stage.enter(slot, entity);
    if let Some(longest) = longest {
        stage.world().entity_mut(entity).insert(ClothSubdivision::new(longest));
    }
    let shortest = once_in(rng, 8).then(|| number(rng).abs());
    if let Some(shortest) = shortest {
        stage.world().entity_mut(entity).insert(ClothDecimation::new(shortest));
    }
    let more = more(stage, entity, other, rng);
    let split = longest.map_or_else(String::new, |longest| format!(" ClothSubdivision {longest}"));
    let merged = shortest.map_or_else(String::new, |shortest| format!(" ClothDecimation {shortest}"));
    format!("{told}{split}{merged}{more}")
}

/// Two sheets through each other.
pub fn tangle(stage: &mut Stage, slot: usize, rng: &mut Rng) -> String {
    let (n, size) = (rng.u32(4..10), size(rng));
    let at = vector(rng, 1.0);
    let untangling = ClothUntangling { at_load: rng.bool(), ..default() }.with_method(one_of(rng, ClothUntanglingMethod::ALL));
    let entities = [Quat::IDENTITY, turn(rng)].map(|rotation| {
        let mesh = stage.add(shapes::sheet(n, n, size).mesh(false));
        let place = Transform::from_translation(at).with_rotation(rotation);
        stage.world().spawn((Mesh3d(mesh), Cloth, place, untangling)).id()
    });
    stage.belongings.push(entities[1]);
    stage.enter(slot, entities[0]);
    format!("{slot}: two sheets of {n} x {n} through each other, {size} m, {untangling:?}")
}

/// Joints in a row and what binds a mesh to them.
pub fn skeleton(stage: &mut Stage, rng: &mut Rng, wildly: bool) -> SkinnedMesh {
    let count = rng.usize(1..5);
    let mut joints: Vec<Entity> = Vec::new();
    let mut bind = Mat4::IDENTITY;
    let mut binds = Vec::new();
    for i in 0..count {
        let step = if i == 0 { Transform::default() } else { Transform::from_xyz(signed(rng, 0.5), 0.3, 0.0) };
        bind *= step.to_matrix();
        binds.push(bind.inverse());
        let joint = stage.world().spawn((step, Name::new(format!("joint {i}")))).id();
        if let Some(&parent) = joints.last() {
            stage.world().entity_mut(joint).insert(ChildOf(parent));
        }
        joints.push(joint);
    }
    stage.belongings.extend(&joints);
    if wildly && once_in(rng, 4) {
        binds.truncate(rng.usize(0..=count));
    }
    if wildly && once_in(rng, 4) {
        binds.push(Mat4::from_translation(wild_vector(rng)));
        binds.rotate_right(1);
    }
    let inverse_bindposes = stage.world().resource_mut::<Assets<SkinnedMeshInverseBindposes>>().add(binds);
    if wildly && once_in(rng, 4) {
        joints.truncate(rng.usize(0..=count));
    }
    SkinnedMesh { inverse_bindposes, joints }
}

/// A map of one number, or painted.
fn map(rng: &mut Rng) -> ClothMap {
    let (low, high) = (span(rng, 1.0e-3, 1.0), span(rng, 1.0e-2, 10.0));
    match rng.u32(0..6) {
        0 => ClothMap::Off,
        1 => ClothMap::attribute(PAINT.name, low, high),
        2 => ClothMap::color(ClothColorChannel::G, low, high),
        3 => ClothMap::Uniform(number(rng)),
        _ => ClothMap::Uniform(low),
    }
}

/// A cloth on a skin, with limits and a drive.
pub fn skinned(stage: &mut Stage, slot: usize, other: usize, rng: &mut Rng) -> String {
    let strange = once_in(rng, 3);
    let wildly = once_in(rng, 5);
    let (mut mesh, what) = damage::mesh(rng, wildly);
    let skin = skeleton(stage, rng, strange);
    damage::skin(rng, &mut mesh, u16::try_from(skin.joints.len()).unwrap_or(1), strange);
    let limits = ClothLimits { max_distance: map(rng), backstop_distance: map(rng), ..default() };
    let drive = ClothDrive { frequency: map(rng), ..default() };
    let told = format!("{slot}: skinned cloth, {what}, {limits:?}, {drive:?}");
    let mesh = stage.add(mesh);
    let entity = stage.world().spawn((Mesh3d(mesh), Cloth, skin, limits, drive, Name::new(format!("slot {slot}")))).id();
    if rng.bool() {
        stage.world().entity_mut(entity).insert(ClothBlend { weight: rng.f32(), ..default() });
    }
    if once_in(rng, 4) {
        stage.world().entity_mut(entity).insert(ClothWarmUp { seconds: 2.0 * rng.f32() });
    }
    stage.enter(slot, entity);
    let more = more(stage, entity, other, rng);
    format!("{told}{more}")
}
