//! A grip on a cloth: grab, drag, throw.

use bevy::prelude::*;

use super::checked::Checked;
use super::grip::Grip;
use super::hit::ClothHit;

/// Holds a point of a cloth near `target`, on an entity of its own. Spawn it to grab, move `target` to drag, despawn it to let
/// go. The cloth keeps the velocity it has then.
///
/// The grip yields and its force is bounded, so stuck cloth stays whole, and bodies stop it. A grip whose cloth is gone or does
/// not have those particles any more does nothing.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// fn grab(mut commands: Commands, cloths: ClothQuery) {
///     if let Some(hit) = cloths.cast_ray(Ray3d::new(Vec3::new(0.0, 2.0, 0.0), Dir3::NEG_Y), 10.0) {
///         commands.spawn(ClothGrab::at(&hit));
///     }
/// }
/// ```
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
#[require(Grip)]
pub struct ClothGrab {
    /// The cloth.
    #[entities]
    pub cloth: Entity,
    /// Particles around the point.
    pub particles: [u32; 3],
    /// Their weights; they add up to one.
    pub weights: Vec3,
    /// Where the point is to be, in the world `[m]`. A target that is not finite lets the grip rest.
    pub target: Vec3,
    /// Radius of the grip around the point, along the cloth at rest `[m]`. Default 0.05, range 0 to 10. 0 pulls at one
    /// triangle, which shows.
    pub radius: f32,
    /// Compliance of the grip `[m/N]`. Default 0.001, range 0 to 100.
    pub compliance: f32,
    /// Largest force `[N]`. Default 20, range 0 to 10,000. Some ten times the weight of the cloth drags it briskly; more than
    /// twenty times that weight is never used.
    pub max_force: f32,
}

impl Default for ClothGrab {
    /// Grips nothing.
    fn default() -> Self {
        Self {
            cloth: Entity::PLACEHOLDER,
            particles: [0; 3],
            weights: Vec3::X,
            target: Vec3::ZERO,
            radius: 0.05,
            compliance: 0.001,
            max_force: 20.0,
        }
    }
}

impl ClothGrab {
    /// Grabs a point that a query found, where it is.
    #[must_use]
    pub fn at(hit: &ClothHit) -> Self {
        Self { cloth: hit.entity, particles: hit.particles, weights: hit.barycentric, target: hit.point, ..Self::default() }
    }

    /// The same grip on so much around the point `[m]`.
    #[must_use]
    pub fn with_radius(self, radius: f32) -> Self {
        Self { radius, ..self }
    }

    /// The same grip with another largest force `[N]`.
    #[must_use]
    pub fn with_max_force(self, max_force: f32) -> Self {
        Self { max_force, ..self }
    }

    /// Radius, compliance and largest force in range.
    pub(crate) fn checked(&self, checked: &mut Checked) -> (f32, f32, f32) {
        (
            checked.within("grab.radius", self.radius, 0.05, 0.0, 10.0),
            checked.within("grab.compliance", self.compliance, 0.001, 0.0, 100.0),
            checked.within("grab.max_force", self.max_force, 20.0, 0.0, 10_000.0),
        )
    }
}
