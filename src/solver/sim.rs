//! Everything that the solver keeps of one cloth.

use super::display::Display;
use super::recover::Recovery;
use super::state::ClothState;
use super::step::{Memory, StepReport};

/// What decides the next frame of one cloth, beside its rest shape, its settings, and what acts on it. A copy is a snapshot of
/// the cloth; of cloths that meet, their [`Island`](super::island::Island) belongs to it.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct ClothSim {
    /// Its particles.
    pub state: ClothState,
    /// What the last frames left, such as contacts and loads.
    pub memory: Memory,
    /// What it shows while it is tangled, and its last clean shape.
    pub display: Display,
    /// Its last good state, and how often that was needed.
    pub recovery: Recovery,
    /// Report of the last frame in which an island stepped it, until it is taken. Decides nothing.
    pub report: Option<StepReport>,
}

impl ClothSim {
    /// A cloth that begins in a `state`, which is taken to be good.
    #[must_use]
    pub fn new(state: ClothState) -> Self {
        let mut sim = Self { state, ..Self::default() };
        sim.recovery.start(&sim.state);
        sim
    }

    /// Forgets what touched it, and what its last frame did.
    pub fn forget(&mut self) {
        self.memory = Memory::default();
        self.report = None;
        self.recovery.end_frame();
    }
}
