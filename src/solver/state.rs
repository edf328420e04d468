//! What changes from frame to frame.

use glam::{Vec3, Vec4};

/// Particles of one cloth in its frame of simulation (axes of the world, origin near the cloth).
///
/// Velocities are implicit, `(position - previous) / substep`: a kernel that moves both arrays by the same vector moves
/// the cloth without adding velocity.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct ClothState {
    /// `xyz` position `[m]`, `w` inverse mass `[1/kg]`; 0 = pinned. One per particle, in the order of `RestShape`.
    pub positions: Vec<Vec4>,
    /// `xyz` position `[m]` at the start of the last substep, `w` inverse mass `[1/kg]` as in [`positions`](Self::positions).
    /// One per particle.
    pub previous: Vec<Vec4>,
    /// Curvature `[1/m]` from which the friction between yarns holds each element of `RestShape::bends`, by lane; empty before
    /// the first frame.
    pub folds: Vec<Vec4>,
    /// Length of the last substep `[s]`; 0 before the first.
    pub substep: f32,
    /// Substeps taken since the start.
    pub substeps: u64,
    /// Simulated time since the start `[s]`.
    pub time: f64,
}

/// A cloth while it is stepped: its [`ClothState`], with its particles where the island has them.
#[derive(Debug)]
pub(crate) struct StateMut<'a> {
    /// As in [`ClothState`].
    pub positions: &'a mut [Vec4],
    /// As in [`ClothState`].
    pub previous: &'a mut [Vec4],
    /// As in [`ClothState`].
    pub folds: &'a mut Vec<Vec4>,
    /// As in [`ClothState`].
    pub substep: &'a mut f32,
    /// As in [`ClothState`].
    pub substeps: &'a mut u64,
    /// As in [`ClothState`].
    pub time: &'a mut f64,
}

impl ClothState {
    /// The cloth with its particles where they are.
    pub(crate) fn as_mut(&mut self) -> StateMut<'_> {
        let Self { positions, previous, folds, substep, substeps, time } = self;
        StateMut { positions, previous, folds, substep, substeps, time }
    }

    /// The cloth with particles that an island has in place of its own: as many of both.
    pub(crate) fn with_particles<'a>(&'a mut self, positions: &'a mut [Vec4], previous: &'a mut [Vec4]) -> StateMut<'a> {
        StateMut { positions, previous, ..self.as_mut() }
    }

    /// Velocity `[m/s]` of particle `i` over the last substep; zero before the first.
    #[must_use]
    pub fn velocity(&self, i: usize) -> Vec3 {
        if self.substep > 0.0 { (self.positions[i] - self.previous[i]).truncate() / self.substep } else { Vec3::ZERO }
    }
}
