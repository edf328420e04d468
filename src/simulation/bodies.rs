//! The bodies in the world as cloth meets them in a frame.

use bevy::prelude::*;
use parry3d::bounding_volume::BoundingVolume;

use crate::components::ClothCollisionLayers;
use crate::components::checked::Checked;
use crate::solver::body::{Pose, SharedShape};
use crate::solver::couple::Reaction;

/// Jumps shorter than this are motion `[m]`: as far as a cloth goes by default.
const LEAST_JUMP: f32 = 1.0;

/// Distance from the box of a cloth at which a body is near, on top of thickness and margin `[m]`.
pub(crate) const NEAR: f32 = 0.02;

/// A body in the world in this frame.
pub(crate) struct WorldBody {
    pub entity: Entity,
    /// The character it belongs to.
    pub character: Option<Entity>,
    pub shape: SharedShape,
    pub from: Isometry3d,
    pub to: Isometry3d,
    pub layers: ClothCollisionLayers,
    pub margin: f32,
    pub static_friction: f32,
    pub dynamic_friction: f32,
    /// Place in [`WorldBodies::rigids`] of the body that takes what cloth does to it.
    pub rigid: Option<u32>,
    /// Corners of the box around its way in this frame, margin included `[m]`.
    pub swept: (Vec3, Vec3),
}

/// Corners of the box around the way of a body in a frame, with its margin `[m]`.
pub(crate) fn swept(shape: &SharedShape, [from, to]: [&Isometry3d; 2], margin: f32) -> (Vec3, Vec3) {
    let pose = |at: &Isometry3d| Pose::from_parts(at.translation.into(), at.rotation);
    let mut swept = shape.compute_aabb(&pose(to));
    if from != to {
        swept.merge(&shape.compute_aabb(&pose(from)));
    }
    (swept.mins - margin, swept.maxs + margin)
}

/// A body in the world that takes what cloth does to it.
pub(crate) struct WorldRigid {
    pub entity: Entity,
    /// Centre of mass at both ends of the frame `[m]`.
    pub from: Vec3,
    pub to: Vec3,
    pub velocity: Option<Vec3>,
    pub inverse_mass: Vec3,
    pub inverse_inertia: Mat3,
    /// As the app gave them: inverse inertia in the axes of the entity, centre of mass from its origin `[m]`.
    pub own_inertia: Mat3,
    pub center_of_mass: Vec3,
    /// Cloths that gave it something in the last frame, and what and how many do in this one.
    pub givers: u32,
    pub given: Reaction,
    pub gave: u32,
}

impl WorldRigid {
    /// Whether cloth moved it in this frame.
    pub(crate) fn is_moved(&self) -> bool {
        self.given.shift != Vec3::ZERO || self.given.turn != Quat::IDENTITY
    }

    /// A pose that goes with the body, moved as cloth moved it.
    pub(crate) fn moved(&self, pose: Isometry3d) -> Isometry3d {
        let Reaction { shift, turn, .. } = self.given;
        let translation = self.to + shift + turn * (Vec3::from(pose.translation) - self.to);
        Isometry3d::new(translation, (turn * pose.rotation).normalize())
    }
}

/// Every body, in the order of entities.
#[derive(Resource, Default)]
pub(crate) struct WorldBodies {
    pub bodies: Vec<WorldBody>,
    /// In the order of entities, too.
    pub rigids: Vec<WorldRigid>,
    pub checked: Checked,
}

impl WorldBodies {
    /// The body that takes what cloth does to `body`.
    pub(crate) fn taker(&self, body: &WorldBody) -> Option<Entity> {
        self.rigids.get(body.rigid? as usize).map(|rigid| rigid.entity)
    }
}

/// Slower than this nothing teleports, however far it got in a frame `[m/s]`: what falls in air, or a car.
pub(crate) const TELEPORT_SPEED: f32 = 25.0;
/// The same of turns `[rad/s]`: 1,800 degrees a second. Chests turn at up to 1,125 in fights.
pub(crate) const TELEPORT_SPIN: f32 = 10.0 * core::f32::consts::PI;

/// A body of that reach `[m]` that jumps further than cloth teleports in `dt` `[s]` sweeps nothing on its way.
pub(crate) fn jumped(from: &Isometry3d, to: &Isometry3d, reach: f32, dt: f32) -> bool {
    let limit = if reach.is_finite() { (3.0 * reach).max(LEAST_JUMP).max(TELEPORT_SPEED * dt) } else { f32::INFINITY };
    !(from.translation.distance(to.translation) <= limit)
}

/// Whether a body is, or was at the start of the frame, or passed between, near a box `[m]`.
pub(crate) fn is_near(body: &WorldBody, low: Vec3, high: Vec3) -> bool {
    let (least, most) = body.swept;
    // A box that is not finite is near.
    !(least.cmpgt(high).any() || most.cmplt(low).any())
}
