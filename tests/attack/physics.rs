//! Bodies of avian, some of which take what cloth gives them. Nobody sets wild numbers on them: what avian makes of these is
//! not asked here.

use avian3d::prelude::{Collider, ColliderDisabled, LinearVelocity, Mass, RigidBody};
use bevy::prelude::*;
use bevy_drape::prelude::*;
use fastrand::Rng;

use super::stage::Stage;
use super::wild::{once_in, one_of, span, turn, vector};

/// A body that comes in, or another that goes out.
pub fn body(stage: &mut Stage, rng: &mut Rng) -> String {
    if once_in(rng, 4) && !stage.bodies.is_empty() {
        let count = stage.bodies.len();
        let entity = stage.bodies.swap_remove(rng.usize(0..count));
        match rng.u32(0..3) {
            0 => {
                stage.world().entity_mut(entity).insert(ColliderDisabled);
                stage.bodies.push(entity);
            }
            1 => {
                stage.world().entity_mut(entity).remove::<Collider>();
                stage.bodies.push(entity);
            }
            _ => {
                stage.world().try_despawn(entity).ok();
            }
        }
        return format!("{entity}: a body of avian goes out");
    }
    let large = span(rng, 0.02, 1.0);
    let collider = match rng.u32(0..5) {
        0 => Collider::sphere(large),
        1 => Collider::cuboid(large, large, 2.0 * large),
        2 => Collider::capsule(0.5 * large, large),
        3 => Collider::cylinder(large, large),
        _ => Collider::cone(large, large),
    };
    let kind = one_of(rng, &[RigidBody::Dynamic, RigidBody::Dynamic, RigidBody::Kinematic, RigidBody::Static]);
    let at = Transform::from_translation(vector(rng, 1.0)).with_rotation(turn(rng));
    let mass = span(rng, 1.0e-3, 1.0e3);
    let entity = stage.world().spawn((kind, collider, at, Mass(mass), LinearVelocity(vector(rng, 5.0)))).id();
    match rng.u32(0..4) {
        0 | 1 => stage.world().entity_mut(entity).insert(ClothCoupling::TwoWay),
        2 => stage.world().entity_mut(entity).insert(ClothCollisionDisabled),
        _ => stage.world().entity_mut(entity).insert(ClothCoupling::OneWay),
    };
    stage.bodies.push(entity);
    format!("{entity}: a body of avian, {kind:?}, {large} m, {mass} kg, at {at:?}")
}
