//! The fabric's side of a contact: how far it keeps off, how it rubs, how it bounces.

use super::Body;
use super::friction::Friction;
use super::motion::finite_or_zero;
use crate::solver::settings::Fabric;

/// The fabric's side of a contact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Touch {
    /// Distance kept to every body `[m]`.
    pub thickness: f32,
    /// Static friction coefficient (dimensionless).
    pub static_friction: f32,
    /// Dynamic friction coefficient (dimensionless).
    pub dynamic_friction: f32,
    /// Speed with which it leaves what it struck, over that with which it met it (dimensionless).
    pub restitution: f32,
}

impl Touch {
    /// As a fabric says.
    #[must_use]
    pub fn of(fabric: &Fabric) -> Self {
        let Fabric { thickness, static_friction, dynamic_friction, restitution, .. } = *fabric;
        Self { thickness, static_friction, dynamic_friction, restitution }
    }

    /// Friction on a body.
    pub(super) fn friction(&self, body: &Body) -> Friction {
        Friction::between((body.static_friction, body.dynamic_friction), (self.static_friction, self.dynamic_friction))
    }

    /// Distance kept to a body `[m]`.
    pub(super) fn kept(&self, body: &Body) -> f32 {
        finite_or_zero(self.thickness) + finite_or_zero(body.margin)
    }

    /// Neither rubs nor bounces.
    #[must_use]
    pub(crate) fn frictionless(fabric: &Fabric) -> Self {
        Self { thickness: fabric.thickness, ..Self::default() }
    }
}
