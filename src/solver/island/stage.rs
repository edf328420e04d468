//! The frame of an island, stage by stage.

use super::{Island, Member, UntangleSettings};

/// A stage of the frame of an island.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Steps all cloths side by side, and keeps apart what touches.
    Integrate,
    /// Looks for crossings, and for what may touch in the next frame.
    Detect,
    /// Takes apart what crosses.
    Resolve,
    /// Looks again where something moved; [`Island::verdict`] says what came of it. Needs no cloths.
    Evaluate,
    /// Looks for what may touch again, where something moved. Needs no cloths.
    Respond,
}

impl Stage {
    /// The frame: every stage once, in this order.
    pub const FRAME: [Self; 5] = [Self::Integrate, Self::Detect, Self::Resolve, Self::Evaluate, Self::Respond];
    /// The frame of cloths that were stepped one by one, since none of them rests on another:
    /// [`step`](crate::solver::step::step).
    pub const AFTER_INTEGRATE: [Self; 4] = {
        let [Self::Integrate, rest @ ..] = Self::FRAME else { unreachable!() };
        rest
    };
}

impl Island {
    /// Runs one stage of a frame of `dt` `[s]` on its cloths, in the order in which the island was made. Integrate, Detect and
    /// Resolve do nothing with other cloths than all of them.
    pub fn run(&mut self, stage: Stage, dt: f32, settings: &UntangleSettings, cloths: &mut [Member<'_>]) {
        let all = cloths.len() == self.surface.parts.len();
        match stage {
            Stage::Integrate if all => self.integrate(cloths),
            Stage::Detect if all => self.detect(cloths),
            Stage::Resolve if all => self.resolve(dt, settings, cloths),
            Stage::Evaluate => self.evaluate(),
            Stage::Respond => self.respond(),
            Stage::Integrate | Stage::Detect | Stage::Resolve => {}
        }
    }
}
