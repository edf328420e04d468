//! How long a cloth has been at rest, and what there was around it when the rest began.

use std::sync::Arc;

use bevy::prelude::*;

use super::bodies::WorldBody;
use crate::components::{ClothCollisionLayers, ClothWindZone};
use crate::solver::body::SharedShape;
use crate::solver::wind::Turbulence;

/// Way of a pin or a body that counts as none `[m]`, and of the parts of its rotation.
pub(crate) const STILL: f32 = 1.0e-4;

/// How long a cloth has been at rest, and under what.
#[derive(Component, Clone, Default)]
#[component(clone_behavior = Ignore)]
pub(crate) struct Slumber {
    pub asleep: bool,
    /// Whether it may not sleep, and is not untangled.
    pub disabled: [bool; 2],
    /// Another cloth came near.
    pub roused: bool,
    /// Time at rest `[s]`.
    pub quiet_for: f32,
    /// Whether it rested long enough.
    pub ready: bool,
    pub threshold: f32,
    pub delay: f32,
    /// Where the particles were when the rest began `[m]`.
    pub marks: Vec<Vec3>,
    pub seen: Seen,
}

/// What a cloth rests under.
#[derive(Clone, Default)]
pub(crate) struct Seen {
    pub gravity: Vec3,
    pub air: Option<(Vec3, f32, Turbulence)>,
    pub anchors: Vec<Vec3>,
    pub layers: ClothCollisionLayers,
    pub bodies: Vec<SeenBody>,
    pub zones: Vec<(Entity, ClothWindZone, Isometry3d)>,
}

/// A body near a cloth.
#[derive(Clone)]
pub(crate) struct SeenBody {
    entity: Entity,
    shape: SharedShape,
    at: Isometry3d,
    surface: [f32; 3],
    /// The body that takes what cloth does to it.
    taker: Option<Entity>,
}

impl SeenBody {
    pub(crate) fn of(body: &WorldBody, taker: Option<Entity>) -> Self {
        let surface = [body.margin, body.static_friction, body.dynamic_friction];
        Self { entity: body.entity, shape: body.shape.clone(), at: body.to, surface, taker }
    }

    pub(crate) fn is(&self, body: &WorldBody, taker: Option<Entity>) -> bool {
        (self.entity, self.taker) == (body.entity, taker)
            && Arc::ptr_eq(&self.shape.0, &body.shape.0)
            && self.surface == [body.margin, body.static_friction, body.dynamic_friction]
            && stays(&self.at, &body.to)
    }
}

/// Whether two places are one.
pub(crate) fn stays(a: &Isometry3d, b: &Isometry3d) -> bool {
    let (p, q) = (Vec4::from(a.rotation), Vec4::from(b.rotation));
    let turn = (p - q).abs().max_element().min((p + q).abs().max_element());
    a.translation.distance(b.translation) <= STILL && turn <= STILL
}
