//! A cloth as its island sees it.

use glam::Vec3;

use crate::solver::detect::Part;
use crate::solver::fit::fit;
use crate::solver::settings::Stepping;
use crate::solver::sim::ClothSim;
use crate::solver::step::Stepped;

/// A cloth of an island, in a frame.
#[derive(Debug)]
pub struct Member<'a> {
    /// What it is stepped with; its frame takes no time where it does not move.
    pub cloth: Stepped<'a>,
    /// Its substeps; all take as many as the one that needs most.
    pub stepping: &'a Stepping,
    /// See [`ClothSim`].
    pub sim: &'a mut ClothSim,
    /// Where its animation puts its particles. Without one, the cloth is drawn to its shape at rest when nothing else takes it
    /// out of a tangle.
    pub animation: Option<&'a dyn Animation>,
    /// From its frame of simulation to that of the island `[m]`.
    pub offset: Vec3,
    /// Whether it is stepped. What is not is an obstacle for the others.
    pub moves: bool,
    /// Time that passes by its clock, whether it moves or not `[s]`.
    pub clock: f32,
    /// Whether untangling leaves it where it is.
    pub fixed: bool,
    /// Whether nothing moves it: it stays where it is, whatever speed it had.
    pub still: bool,
    /// Whether it rests on others and itself, or passes through.
    pub contact: bool,
    /// Whether it is to be taken apart at once if it crosses in its first frame.
    pub at_load: bool,
    /// Time for which it is tangled before it is drawn to its pose `[s]`.
    pub last_resort: f32,
}

impl Member<'_> {
    /// Whether it has as many particles as its part of the island.
    pub(super) fn fits(&self, part: &Part) -> bool {
        [&self.sim.state.positions, &self.sim.state.previous].iter().all(|all| all.len() == part.particles.len())
    }

    /// Whether it fits, and is stepped.
    pub(super) fn is_stepped(&self, part: &Part) -> bool {
        self.moves && self.fits(part)
    }

    /// Writes the pose that it is drawn to when nothing else helps `[m]`: the animated one, or the shape at rest where that
    /// fits best.
    pub(super) fn pose(&self, pose: &mut Vec<Vec3>) {
        pose.clear();
        match self.animation {
            Some(animation) => pose.extend((0..self.sim.state.positions.len()).map(|i| animation.position(i))),
            None => fit(self.cloth.rest, &self.sim.state.positions, pose),
        }
    }
}

/// The animated pose of a cloth.
pub trait Animation: Sync + core::fmt::Debug {
    /// Where it puts a particle `[m]`, in the frame of simulation of the cloth.
    fn position(&self, particle: usize) -> Vec3;
}

impl Animation for Vec<Vec3> {
    fn position(&self, particle: usize) -> Vec3 {
        self.get(particle).copied().unwrap_or(Vec3::NAN)
    }
}
