//! The weather in the world as cloth feels it in a frame.

use bevy::prelude::*;

use crate::components::checked::Checked;
use crate::components::{ClothWindZone, ClothWindZoneShape};
use crate::solver::wind::Wind;

/// The weather in the world: shared by every cloth without a wind of its own.
#[derive(Resource, Default)]
pub(crate) struct WorldAir {
    pub wind: Wind,
    pub gravity: Vec3,
    /// In the order of entities.
    pub zones: Vec<(Entity, ClothWindZone, Isometry3d)>,
    pub checked: Checked,
}

/// Whether a zone may reach into a box `[m]`.
pub(crate) fn reaches(zone: &ClothWindZone, at: &Isometry3d, low: Vec3, high: Vec3) -> bool {
    let radius = match zone.shape {
        ClothWindZoneShape::Cuboid { half_size } => half_size.length(),
        ClothWindZoneShape::Sphere { radius } => radius,
    };
    let center = Vec3::from(at.translation);
    !(center.clamp(low, high).distance(center) > radius)
}
