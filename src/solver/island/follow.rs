//! What an island knows goes along when something else than a frame moves all of it as one, as a teleport or inertia does.
//!
//! ```text
//!   x0 ─► q x0 + c     where it was when nothing crossed, where pairs were looked for, which way they touch
//! ```
//!
//! What was clean together and moves together is clean. Where cloths of an island went different ways, or one changed its
//! shape, nobody knows whether they passed through each other.

use glam::{Vec3, Vec3A, Vec4};

use super::{Island, Member};
use crate::solver::rigid::Rigid;

/// How far a particle may be from where a frame left it when the next one begins, in mean edges.
const MOVED_EDGES: f32 = 0.01;

/// Particles by which a motion is found: any three that are not in a row would do, and more take out rounding.
const SAMPLES: usize = 64;

impl Island {
    /// Carries what is known along with cloths that are to begin the next frame elsewhere than the last one left them. Forgets
    /// where nothing crossed if they did not go there as one.
    pub(super) fn follow(&mut self, cloths: &[Member<'_>]) {
        if self.surface.parts.iter().zip(cloths).any(|(part, m)| !m.fits(part)) {
            self.rollback.forget();
            return;
        }
        let limit = MOVED_EDGES * self.surface.mean_edge;
        // NaN passes no comparison.
        let is_at = |x: Vec3A, there: Vec3A| x.distance_squared(there) <= limit * limit;
        let before = self.neighbors.before();
        let now = |m: &Member<'_>, x: Vec4| Vec3A::from_vec4(x) + Vec3A::from(m.offset);
        let of = || self.surface.parts.iter().zip(cloths).map(|(part, m)| (m, before[part.range()].iter()));
        let each = || of().flat_map(|(m, before)| before.zip(&m.state.positions).map(move |(old, &x)| (*old, now(m, x))));
        let mut moving = of().filter(|(m, _)| m.moves);
        if moving.all(|(m, mut before)| m.state.positions.iter().zip(&mut before).all(|(&x, old)| is_at(now(m, x), *old))) {
            return;
        }
        let stride = (self.surface.len() / SAMPLES).max(1);
        let motion = Rigid::fit(|| each().step_by(stride).map(|(old, x)| (Vec3::from(old), Vec3::from(x))));
        if each().all(|(old, x)| is_at(x, motion.point(old.into()).into())) {
            self.rollback.be_at(each().map(|(_, x)| x));
            self.neighbors.follow(&motion);
            self.contacts.turn(motion.turn);
        } else {
            self.rollback.forget();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{Affine3A, Quat, Vec3, vec3};

    use crate::solver::evaluate::EvaluateSettings;
    use crate::solver::island::{Stage, UntangleSettings};
    use crate::solver::rest::RestShape;
    use crate::solver::scene::{Scene, SceneCloth, Untangling, grid};
    use crate::solver::settings::Fabric;

    const FRAME: f32 = 1.0 / 60.0;

    /// A sheet that lies on one that hangs.
    fn lying() -> Scene {
        let mesh = grid(12, 12, |u, v| vec3(u - 0.5, 0.02 * (9.0 * u).sin(), v - 0.5));
        let rest = Arc::new(RestShape::build(&mesh).expect("a sheet").0);
        let cloth = |height: f32, pins: &[u32]| SceneCloth::new(rest.clone(), Fabric::default(), height * Vec3::Y, pins);
        let scene = Scene::new(vec![cloth(0.0, &[0, 11, 132, 143]), cloth(0.05, &[])]);
        let scene = scene.untangled(UntangleSettings::default(), EvaluateSettings::default(), true);
        let mut scene = scene.expect("two sheets");
        (0..20).for_each(|_| scene.step(FRAME));
        scene
    }

    /// Carries a cloth, without a frame.
    fn carry(cloth: &mut SceneCloth, by: Affine3A) {
        let SceneCloth { state, anchors, .. } = cloth;
        let points = state.positions.iter_mut().chain(&mut state.previous);
        points.for_each(|x| *x = by.transform_point3(x.truncate()).extend(x.w));
        anchors.from.iter_mut().chain(&mut anchors.to).for_each(|x| *x = by.transform_point3(*x));
    }

    /// Whether it is known where nothing crossed when cloths begin the next frame, each after a motion of its own, and how far
    /// the frame ended from where it ends without, carried by the first of them `[m]`.
    fn after(motions: [Affine3A; 2], offset: Vec3) -> (bool, f32) {
        let (mut scene, mut still) = (lying(), lying());
        scene.cloths.iter_mut().zip(motions).for_each(|(cloth, motion)| carry(cloth, motion));
        still.step(FRAME);
        let (Untangling { island, settings, .. }, mut members) = scene.together(FRAME).expect("an island");
        members.iter_mut().for_each(|m| m.offset = offset);
        island.run(Stage::Integrate, FRAME, settings, &mut members);
        let knows = island.rollback.knows();
        Stage::AFTER_INTEGRATE.into_iter().for_each(|stage| island.run(stage, FRAME, settings, &mut members));
        let all = |scene: &Scene| -> Vec<Vec3> {
            scene.cloths.iter().flat_map(|cloth| &cloth.state.positions).map(|x| x.truncate()).collect()
        };
        let farthest = all(&scene).into_iter().zip(all(&still)).map(|(x, y)| x.distance(motions[0].transform_point3(y)));
        (knows, farthest.fold(0.0, f32::max))
    }

    #[test]
    fn cloths_that_are_carried_as_one_go_on_as_if_they_had_not_been() {
        for (turn, by) in [(0.0, vec3(3.0, 0.5, -1.0)), (0.5, Vec3::ZERO), (1.0, vec3(-2.0, 0.0, 1.0))] {
            let motion = Affine3A::from_rotation_translation(Quat::from_rotation_y(turn), by);
            let (knows, farthest) = after([motion; 2], Vec3::ZERO);
            assert!(knows && farthest < 2.0e-3, "{turn}, {by}: {knows}, {farthest} m");
        }
        let (knows, farthest) = after([Affine3A::IDENTITY; 2], vec3(0.0, 0.0, 2.0));
        assert!(knows && farthest < 2.0e-3, "their frame of simulation was carried: {knows}, {farthest} m");
    }

    #[test]
    fn cloths_that_go_different_ways_may_have_passed_through_each_other() {
        let by = |by: Vec3| Affine3A::from_translation(by);
        assert!(!after([by(Vec3::ZERO), by(vec3(0.0, -0.1, 0.0))], Vec3::ZERO).0, "one alone");
        assert!(!after([by(Vec3::X), by(Vec3::Y)], Vec3::ZERO).0, "two ways");
    }
}
