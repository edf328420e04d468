//! What is remembered of a body from one frame to the next. It comes along with a collider or a coupling; users do not see it.

use bevy::prelude::*;

use crate::solver::body::SharedShape;

/// Shape of a collider as it was made, and where it was.
#[derive(Component, Default)]
#[component(clone_behavior = Ignore)]
pub(crate) struct ColliderBody {
    pub stage: Stage,
    pub shape: Option<SharedShape>,
    pub unscaled: Option<SharedShape>,
    pub scale: Vec3,
    pub mesh: Option<AssetId<Mesh>>,
    /// Where it was at the end of the last frame.
    pub pose: Option<Isometry3d>,
    /// Radius of the ball around it `[m]`.
    pub reach: f32,
}

impl ColliderBody {
    /// Whether this shape was made from that of another crate last.
    #[cfg(feature = "avian")]
    pub fn has_made(&self, shape: &SharedShape) -> bool {
        self.shape.as_ref().is_some_and(|made| std::sync::Arc::ptr_eq(&made.0, &shape.0))
    }

    /// Takes a shape that was checked.
    pub fn make(&mut self, shape: Option<SharedShape>) {
        self.reach = shape.as_ref().map_or(0.0, |shape| shape.compute_local_bounding_sphere().radius);
        self.shape = shape;
    }
}

/// How far a shape is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Stage {
    /// Not tried yet.
    #[default]
    New,
    /// Its mesh is not there; since that real time `[s]`.
    Waiting {
        since: f64,
    },
    /// It cannot be made until something changes.
    Failed,
    Made,
}

/// Where a body that takes part was at the end of the last frame, and how many cloths gave it something.
#[derive(Component, Clone, Copy, Debug, Default)]
#[component(clone_behavior = Ignore)]
pub(crate) struct CoupledBody {
    pub pose: Option<Isometry3d>,
    pub givers: u32,
}
