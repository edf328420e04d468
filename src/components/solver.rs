//! How exactly a cloth is simulated.

use bevy::prelude::*;

use super::checked::Checked;
use crate::solver::recover::Limits;
use crate::solver::settings::{MembraneModel, Stepping};

/// Accuracy and pace of the simulation of one cloth.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "presets", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothSolver {
    /// Substeps per second `[Hz]`. Default 360, range 30 to 10,000. Low stretches and lets fast bodies push deeper; cost is
    /// proportional. A cloth takes up to eight times as many while a body near it moves much faster than the pins. The same
    /// holds where a two-way body lies on lighter cloth, or where cloth would fall by more than an edge in a substep.
    pub substep_rate: f32,
    /// Most inner steps per second `[Hz]`. Default 3000, range 30 to 6000 (positions round the fall of a shorter step). Where
    /// edges are so short that substeps cannot carry tension along the cloth
    /// ([`ClothReport::drape_rate`](crate::ClothReport::drape_rate)), each is cut into inner steps. They solve forces, bending,
    /// springs and pins, so fine cloth drapes as its fabric and stretches less. Contacts and bounds on lengths are solved once
    /// in a substep. Low hangs limper; 30 is none.
    pub inner_rate: f32,
    /// Longest frame that is simulated `[s]`. Default 0.1, range 0.001 to 1. Time beyond it is counted in
    /// [`ClothReport::lost_time`](crate::ClothReport::lost_time).
    pub max_frame: f32,
    /// The membrane: resists stretch and shear. Default [`ClothMembrane::Auto`].
    pub membrane: ClothMembrane,
    /// Scale of [`ClothGravity`] (dimensionless). Default 1, range -100 to 100.
    pub gravity_scale: f32,
    /// Pace of this cloth over that of its clock (dimensionless). Default 1, range 0 to 10; 0 stops it. How long it is tangled or
    /// held goes by the clock.
    pub time_scale: f32,
    /// Teleport mode: what the cloth does when its carrier jumps. Default [`ClothTeleportMode::Keep`].
    pub teleport: ClothTeleportMode,
    /// Least jump of the carrier in a frame that counts as a teleport `[m]`, if it is faster than 25 m/s. Default 1, range
    /// 0.001 to 1e6; three times the cloth's radius counts when that is larger.
    pub teleport_distance: f32,
    /// Least turn of the carrier in a frame that counts as a teleport `[rad]`, if it is faster than 1,800 degrees a second.
    /// Default 60 degrees, range 0.01 to pi.
    pub teleport_angle: f32,
    /// Edge length over rest length beyond which the cloth is taken back to its last good state (dimensionless). Default 5,
    /// range 1.1 to 1000.
    pub reset_edge_ratio: f32,
    /// Speed beyond which the cloth is taken back to its last good state `[m/s]`. Default 1000, range 1 to 1e5.
    pub max_speed: f32,
}

/// What a cloth does when its carrier jumps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "presets", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub enum ClothTeleportMode {
    /// Nothing: the cloth is dragged along.
    None,
    /// It is carried rigidly and keeps shape and velocity.
    #[default]
    Keep,
    /// It starts again on its animated skin, or in its pose at rest if it has none.
    Reset,
}

/// Membrane: the elements that resist stretch and shear in the plane of a cloth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[cfg_attr(feature = "presets", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub enum ClothMembrane {
    /// Springs where the edges of the mesh run along the threads, as on a grid, or where nothing tells the threads; triangles
    /// elsewhere.
    #[default]
    Auto,
    /// A spring on each edge (Provot 1995). Fast, and exact on grids along the threads; on any other mesh it shears as little
    /// as it stretches.
    Springs,
    /// Stretch along warp and weft and shear between them, triangle by triangle (strain-based dynamics, Müller et al. 2014):
    /// the same on every mesh. The directions are those of the texture coordinates, turned by
    /// [`warp_angle`](crate::ClothMaterial::warp_angle); without any it is springs.
    Triangles,
}

impl From<ClothMembrane> for MembraneModel {
    fn from(membrane: ClothMembrane) -> Self {
        match membrane {
            ClothMembrane::Auto => Self::Auto,
            ClothMembrane::Springs => Self::Springs,
            ClothMembrane::Triangles => Self::Triangles,
        }
    }
}

impl Default for ClothSolver {
    fn default() -> Self {
        Self {
            substep_rate: 360.0,
            inner_rate: 3000.0,
            max_frame: 0.1,
            membrane: ClothMembrane::Auto,
            gravity_scale: 1.0,
            time_scale: 1.0,
            teleport: ClothTeleportMode::Keep,
            teleport_distance: 1.0,
            teleport_angle: 60.0_f32.to_radians(),
            reset_edge_ratio: 5.0,
            max_speed: 1000.0,
        }
    }
}

impl ClothSolver {
    pub(crate) fn stepping(&self, checked: &mut Checked) -> Stepping {
        Stepping {
            substep_rate: checked.within("substep_rate", self.substep_rate, 360.0, 30.0, 10_000.0),
            max_frame: checked.within("max_frame", self.max_frame, 0.1, 0.001, 1.0),
            inner_rate: checked.within("inner_rate", self.inner_rate, 3000.0, 30.0, 6000.0),
            membrane: self.membrane.into(),
        }
    }

    pub(crate) fn limits(&self, checked: &mut Checked) -> Limits {
        Limits {
            edge_ratio: checked.within("reset_edge_ratio", self.reset_edge_ratio, 5.0, 1.1, 1000.0),
            speed: checked.within("max_speed", self.max_speed, 1000.0, 1.0, 1.0e5),
        }
    }

    pub(crate) fn time_scale(&self, checked: &mut Checked) -> f32 {
        checked.within("time_scale", self.time_scale, 1.0, 0.0, 10.0)
    }

    pub(crate) fn gravity(&self, gravity: Vec3, checked: &mut Checked) -> Vec3 {
        gravity * checked.within("gravity_scale", self.gravity_scale, 1.0, -100.0, 100.0)
    }

    pub(crate) fn teleport_limits(&self, checked: &mut Checked) -> (f32, f32) {
        (
            checked.within("teleport_distance", self.teleport_distance, 1.0, 0.001, 1.0e6),
            checked.within("teleport_angle", self.teleport_angle, 60.0_f32.to_radians(), 0.01, core::f32::consts::PI),
        )
    }
}

/// Gravity `[m/s²]` for every cloth. Default `(0, -9.81, 0)`; longer than 1e4 is shortened.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Resource, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothGravity(pub Vec3);

impl ClothGravity {
    /// Gravity of the Earth `[m/s²]`.
    pub const EARTH: Vec3 = Vec3::new(0.0, -9.81, 0.0);

    pub(crate) fn checked(&self, checked: &mut Checked) -> Vec3 {
        checked.vector("gravity", self.0, Self::EARTH, 1.0e4)
    }
}

impl Default for ClothGravity {
    fn default() -> Self {
        Self(Self::EARTH)
    }
}
