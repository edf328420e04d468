//! Bodies, characters, zones, grips and cameras that come in.

use bevy::prelude::*;
use bevy_drape::prelude::*;
use bevy_drape::solver::body::SharedShape;
use fastrand::Rng;

use super::clothes::{more, place, skeleton};
use super::damage;
use super::stage::Stage;
use super::wild::{number, once_in, one_of, signed, size, span, turn, vector, wild_vector};

/// A shape of any kind, about `size` large `[m]`; wildly with numbers that are none.
fn shape(rng: &mut Rng, size: f32, wildly: bool) -> ClothColliderShape {
    let number = |rng: &mut Rng| if wildly && once_in(rng, 2) { number(rng) } else { size * span(rng, 0.2, 2.0) };
    let point = |rng: &mut Rng| if wildly && once_in(rng, 9) { wild_vector(rng) } else { vector(rng, size) };
    let count = rng.u32(if wildly { 0 } else { 4 }..20);
    let triangle = |rng: &mut Rng| [(); 3].map(|()| rng.u32(0..if wildly { count + 2 } else { count }));
    match rng.u32(0..12) {
        0 => ClothColliderShape::Ball { radius: number(rng) },
        1 => ClothColliderShape::Capsule { radius: number(rng), length: number(rng) },
        2 => ClothColliderShape::Cuboid { size: Vec3::new(number(rng), number(rng), number(rng)) },
        3 => ClothColliderShape::Cylinder { radius: number(rng), height: number(rng) },
        4 => ClothColliderShape::Cone { radius: number(rng), height: number(rng) },
        5 => ClothColliderShape::HalfSpace { normal: point(rng) },
        6 => ClothColliderShape::ConvexHull { points: (0..count).map(|_| point(rng)).collect() },
        7 | 8 => ClothColliderShape::TriMesh {
            vertices: (0..count).map(|_| point(rng)).collect(),
            triangles: (0..count).map(|_| triangle(rng)).collect(),
            solid: rng.bool(),
        },
        9 => {
            let (rows, columns) = (rng.u32(2..6), rng.u32(2..6));
            let heights = (0..rows * columns + u32::from(wildly)).map(|_| number(rng)).collect();
            ClothColliderShape::HeightField { rows, columns, heights, size: Vec3::new(size, 1.0, number(rng)) }
        }
        10 => ClothColliderShape::Mesh(one_of(
            rng,
            &[
                ClothMeshFit::Ball,
                ClothMeshFit::Capsule,
                ClothMeshFit::Cuboid,
                ClothMeshFit::ConvexHull,
                ClothMeshFit::TriMesh,
                ClothMeshFit::HalfSpace,
            ],
        )),
        _ => {
            let part = ClothColliderShape::Ball { radius: number(rng) };
            let other = ClothColliderShape::Cuboid { size: Vec3::splat(number(rng)) };
            ClothCollider::compound([(point(rng), turn(rng), part), (point(rng), turn(rng), other)]).shape
        }
    }
}

/// A collider, alone or as a body that cloth moves.
pub fn body(stage: &mut Stage, slot: usize, rng: &mut Rng) -> String {
    let wildly = once_in(rng, 4);
    let large = size(rng);
    let mut collider = ClothCollider::new(shape(rng, large, wildly));
    if once_in(rng, 12) {
        let radius = if wildly { number(rng) } else { large };
        collider = ClothCollider::parry(SharedShape::ball(radius));
    }
    collider.margin = if once_in(rng, 6) { number(rng) } else { 0.0 };
    let at = place(rng, 1.0);
    let told = format!("{slot}: body {collider:?} {at:?}");
    let entity = stage.world().spawn((collider, at, Name::new(format!("slot {slot}")))).id();
    if rng.bool() {
        let (mesh, _) = damage::mesh(rng, wildly);
        let mesh = stage.add(mesh);
        stage.world().entity_mut(entity).insert(Mesh3d(mesh));
    }
    let mut kind = "";
    if once_in(rng, 3) {
        let mass = if wildly { number(rng) } else { span(rng, 1.0e-3, 1.0e3) };
        let mut body = ClothRigidBody::ball(mass, large);
        body.velocity = once_in(rng, 3).then(|| if wildly { wild_vector(rng) } else { vector(rng, 5.0) });
        stage.world().entity_mut(entity).insert((ClothCoupling::TwoWay, body));
        kind = ", two-way";
    }
    stage.enter(slot, entity);
    format!("{told}{kind}")
}

/// A skinned body that colliders are fitted to.
pub fn character(stage: &mut Stage, slot: usize, rng: &mut Rng) -> String {
    let wildly = once_in(rng, 3);
    let (mut mesh, what) = damage::mesh(rng, wildly);
    let skin = skeleton(stage, rng, wildly);
    damage::skin(rng, &mut mesh, u16::try_from(skin.joints.len()).unwrap_or(1), wildly);
    let mesh = stage.add(mesh);
    let entity = stage.world().spawn((Mesh3d(mesh), skin, ClothBody::default(), Transform::default())).id();
    stage.enter(slot, entity);
    let more = more(stage, entity, slot, rng);
    format!("{slot}: character, {what}{more}")
}

/// A wind zone, a grip, a camera, or an empty place.
pub fn thing(stage: &mut Stage, slot: usize, other: usize, rng: &mut Rng) -> String {
    let wildly = once_in(rng, 4);
    let velocity = if wildly { wild_vector(rng) } else { vector(rng, 20.0) };
    let cloth = stage.some(other);
    let at = place(rng, 1.0);
    let world = stage.world();
    let (entity, what) = match rng.u32(0..5) {
        0 => {
            let zone = ClothWindZone::cuboid(Vec3::splat(size(rng)), velocity);
            (world.spawn((zone, at)).id(), format!("{zone:?}"))
        }
        1 => {
            let radius = if wildly { number(rng) } else { size(rng) };
            let zone = ClothWindZone::sphere(radius, velocity);
            (world.spawn((zone, at)).id(), format!("{zone:?}"))
        }
        2 => {
            let particles = [(); 3].map(|()| rng.u32(0..if wildly { u32::MAX } else { 9 }));
            let weights = if wildly { wild_vector(rng) } else { Vec3::new(0.2, 0.3, 0.5) };
            let target = if wildly { wild_vector(rng) } else { vector(rng, 1.0) };
            let grab = ClothGrab { cloth, particles, weights, target, radius: signed(rng, 0.1).abs(), ..default() };
            (world.spawn(grab.clone()).id(), format!("{grab:?}"))
        }
        3 => (world.spawn((Camera3d::default(), at)).id(), "camera".into()),
        _ => (world.spawn(at).id(), "empty place".into()),
    };
    stage.enter(slot, entity);
    format!("{slot}: {what}")
}
