//! The particles of an island while they are stepped, side by side. They are taken in once a frame and published once.
//!
//! Each cloth stays in its own frame of simulation. So one that touches nothing has the same bits in any group.

use glam::Vec4;

use super::Member;
use crate::solver::detect::{Part, Surface};
use crate::solver::state::{ClothState, StateMut};
use crate::solver::step::{Scratch, Stepped};

/// All particles of an island, those of a cloth in a row.
#[derive(Debug, Default)]
pub(super) struct Moving {
    /// `xyz` position `[m]`, `w` inverse mass `[1/kg]`: 0 where nothing pushes its cloth. NaN is nobody.
    pub(super) now: Vec<Vec4>,
    /// `xyz` position when the substep began `[m]`: the same where nothing pushes its cloth.
    pub(super) old: Vec<Vec4>,
}

impl Moving {
    /// Takes in all cloths.
    pub(super) fn take_in(&mut self, surface: &Surface, cloths: &[Member<'_>]) {
        self.now.clear();
        self.old.clear();
        for (part, m) in surface.parts.iter().zip(cloths) {
            let ClothState { positions, previous, .. } = &*m.state;
            if !fits(m.state, part) {
                let n = self.now.len() + part.particles.len();
                [&mut self.now, &mut self.old].into_iter().for_each(|all| all.resize(n, Vec4::NAN));
            } else if m.moves {
                self.now.extend_from_slice(positions);
                self.old.extend_from_slice(previous);
            } else {
                self.now.extend(positions.iter().map(|x| x.with_w(0.0)));
                self.old.extend_from_slice(positions);
            }
        }
    }

    /// Gives them back.
    pub(super) fn publish(&self, surface: &Surface, cloths: &mut [Member<'_>]) {
        for (part, m) in surface.parts.iter().zip(cloths).filter(|(part, m)| m.moves && fits(m.state, part)) {
            let [now, old] = self.of(part);
            m.state.positions.copy_from_slice(now);
            m.state.previous.copy_from_slice(old);
        }
    }

    /// Calls `act` with a cloth and its particles, if it moves.
    pub(super) fn step<T>(
        &mut self,
        part: &Part,
        m: &mut Member<'_>,
        act: impl FnOnce(&Stepped<'_>, &mut StateMut<'_>, &mut Scratch) -> T,
    ) -> Option<T> {
        let Member { cloth, state, scratch, .. } = m;
        (m.moves && fits(state, part)).then(|| {
            let (now, old) = (&mut self.now[part.range()], &mut self.old[part.range()]);
            act(cloth, &mut state.as_mut_at(now, old), scratch)
        })
    }

    /// Where the particles of a cloth are, and where they were when the substep began `[m]`.
    pub(super) fn of(&self, part: &Part) -> [&[Vec4]; 2] {
        [&self.now, &self.old].map(|all| &all[part.range()])
    }
}

/// Whether a state has as many particles as its cloth.
fn fits(state: &ClothState, part: &Part) -> bool {
    [&state.positions, &state.previous].iter().all(|all| all.len() == part.particles.len())
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
        (scene.cloths[1].state.positions.iter().map(|x| x.truncate() + origin).collect(), touching)
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
