//! Bodies of [avian](https://docs.rs/avian3d): their colliders meet cloth, and what takes part is given impulses back.
//!
//! ```text
//!  FixedPostUpdate   PhysicsSystems ─ TransformSystems::Propagate ─ ClothSystems, with `ClothPlugin::new(FixedPostUpdate)`
//!  PostUpdate                         TransformSystems::Propagate ─ ClothSystems, by default
//! ```
//!
//! Avian puts its sets before `TransformSystems::Propagate` of its schedule, and cloth comes after it. So in either schedule
//! cloth sees bodies where physics left them, whatever the order in which the plugins were added.
//!
//! *In lockstep* (both in one schedule, or a tick in every frame) a frame of the cloth covers the tick that physics just made.
//! The body follows the path of physics, and cloth pushes it off that path within the substeps. Afterwards
//! `LinearVelocity += J / M` and `Position += d`: momentum is conserved to rounding. *Out of lockstep* a frame may cover no
//! tick, or several. The sums stay right. A frame shorter than its tick sees bodies faster, by the same factor.

use avian3d::prelude::{
    AngularVelocity, Collider, ColliderDisabled, ColliderOf, CollisionLayers, CollisionMargin, ComputedAngularInertia,
    ComputedCenterOfMass, ComputedMass, DefaultFriction, Friction, LinearVelocity, LockedAxes, Physics, PhysicsTime, Position,
    RigidBody, RigidBodyDisabled, Rotation, Sensor, SleepTimer, Sleeping,
};
use bevy::prelude::*;

use crate::components::fitted::ColliderBody;
use crate::components::{
    ClothCollider, ClothCollisionDisabled, ClothCollisionLayers, ClothCoupling, ClothReaction, ClothRigidBody,
};
use crate::notices::{Notices, label};
use crate::simulation::{WorldBodies, WorldBody, jumped, swept};
use crate::solver::body::shape;
use crate::time::ClothTime;

impl From<CollisionLayers> for ClothCollisionLayers {
    /// The same bits.
    fn from(layers: CollisionLayers) -> Self {
        Self::new(layers.memberships.0, layers.filters.0)
    }
}

/// Share of a frame by which the time that physics made may differ from it in lockstep (dimensionless).
const LOCKSTEP: f32 = 1.0e-3;

/// Time that physics had made when cloth last looked `[s]`.
#[derive(Resource, Clone, Copy, Default)]
pub(crate) struct Seen(f64);

/// Takes the mass of bodies that take part from avian.
pub(crate) fn masses(
    time: Res<ClothTime>,
    physics: Option<Res<Time<Physics>>>,
    mut seen: ResMut<Seen>,
    mut bodies: Query<(
        &RigidBody,
        &ClothCoupling,
        &mut ClothRigidBody,
        &ComputedMass,
        &ComputedAngularInertia,
        &ComputedCenterOfMass,
        &LinearVelocity,
        &Rotation,
        Option<&LockedAxes>,
        Has<RigidBodyDisabled>,
        Has<Sleeping>,
    )>,
) {
    let Some(physics) = physics else { return };
    let made = (physics.elapsed_secs_f64() - seen.0) as f32;
    seen.0 = physics.elapsed_secs_f64();
    let lockstep = (made - time.delta_secs()).abs() <= LOCKSTEP * time.delta_secs();
    for (kind, coupling, mut rigid, mass, inertia, center, linear, rotation, locked, disabled, asleep) in &mut bodies {
        if *coupling == ClothCoupling::OneWay {
            continue;
        }
        if !kind.is_dynamic() || disabled || physics.is_paused() {
            rigid.set_if_neq(ClothRigidBody::default());
            continue;
        }
        let tensor = inertia.inverse();
        let mut inverse_inertia = Mat3::from_cols(tensor * Vec3::X, tensor * Vec3::Y, tensor * Vec3::Z);
        let mut inverse_mass = Vec3::splat(mass.inverse());
        if let Some(locked) = locked {
            inverse_mass *= free(locked, 0b100_000);
            // Avian locks the axes of the world.
            let axes = Mat3::from_quat(rotation.0);
            let free = Mat3::from_diagonal(free(locked, 0b000_100));
            inverse_inertia = axes.transpose() * free * axes * inverse_inertia * axes.transpose() * free * axes;
        }
        // `LinearVelocity` is that of the centre of mass.
        let velocity = (lockstep && !asleep).then_some(linear.0);
        rigid.set_if_neq(ClothRigidBody { inverse_mass, inverse_inertia, center_of_mass: center.0, velocity });
    }
}

/// 1 along the axes that are not locked; `first` is the bit of x.
fn free(locked: &LockedAxes, first: u8) -> Vec3 {
    let free = |bit: u8| if locked.to_bits() & bit == 0 { 1.0 } else { 0.0 };
    Vec3::new(free(first), free(first >> 1), free(first >> 2))
}

