//! What cloth gives bodies.

use bevy::math::Mat3;
use bevy::prelude::*;

use super::checked::Checked;
use super::fitted::CoupledBody;

/// Whether a body takes what cloth does to it. On the entity of a collider, on an ancestor of several, or on what cloth is
/// pinned to.
///
/// Without it bodies push cloth and feel nothing. Cloth that must not change how a game plays stays as it is. Cloth that gives
/// a body something does not sleep ([`ClothSleep`](crate::ClothSleep)).
///
/// A body lighter than the cloth is as stable as a heavier one. A heavier body raises the number of substeps up to eightfold,
/// until it has gone. The factor is the square root of the ratio of the masses, or follows from its speed of impact. Cloth that
/// lies on the body is excepted. At the default [`ClothSolver::substep_rate`](crate::ClothSolver::substep_rate) of 360 Hz a net
/// of 0.3 kg bears 1 and 3 kg that fall on it from 0.6 m. A body more than thirty times as heavy may stretch its way through or
/// be thrown out: raise the rate. Elastic nets ([`ClothMaterial::strain_limit`](crate::ClothMaterial::strain_limit) and
/// `tether_scale` infinite) throw back what falls into them for longer.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # fn setup(mut commands: Commands) {
/// // A mast that tells how hard the sail pulls at it.
/// commands.spawn((ClothCollider::cylinder(0.1, 6.0), ClothCoupling::TwoWay));
/// # }
/// # fn creak(masts: Query<&ClothReaction>) {
/// for reaction in &masts {
///     let force = reaction.force(); // [N]
/// #   let _ = force;
/// }
/// # }
/// ```
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
#[require(ClothReaction, ClothRigidBody, CoupledBody)]
pub enum ClothCoupling {
    /// Cloth gives it nothing. On a child of a two-way body: that child takes no part.
    #[default]
    OneWay,
    /// [`ClothReaction`] says what cloth gave it. A body with a mass ([`ClothRigidBody`]; a dynamic `RigidBody` of avian has
    /// one) also gives way within the frame.
    TwoWay,
}

/// Impulses, displacement and turn that cloth gave a body with [`ClothCoupling::TwoWay`] in the last frame. Read it after
/// [`ClothSystems::Integrate`](crate::ClothSystems::Integrate); written by the simulation.
///
/// All of it is zero in a frame in which cloth does not move. Then time stands still, or the frame is shorter than a
/// millisecond and is simulated together with the next.
///
/// Contacts and rigid pins are counted. The load of pins is exact for all pins of a cloth together; several bodies share it by
/// the strain at their pins. A body of avian is given all of it without a line of code.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothReaction {
    /// Impulse `[N·s]`. Divided by [`duration`](Self::duration): the mean [force](Self::force) `[N]`.
    pub linear: Vec3,
    /// Angular impulse about the centre of mass `[N·m·s]`, which is the origin of the entity unless [`ClothRigidBody`] says
    /// otherwise.
    pub angular: Vec3,
    /// How far the centre of mass was moved off its way within the frame `[m]`; zero for a body without a mass. Add it to the
    /// position of the body.
    pub displacement: Vec3,
    /// How the body was turned off its way within the frame. Turn the body by it about its centre of mass.
    pub turn: Quat,
    /// In which time cloth gave it `[s]`: the length of the frame, and of those before it that were too short.
    pub duration: f32,
}

impl Default for ClothReaction {
    fn default() -> Self {
        Self { linear: Vec3::ZERO, angular: Vec3::ZERO, displacement: Vec3::ZERO, turn: Quat::IDENTITY, duration: 0.0 }
    }
}

impl ClothReaction {
    /// Whether cloth gave nothing.
    #[must_use]
    pub fn is_zero(&self) -> bool {
        Self { duration: 0.0, ..*self } == Self::default()
    }

    /// Mean force `[N]`; zero in a frame in which cloth does not move.
    #[must_use]
    pub fn force(&self) -> Vec3 {
        if self.duration > 0.0 { self.linear / self.duration } else { Vec3::ZERO }
    }
}

