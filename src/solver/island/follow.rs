//! What an island knows goes along when something else than a frame moves all of it as one, as a teleport or inertia does.
//!
//! ```text
//!   x0 ─► q x0 + c     where it was when nothing crossed, where pairs were looked for, which way they touch
//! ```
//!
//! What was clean together and moves together is clean. Where cloths of an island went different ways, or one changed its
//! shape, they may have passed through each other.

use glam::{Vec3A, Vec4};

use super::{Island, Member};
use crate::solver::rigid::Rigid;

/// How far a particle may be from where a frame left it when the next one begins, in mean edges.
const MOVED_EDGES: f32 = 0.01;

/// Particles by which a motion is found, at least: any three that are not in a row would do, and more take out rounding.
const SAMPLES: usize = 64;

impl Island {
    /// Carries what is known along with cloths that are to begin the next frame elsewhere than the last one left them. Forgets
    /// where nothing crossed if they did not go there as one, or turned about. A cloth that is not stepped may go anywhere by
    /// itself: it is an obstacle, and looked at again after each step back.
    pub(super) fn follow(&mut self, cloths: &[Member<'_>]) {
        if self.surface.parts.iter().zip(cloths).any(|(part, m)| !m.fits(part)) {
            self.rollback.forget();
            return;
        }
        let limit = MOVED_EDGES * self.surface.mean_edge;
        // NaN passes no comparison.
        let is_at = |x: Vec3A, there: Vec3A| x.distance_squared(there) <= limit * limit;
        // Each particle, where the last frame left it, and where it is; and whether it is stepped.
        let now = |m: &Member<'_>, x: &Vec4| (Vec3A::from_vec4(*x) + Vec3A::from(m.offset), m.moves);
        let now = cloths.iter().flat_map(|m| m.sim.state.positions.iter().map(move |x| now(m, x)));
        let all = || self.neighbors.before().iter().copied().zip(now.clone());
        if all().all(|(before, (x, moves))| !moves || is_at(x, before)) {
            return;
        }
        let stride = (self.surface.len() / SAMPLES).max(1);
        let motion = Rigid::fit(|| all().step_by(stride).map(|(before, (x, _))| (before.into(), x.into())));
        if all().all(|(before, (x, _))| is_at(x, motion.point(before.into()).into())) {
            self.take_along(&motion);
        } else {
            self.rollback.forget();
        }
    }

    /// Takes everything that is known along on a motion of all cloths.
    pub(super) fn take_along(&mut self, motion: &Rigid) {
        self.rollback.follow(motion);
        self.neighbors.follow(motion);
        self.contacts.turn(motion.turn);
        self.untangler.resolver.follow(motion);
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
    use crate::solver::sim::ClothSim;

    const FRAME: f32 = 1.0 / 60.0;
    /// How far rounding may take particles in a few frames `[m]`.
    const FARTHEST: f32 = 1.0e-4;

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
        let SceneCloth { sim: ClothSim { state, .. }, anchors, .. } = cloth;
        let points = state.positions.iter_mut().chain(&mut state.previous);
        points.for_each(|x| *x = by.transform_point3(x.truncate()).extend(x.w));
        anchors.from.iter_mut().chain(&mut anchors.to).for_each(|x| *x = by.transform_point3(*x));
    }

    /// The state after a few frames, before each of which each cloth is carried on a motion of its own. It says whether all of
    /// them knew that nothing crossed. Then come the differences from cloth that is not carried: of the number of pairs that
    /// touch, and of places `[m]`.
    fn after(motions: [Affine3A; 2], offset: Vec3) -> (bool, u32, f32) {
        let (mut scene, mut still) = (lying(), lying());
        let (mut knows, mut sum) = (true, Affine3A::IDENTITY);
        for _ in 0..3 {
            sum = motions[0] * sum;
            scene.gravity = sum.transform_vector3(still.gravity);
            scene.cloths.iter_mut().zip(motions).for_each(|(cloth, motion)| carry(cloth, motion));
            still.step(FRAME);
            let (Untangling { island, settings, .. }, mut members) = scene.together(FRAME).expect("an island");
            members.iter_mut().for_each(|m| m.offset = offset);
            let begun: Vec<Vec3> =
                members.iter().flat_map(|m| m.sim.state.positions.iter().map(|x| x.truncate() + m.offset)).collect();
            island.run(Stage::Integrate, FRAME, settings, &mut members);
            knows &= island.rollback.knows_as_clean(&begun, FARTHEST);
            // The frame of the island goes along, as it does with inertia.
            island.carry(-offset);
            members.iter_mut().for_each(|m| m.offset = Vec3::ZERO);
            Stage::AFTER_INTEGRATE.into_iter().for_each(|stage| island.run(stage, FRAME, settings, &mut members));
        }
        let all = |scene: &Scene| -> Vec<Vec3> {
            scene.cloths.iter().flat_map(|cloth| &cloth.sim.state.positions).map(|x| x.truncate()).collect()
        };
        let off = all(&scene).into_iter().zip(all(&still)).map(|(x, y)| x.distance(sum.transform_point3(y)));
        let touching = |scene: &Scene| scene.untangle.as_ref().map_or(0, |u| u.island.pairs().1);
        (knows, touching(&scene).abs_diff(touching(&still)), off.fold(0.0, f32::max))
    }

    #[test]
    fn cloths_that_are_carried_as_one_go_on_as_if_they_had_not_been() {
        let about = |x: f32, y: f32, z: f32, turn: f32| Quat::from_axis_angle(vec3(x, y, z).normalize(), turn);
        let motions = [
            (Quat::IDENTITY, vec3(3.0, 0.5, -1.0)),
            (about(0.0, 1.0, 0.0, 1.0), vec3(-2.0, 0.0, 1.0)),
            (about(1.0, 1.0, 0.3, 1.3), Vec3::ZERO),
        ];
        for (turn, by) in motions {
            let motion = Affine3A::from_rotation_translation(turn, by);
            let (knows, other, farthest) = after([motion; 2], Vec3::ZERO);
            assert!(knows && other < 5 && farthest < FARTHEST, "{turn}, {by}: {knows}, {other} pairs, {farthest} m");
        }
        let (knows, other, farthest) = after([Affine3A::IDENTITY; 2], vec3(0.0, 0.0, 2.0));
        assert!(knows && other < 5 && farthest < FARTHEST, "their frame: {knows}, {other} pairs, {farthest} m");
    }

    #[test]
    fn a_tangle_that_is_carried_comes_apart_as_soon_as_one_that_is_not() {
        // Frames that a strip takes out of a sheet that it was stabbed through.
        let frames = |motion: Affine3A| {
            let sheet = grid(16, 16, |u, v| vec3(u - 0.5, 0.0, v - 0.5));
            let strip = grid(4, 16, |u, v| vec3(0.2 * (u - 0.47), v - 0.72, 0.03 + 0.02 * u));
            let cloth =
                |mesh| SceneCloth::new(Arc::new(RestShape::build(&mesh).expect("cloth").0), Fabric::default(), Vec3::ZERO, &[]);
            let scene = Scene::new(vec![cloth(sheet), cloth(strip)]);
            let scene = scene.untangled(UntangleSettings::default(), EvaluateSettings::default(), true);
            let mut scene = scene.expect("a sheet and a strip");
            scene.gravity = Vec3::ZERO;
            (0..200).find(|_| {
                scene.cloths.iter_mut().for_each(|cloth| carry(cloth, motion));
                scene.step(FRAME);
                scene.crossings() == 0
            })
        };
        let still = frames(Affine3A::IDENTITY);
        let turned = frames(Affine3A::from_quat(Quat::from_axis_angle(vec3(1.0, 1.0, 0.3).normalize(), 1.3)));
        assert!(still.is_some_and(|still| still > 0) && turned == still, "{still:?}, {turned:?}");
    }

    #[test]
    fn cloths_that_go_different_ways_may_have_passed_through_each_other() {
        let by = |by: Vec3| Affine3A::from_translation(by);
        assert!(!after([by(Vec3::ZERO), by(vec3(0.0, -0.1, 0.0))], Vec3::ZERO).0, "one alone");
        assert!(!after([by(Vec3::X), by(Vec3::Y)], Vec3::ZERO).0, "two ways");
    }

    #[test]
    fn an_obstacle_that_goes_by_itself_is_no_reason_to_forget() {
        let mut scene = lying();
        carry(&mut scene.cloths[1], Affine3A::from_translation(vec3(0.0, 0.02, 0.0)));
        let (Untangling { island, settings, .. }, mut members) = scene.together(FRAME).expect("an island");
        members[1].moves = false;
        island.run(Stage::Integrate, FRAME, settings, &mut members);
        assert!(island.rollback.knows());
    }
}
