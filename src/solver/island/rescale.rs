//! A cloth of the island gets a shape at rest that is a multiple of the one before, when the scale of its entity changes.

use super::Island;

impl Island {
    /// Gives cloth `part` a shape at rest that is a [multiple](crate::solver::rest::RestShape::is_multiple_of) of the one
    /// before, `rest` `[m]`; false if it has another number of particles. The topology of the tree stays: it is cut
    /// where the shape is, however large.
    pub(crate) fn rescale(&mut self, part: usize, rest: &[glam::Vec3]) -> bool {
        if !self.surface.reshape(part, rest) {
            return false;
        }
        self.neighbors.measure(&self.surface);
        self.untangler.detector.rescale(&self.surface);
        self.known = false;
        self.rollback.forget();
        true
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{Vec3, vec3};

    use crate::solver::evaluate::EvaluateSettings;
    use crate::solver::island::UntangleSettings;
    use crate::solver::rest::RestShape;
    use crate::solver::scene::{Scene, SceneCloth, grid};
    use crate::solver::settings::Fabric;

    /// A sheet that falls on another, both of 12² vertices.
    fn scene(rest: &Arc<RestShape>) -> Scene {
        let cloth = |y: f32, pins: &[u32]| SceneCloth::new(rest.clone(), Fabric::default(), vec3(0.03 * y, y, 0.0), pins);
        let scene = Scene::new(vec![cloth(0.0, &[0, 11, 132, 143]), cloth(0.05, &[])]);
        scene.untangled(UntangleSettings::default(), EvaluateSettings::default(), true).expect("two sheets")
    }

    #[test]
    fn an_island_that_was_rescaled_does_what_one_of_that_size_does() {
        let mesh = grid(12, 12, |u, v| vec3(u - 0.5, 0.02 * (9.0 * u).sin(), v - 0.5));
        let small = Arc::new(RestShape::build(&mesh).expect("a sheet").0);
        let large = Arc::new(small.scaled(2.0).expect("a sheet"));
        let mut rescaled = scene(&large);
        let other = scene(&small).untangle.expect("an island");
        rescaled.untangle.as_mut().expect("an island").island = other.island;
        let island = &mut rescaled.untangle.as_mut().expect("an island").island;
        assert!((0..2).all(|part| island.rescale(part, &large.positions)));
        assert!(!island.rescale(0, &[Vec3::ZERO]) && !island.rescale(2, &large.positions));
        let mut expected = scene(&large);
        for frame in 0..40 {
            [&mut rescaled, &mut expected].into_iter().for_each(|scene| scene.step(1.0 / 60.0));
            let equal = rescaled.cloths.iter().zip(&expected.cloths).all(|(a, b)| a.sim.state == b.sim.state);
            assert!(equal, "frame {frame}");
        }
        let touching = |scene: &Scene| scene.untangle.as_ref().map_or(0, |u| u.island.contacts().len());
        assert!(touching(&expected) > 0, "nothing met");
    }
}
