//! Pose: what a save game keeps of a cloth.

use bevy::math::DVec3;
use bevy::prelude::*;

use super::particles::ClothParticles;
use crate::solver::impulse::{FASTEST, SUBSTEP};

/// Where the particles of a cloth are, and how fast: small enough for a save game, and good for a cloth of the same mesh in another process. What is not in
/// it, such as contacts, is found anew. [`ClothSnapshot`](crate::ClothSnapshot) keeps all of it, bit by bit, within one world.
///
/// [`ClothParticles::pose`] takes it, [`ClothParticles::set_pose`] puts it back.
#[derive(Clone, Debug, Default, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), reflect(Serialize, Deserialize))]
pub struct ClothPose {
    /// Positions in the world `[m]`, one per particle.
    pub positions: Vec<DVec3>,
    /// Velocities `[m/s]`, one per particle, each up to 100 m/s.
    pub velocities: Vec<Vec3>,
}

/// A [`ClothPose`] that a cloth cannot be put into.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ClothPoseError {
    /// It is of another mesh.
    #[error(
        "the pose has {positions} positions and {velocities} velocities, and the cloth {particles} particles: take the pose of a cloth with the same mesh"
    )]
    Length {
        /// Positions of the pose.
        positions: usize,
        /// Velocities of the pose.
        velocities: usize,
        /// Particles of the cloth.
        particles: usize,
    },
    /// A number is not finite, or too large.
    #[error(
        "particle {0} of the pose has a position or a velocity that is not finite, is farther than 1e6 m from the cloth, or faster than 100 m/s"
    )]
    Number(usize),
}

/// Farthest from the origin of its frame that a particle is put `[m]`.
const FARTHEST: f64 = 1.0e6;

impl ClothParticles {
    /// Where the particles are, and how fast.
    #[must_use]
    pub fn pose(&self) -> ClothPose {
        let velocities = (0..self.len()).map(|i| self.state.velocity(i)).collect();
        ClothPose { positions: self.world_positions().collect(), velocities }
    }

    /// Puts the particles where they were when the pose was taken, as fast as they were. Held particles stay with what holds them. A cloth with a skin is put
    /// on it in its first three frames: set its pose after them.
    ///
    /// # Errors
    /// [`ClothPoseError`] when the pose is of another mesh, or holds a number that cannot be used; then nothing changes.
    pub fn set_pose(&mut self, pose: &ClothPose) -> Result<(), ClothPoseError> {
        let ClothPose { positions, velocities } = pose;
        let particles = self.len();
        if positions.len() != particles || velocities.len() != particles {
            return Err(ClothPoseError::Length { positions: positions.len(), velocities: velocities.len(), particles });
        }
        let fits = |(x, v): (&DVec3, &Vec3)| (*x - self.origin).length() < FARTHEST && v.length() <= FASTEST * 1.001;
        if let Some(bad) = positions.iter().zip(velocities).position(|of| !fits(of)) {
            return Err(ClothPoseError::Number(bad));
        }
        let origin = self.origin;
        let state = self.state_mut();
        if state.substep <= 0.0 {
            state.substep = SUBSTEP;
        }
        let all = state.positions.iter_mut().zip(&mut state.previous);
        for ((x, old), (to, velocity)) in all.zip(positions.iter().zip(velocities)).filter(|((x, _), _)| x.w > 0.0) {
            let to = (*to - origin).as_vec3();
            *x = to.extend(x.w);
            *old = (to - *velocity * state.substep).extend(old.w);
        }
        state.folds.clear();
        self.before.clear();
        self.display.reset();
        self.recovery.start(&self.state);
        Ok(())
    }
}
