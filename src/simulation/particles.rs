//! State: the particles and what is kept of them, and how they may be moved from outside.

use bevy::math::{Affine3A, DVec3};
use bevy::prelude::*;

use crate::solver::impulse;
use crate::solver::sim::ClothSim;
use crate::solver::state::ClothState;

/// State: the particles, in a frame with the axes of the world and its origin near the cloth.
#[derive(Component, Clone, Debug)]
#[component(clone_behavior = Ignore)]
pub struct ClothParticles {
    /// What the solver keeps of the cloth.
    pub(crate) sim: ClothSim,
    /// Origin of the frame of simulation in the world `[m]`.
    pub(crate) origin: DVec3,
    /// Positions at the start of the last frame `[m]`; only kept when shown positions are interpolated.
    pub(crate) before: Vec<Vec3>,
    /// Where the carrier was in the last simulated frame.
    pub(crate) carrier: Option<Isometry3d>,
    /// The space whose motion it does not feel, and where that was in the last simulated frame.
    pub(crate) space: Option<(Entity, Isometry3d)>,
    /// Whether something other than a step moved it: it wakes.
    pub(crate) disturbed: bool,
    /// Whether the app may have put particles elsewhere, which is judged before others meet them there.
    pub(crate) written: bool,
    /// How often it was carried or put elsewhere as a whole: what was stepped meanwhile does not count.
    pub(crate) moves: u32,
}

impl ClothParticles {
    /// Particles in a frame of simulation with this origin in the world `[m]`.
    pub(crate) fn new(state: ClothState, origin: DVec3) -> Self {
        Self {
            sim: ClothSim::new(state),
            origin,
            before: Vec::new(),
            carrier: None,
            space: None,
            disturbed: false,
            written: false,
            moves: 0,
        }
    }

    /// Number of particles.
    #[must_use]
    pub fn len(&self) -> usize {
        self.sim.state.positions.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.sim.state.positions.is_empty()
    }

    /// Simulated positions in the world `[m]`, one per particle. The order is not that of the mesh's vertices:
    /// [`RestShape::particle_of_vertex`](crate::solver::rest::RestShape::particle_of_vertex) has the particle of each. With a
    /// [`ClothDecimation`](crate::ClothDecimation) that may be another vertex nearby.
    pub fn world_positions(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.sim.state.positions.iter().map(|x| self.origin + x.truncate().as_dvec3())
    }

    /// Positions to show in the world `[m]`, one per particle: the simulated ones, except where a tangled cloth is held. With a
    /// fixed clock, what is drawn lies between these and those of the frame before.
    pub fn shown_positions(&self) -> impl Iterator<Item = DVec3> + '_ {
        let held = self.sim.display.held().filter(|held| held.len() == self.len());
        let live = self.sim.state.positions.iter().enumerate();
        live.map(move |(i, x)| self.origin + held.map_or(x.truncate(), |held| held[i]).as_dvec3())
    }

    /// State of the solver, relative to [`Self::origin`].
    #[must_use]
    pub fn state(&self) -> &ClothState {
        &self.sim.state
    }

    /// State of the solver, to be changed at your own risk: lengths must stay, and the next frame judges the numbers.
    #[must_use]
    pub fn state_mut(&mut self) -> &mut ClothState {
        (self.disturbed, self.written) = (true, true);
        &mut self.sim.state
    }

    /// Gives an impulse `[N·s]` to the particles within `radius` `[m]` of a point in the world `[m]`, as one piece, fading
    /// towards the rim. Held particles stay; no velocity changes by more than 100 m/s. Returns how many particles took part;
    /// none when a number is not finite or `radius` not above 0. Cloth that is missed sleeps on.
    pub fn apply_impulse(&mut self, point: Vec3, impulse: Vec3, radius: f32) -> u32 {
        let point = (point.as_dvec3() - self.origin).as_vec3();
        let moved = impulse::impulse(&mut self.sim.state, point, impulse, radius);
        self.note_written(moved)
    }

    /// Blows the particles within `radius` `[m]` away from a point in the world `[m]`. `impulse` `[N·s]` is the sum of the
    /// magnitudes if all free particles were at the point, and fades to nothing at `radius`. Directions differ, so the net
    /// impulse is smaller. Held particles stay; no velocity changes by more than 100 m/s. Returns how many particles took part;
    /// none when a number is not finite or `radius` not above 0. Cloth that is missed sleeps on.
    pub fn apply_explosion(&mut self, center: Vec3, impulse: f32, radius: f32) -> u32 {
        let center = (center.as_dvec3() - self.origin).as_vec3();
        let moved = impulse::explosion(&mut self.sim.state, center, impulse, radius);
        self.note_written(moved)
    }

    /// Notes that `moved` particles were moved from outside. Cloth sleeps on if none was.
    fn note_written(&mut self, moved: u32) -> u32 {
        if moved > 0 {
            (self.disturbed, self.written) = (true, true);
        }
        moved
    }

    /// Notes that it is put elsewhere.
    fn note_moved(&mut self) {
        self.disturbed = true;
        self.moves = self.moves.wrapping_add(1);
    }

    /// Origin of the frame of simulation in the world `[m]`.
    #[must_use]
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// Moves every position the particles remember.
    pub(crate) fn carry(&mut self, motion: impl Fn(Vec3) -> Vec3) {
        self.note_moved();
        for x in self.sim.state.positions.iter_mut().chain(&mut self.sim.state.previous) {
            *x = motion(x.truncate()).extend(x.w);
        }
        for x in &mut self.before {
            *x = motion(*x);
        }
        self.sim.display.carry(&motion);
        self.sim.recovery.carry(motion);
    }

    /// Moves every particle with what is beneath it; one of which nothing is known stays.
    pub(crate) fn carry_each(&mut self, motion: impl Fn(usize) -> Option<Affine3A>) {
        self.note_moved();
        let ClothState { positions, previous, .. } = &mut self.sim.state;
        for (i, (x, old)) in positions.iter_mut().zip(previous).enumerate() {
            if let Some(motion) = motion(i) {
                *x = motion.transform_point3(x.truncate()).extend(x.w);
                *old = motion.transform_point3(old.truncate()).extend(old.w);
            }
        }
        self.before.clear();
    }

    /// Puts every particle at `pose` `[m]`, without velocity.
    pub(crate) fn place(&mut self, pose: impl Iterator<Item = Vec3>) {
        self.note_moved();
        let state = &mut self.sim.state;
        for ((x, old), at) in state.positions.iter_mut().zip(&mut state.previous).zip(pose) {
            *x = at.extend(x.w);
            *old = *x;
        }
        state.folds.clear();
        self.before.clear();
        self.sim.display.reset();
        self.sim.recovery.start(&self.sim.state);
    }
}
