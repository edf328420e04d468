//! The particles of an island while they are stepped, side by side. They are taken in once a frame and published once.
//!
//! Each cloth stays in its own frame of simulation. So one that touches nothing has the same bits in any group. Untangling
//! keeps cloth apart here, too, since pairs know their cloths so.

use glam::Vec4;

use super::Member;
use crate::solver::detect::{Part, Surface};
use crate::solver::state::StateMut;
use crate::solver::step::{Memory, Stepped};

/// All particles of an island, those of a cloth in a row.
#[derive(Debug, Default)]
pub(super) struct StepParticles {
    /// `xyz` position `[m]`, `w` inverse mass `[1/kg]`: 0 for a cloth that is not stepped. NaN for one that does not fit.
    pub(super) positions: Vec<Vec4>,
    /// `xyz` position when the substep began `[m]`: the same for a cloth that is not stepped.
    pub(super) previous: Vec<Vec4>,
}

impl StepParticles {
    /// Takes in all cloths.
    pub(super) fn take_in(&mut self, surface: &Surface, cloths: &[Member<'_>]) {
        let Self { positions, previous } = self;
        positions.clear();
        previous.clear();
        for (part, m) in surface.parts.iter().zip(cloths) {
            if m.is_stepped(part) {
                positions.extend_from_slice(&m.sim.state.positions);
                previous.extend_from_slice(&m.sim.state.previous);
            } else if m.fits(part) {
                positions.extend(m.sim.state.positions.iter().map(|x| x.with_w(0.0)));
                previous.extend_from_slice(&m.sim.state.positions);
            } else {
                let n = positions.len() + part.particles.len();
                [&mut *positions, previous].into_iter().for_each(|all| all.resize(n, Vec4::NAN));
            }
        }
    }

    /// Whether there are as many as in the `surface`.
    pub(super) fn are_whole(&self, surface: &Surface) -> bool {
        [&self.positions, &self.previous].iter().all(|all| all.len() == surface.len())
    }

    /// Gives those back that were stepped.
    pub(super) fn publish(&self, surface: &Surface, cloths: &mut [Member<'_>]) {
        for (part, m) in surface.parts.iter().zip(cloths).filter(|(part, m)| m.is_stepped(part)) {
            let [positions, previous] = self.of(part);
            m.sim.state.positions.copy_from_slice(positions);
            m.sim.state.previous.copy_from_slice(previous);
        }
    }

    /// Calls `act` with a cloth and its particles, if it is stepped.
    pub(super) fn with<T>(
        &mut self,
        part: &Part,
        m: &mut Member<'_>,
        act: impl FnOnce(&Stepped<'_>, &mut StateMut<'_>, &mut Memory) -> T,
    ) -> Option<T> {
        m.is_stepped(part).then(|| {
            let (positions, previous) = (&mut self.positions[part.range()], &mut self.previous[part.range()]);
            act(&m.cloth, &mut m.sim.state.with_particles(positions, previous), &mut m.sim.memory)
        })
    }

    /// Where the particles of a cloth are, and where they were when the substep began `[m]`.
    pub(super) fn of(&self, part: &Part) -> [&[Vec4]; 2] {
        [&self.positions, &self.previous].map(|all| &all[part.range()])
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{Vec3, vec3};

    use crate::solver::evaluate::EvaluateSettings;
    use crate::solver::island::{Stage, UntangleSettings};
    use crate::solver::rest::RestShape;
    use crate::solver::scene::{Scene, SceneCloth, Untangling, grid};
    use crate::solver::settings::Fabric;

    /// Where the particles of a sheet are that fell on another, and how many pairs touch then. Its frame of simulation is at
    /// `origin` `[m]` in that of the island.
    fn fallen(origin: Vec3) -> (Vec<Vec3>, u32) {
        let mesh = grid(12, 12, |u, v| vec3(u - 0.5, 0.02 * (9.0 * u).sin(), v - 0.5));
        let rest = Arc::new(RestShape::build(&mesh).expect("a sheet").0);
        let cloth = |at: Vec3, pins: &[u32]| SceneCloth::new(rest.clone(), Fabric::default(), at, pins);
        let scene = Scene::new(vec![cloth(Vec3::ZERO, &[0, 11, 132, 143]), cloth(0.05 * Vec3::Y - origin, &[])]);
        let mut scene = scene.untangled(UntangleSettings::default(), EvaluateSettings::default(), true).expect("two sheets");
        for _ in 0..30 {
            let (Untangling { island, settings, .. }, mut members) = scene.together(1.0 / 60.0).expect("an island");
            members[1].offset = origin;
            Stage::FRAME.into_iter().for_each(|stage| island.run(stage, 1.0 / 60.0, settings, &mut members));
        }
        let touching = scene.untangle.as_ref().map_or(0, |untangling| untangling.island.pairs().1);
        (scene.cloths[1].sim.state.positions.iter().map(|x| x.truncate() + origin).collect(), touching)
    }

    #[test]
    fn cloths_meet_where_they_are_whatever_frames_they_are_simulated_in() {
        let (expected, touching) = fallen(Vec3::ZERO);
        assert!(touching > 100, "{touching}");
        for origin in [vec3(0.5, -1.0, 0.25), vec3(-4.0, 2.0, 1.0)] {
            let (positions, _) = fallen(origin);
            let farthest = positions.iter().zip(&expected).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
            assert!(farthest < 5.0e-3, "{origin}: {farthest}");
        }
    }
}
