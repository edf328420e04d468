//! Pose: what a save game keeps of a cloth.

use bevy::math::DVec3;
use bevy::prelude::*;

use super::particles::ClothParticles;

/// Positions and velocities of the particles of a cloth, for save games. [`ClothParticles::pose`] takes it. On the entity of a
/// cloth with as many particles, in any process, it is an input. The cloth is put into that pose, and the component is removed.
/// Its contacts are found anew.
///
/// A cloth that waits for its mesh, or is stopped, gets its pose when it is simulated. A skinned cloth gets it after the frames
/// in which it is put on its skin. Held particles stay with what holds them. A pose that does not fit is named in a warning,
/// and changes nothing. [`ClothSnapshot`](crate::ClothSnapshot) keeps everything, bit by bit, within one world.
#[derive(Component, Clone, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), reflect(Serialize, Deserialize))]
pub struct ClothPose {
    /// Positions in the world `[m]`, one per particle, within 1000 m of the cloth's entity.
    pub positions: Vec<DVec3>,
    /// Velocities `[m/s]`, one per particle; 100 m/s is the fastest that one gets.
    pub velocities: Vec<Vec3>,
}

impl ClothParticles {
    /// Positions and velocities, for a save game.
    #[must_use]
    pub fn pose(&self) -> ClothPose {
        let velocities = (0..self.len()).map(|i| self.sim.state.velocity(i)).collect();
        ClothPose { positions: self.world_positions().collect(), velocities }
    }
}