/// How readily a body with [`ClothCoupling::TwoWay`] gives way. Default: not at all.
///
/// It is for physics of your own. Set it before [`ClothSystems::Prepare`](crate::ClothSystems::Prepare). After
/// [`ClothSystems::Integrate`](crate::ClothSystems::Integrate) take over all of [`ClothReaction`], displacement and turn too:
/// the next frame of the cloth goes on from there. The component of a body of avian is kept up to date from its mass
/// properties.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothRigidBody {
    /// Inverse mass along each axis of the world `[1/kg]`. Default 0, range 0 to 1e6; 0: cloth does not move it that way.
    pub inverse_mass: Vec3,
    /// Inverse inertia about the centre of mass, in the turned axes of the entity `[1/(kg m²)]`. Default 0: cloth does not turn
    /// it.
    pub inverse_inertia: Mat3,
    /// Centre of mass from the origin of the entity, in its turned but not scaled axes `[m]`. Default 0.
    pub center_of_mass: Vec3,
    /// Velocity of the centre of mass at the end of the frame, without what cloth gives it in this frame `[m/s]`. Default none:
    /// as its transforms say. Physics that adds gravity before it moves its bodies ends a frame faster than its way in the
    /// frame tells.
    pub velocity: Option<Vec3>,
}

impl Default for ClothRigidBody {
    fn default() -> Self {
        // The default of a matrix is the identity, not zero.
        Self { inverse_mass: Vec3::ZERO, inverse_inertia: Mat3::ZERO, center_of_mass: Vec3::ZERO, velocity: None }
    }
}

impl ClothRigidBody {
    /// A solid ball of `mass` `[kg]` and `radius` `[m]`.
    #[must_use]
    pub fn ball(mass: f32, radius: f32) -> Self {
        Self::solid(mass, Vec3::splat(0.4 * mass * radius * radius))
    }

    /// A solid box of `mass` `[kg]` and lengths `size` `[m]`.
    #[must_use]
    pub fn cuboid(mass: f32, size: Vec3) -> Self {
        let square = size * size;
        Self::solid(mass, Vec3::new(square.y + square.z, square.z + square.x, square.x + square.y) * (mass / 12.0))
    }

    /// A body of `mass` `[kg]` and principal moments `inertia` `[kg·m²]` along the axes of the entity. Cloth does not move a
    /// body without mass, or turn one without inertia. Numbers below 0 or NaN do no more, and a warning names them when the
    /// body takes part.
    #[must_use]
    pub fn solid(mass: f32, inertia: Vec3) -> Self {
        let inverse = |x: f32| if x == 0.0 { 0.0 } else { x.recip() };
        Self {
            inverse_mass: Vec3::splat(inverse(mass)),
            inverse_inertia: Mat3::from_diagonal(Vec3::new(inverse(inertia.x), inverse(inertia.y), inverse(inertia.z))),
            ..Self::default()
        }
    }

    /// What of it can be used; what is not finite or below zero does not give way.
    pub(crate) fn checked(&self, checked: &mut Checked) -> Self {
        let mass = self.inverse_mass;
        let inverse_mass = Vec3::new(
            checked.within("inverse_mass", mass.x, 0.0, 0.0, 1.0e6),
            checked.within("inverse_mass", mass.y, 0.0, 0.0, 1.0e6),
            checked.within("inverse_mass", mass.z, 0.0, 0.0, 1.0e6),
        );
        let m = self.inverse_inertia;
        let sound = m.is_finite() && m.x_axis.x >= 0.0 && m.y_axis.y >= 0.0 && m.z_axis.z >= 0.0;
        if !sound {
            checked.refuse("inverse_inertia");
        }
        Self {
            inverse_mass,
            inverse_inertia: if sound { 0.5 * (m + m.transpose()) } else { Mat3::ZERO },
            center_of_mass: checked.vector("center_of_mass", self.center_of_mass, Vec3::ZERO, 1.0e6),
            velocity: self.velocity.filter(|v| {
                if !v.is_finite() {
                    checked.refuse("velocity");
                }
                v.is_finite()
            }),
        }
    }
}

/// Keeps a collider of another plugin, as avian's `Collider`, away from cloth. On the collider, or on its body for all of the
/// body's colliders.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothCollisionDisabled;