type Colliders<'a> = (
    Entity,
    Option<&'a Name>,
    &'a Collider,
    &'a ColliderOf,
    &'a GlobalTransform,
    Option<&'a CollisionLayers>,
    Option<&'a ClothCollisionLayers>,
    Option<&'a Friction>,
    Option<&'a CollisionMargin>,
    Option<&'a mut ColliderBody>,
);

type Meets = (Without<ClothCollider>, Without<Sensor>, Without<ColliderDisabled>, Without<ClothCollisionDisabled>);

/// Adds the colliders of avian's bodies to the bodies that cloth meets.
pub(crate) fn colliders(
    mut commands: Commands,
    time: Res<ClothTime>,
    mut world: ResMut<WorldBodies>,
    default_friction: Option<Res<DefaultFriction>>,
    bodies: Query<Option<&Friction>, (With<RigidBody>, Without<RigidBodyDisabled>, Without<ClothCollisionDisabled>)>,
    mut notices: ResMut<Notices>,
    mut colliders: Query<Colliders, Meets>,
) {
    let WorldBodies { bodies: met, checked, .. } = &mut *world;
    let dt = time.delta_secs();
    for (entity, name, collider, of, global, layers, own_layers, friction, margin, body) in &mut colliders {
        let Some(mut body) = body else {
            commands.entity(entity).try_insert(ColliderBody::default());
            continue;
        };
        let (_, rotation, translation) = global.to_scale_rotation_translation();
        let (Ok(of_body), true) = (bodies.get(of.body), rotation.is_finite() && translation.is_finite()) else {
            body.pose = None;
            continue;
        };
        let shape = collider.shape_scaled();
        if !body.has_made(shape) {
            match shape::checked(shape.clone()) {
                Ok(shape) => body.make(Some(shape)),
                Err(error) => {
                    body.make(None);
                    if notices.first(entity, "shape") {
                        warn!("collider {} pushes no cloth: {error}", label(entity, name));
                    }
                }
            }
        }
        if !body.has_made(shape) {
            body.pose = None;
            continue;
        }
        let to = Isometry3d::new(translation, rotation.normalize());
        let from = body.pose.filter(|from| !jumped(from, &to, body.reach, dt)).unwrap_or(to);
        body.pose = Some(to);
        let friction = friction.or(of_body).copied().or(default_friction.as_ref().map(|d| d.0)).unwrap_or_default();
        checked.clear();
        let margin = margin.map_or(0.0, |m| checked.within("CollisionMargin", m.0, 0.0, 0.0, 1.0));
        notices.clamped(entity, name, "collider", checked);
        let swept = swept(shape, [&from, &to], margin);
        met.push(WorldBody {
            swept,
            entity,
            character: None,
            shape: shape.clone(),
            from,
            to,
            layers: own_layers.copied().unwrap_or_else(|| layers.copied().unwrap_or_default().into()),
            margin,
            static_friction: friction.static_coefficient,
            dynamic_friction: friction.dynamic_coefficient,
            rigid: None,
        });
    }
    met.sort_unstable_by_key(|body| body.entity);
}

/// Forgets where a collider was that is switched off, so that it comes back without having swept what lies between.
pub(crate) fn on_switch_off<C: Component>(off: On<Add, C>, mut bodies: Query<&mut ColliderBody, Without<ClothCollider>>) {
    if let Ok(mut body) = bodies.get_mut(off.entity) {
        body.pose = None;
    }
}

/// Gives dynamic bodies what cloth gave them. A body that cloth touches does not sleep.
pub(crate) fn give(
    mut commands: Commands,
    mut bodies: Query<
        (
            Entity,
            &RigidBody,
            &ClothReaction,
            &ClothRigidBody,
            &mut Position,
            &mut Rotation,
            &mut LinearVelocity,
            &mut AngularVelocity,
            Option<&mut SleepTimer>,
            Has<Sleeping>,
        ),
        (With<ClothCoupling>, Without<RigidBodyDisabled>),
    >,
) {
    for (entity, kind, reaction, rigid, mut position, mut rotation, mut linear, mut angular, sleep, asleep) in &mut bodies {
        if !kind.is_dynamic() || reaction.is_zero() {
            continue;
        }
        let ClothRigidBody { inverse_mass, inverse_inertia, center_of_mass, .. } = *rigid;
        let axes = Mat3::from_quat(rotation.0);
        let center = position.0 + rotation.0 * center_of_mass + reaction.displacement;
        linear.0 += inverse_mass * reaction.linear;
        angular.0 += axes * (inverse_inertia * (axes.transpose() * reaction.angular));
        if reaction.turn != Quat::IDENTITY {
            rotation.0 = (reaction.turn * rotation.0).normalize();
        }
        position.0 = center - rotation.0 * center_of_mass;
        if let Some(mut sleep) = sleep {
            sleep.0 = 0.0;
        }
        if asleep {
            commands.entity(entity).try_remove::<Sleeping>();
        }
    }
}

/// Shows bodies where cloth moved them.
pub(crate) use avian3d::physics_transform::position_to_transform as show;
