//! Which work a frame put off: what can grow beyond the size of the cloth is bounded, and goes on in the next frame.
//!
//! ```text
//!   look     no more pairs of faces and crossings than there may be visits  ─► the next look goes on with the next part
//!   within   no more looks for what strayed, once they were as much         ─► what slips by is rolled back as the frame ends
//!   asked    no more mean passes of the CCD, once they asked as many pairs  ─► what still passes is bounded at once
//!   resolve  contours in their order, until it was as much                  ─► the next iteration goes on with the next one
//! ```

use super::Island;
use crate::solver::effort::Effort;

/// What a frame put off, since it would have been too much work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Deferred {
    /// Contours about which nothing was done in the last iteration.
    pub contours: u32,
    /// Whether only a part of the cloth was looked at for crossings.
    pub crossings: bool,
    /// Whether pairs that may touch were left out.
    pub pairs: bool,
    /// Whether untangling at load goes on.
    pub load: bool,
}

impl Deferred {
    /// Whether the frame did all that there was to do.
    #[must_use]
    pub fn is_nothing(&self) -> bool {
        *self == Self::default()
    }
}

impl Island {
    /// Bounds the work of a frame to some `effort` for each face `[visits]`.
    pub(super) fn bound(&mut self, effort: u32) {
        self.most = Effort::per_face(effort, self.surface.topology.faces.len());
        self.untangler.detector.bound(self.most);
    }

    /// What the last frame put off.
    #[must_use]
    pub fn deferred(&self) -> Deferred {
        Deferred {
            contours: self.untangler.resolver.deferred(),
            crossings: !self.untangler.detector.is_whole(),
            pairs: self.neighbors.is_cut() || self.within.is_spent(),
            load: self.loading.is_some(),
        }
    }

    /// Work that untangling was in the last frame, in visits for each face: what is done about one particle, edge, crossing or
    /// pair.
    #[must_use]
    pub fn work(&self) -> f32 {
        self.worked as f32 / self.surface.topology.faces.len().max(1) as f32
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{Vec3, vec3};

    use super::Deferred;
    use crate::solver::evaluate::EvaluateSettings;
    use crate::solver::island::{LoadReport, UntangleSettings};
    use crate::solver::rest::{RestShape, SourceMesh};
    use crate::solver::scene::{Scene, SceneCloth};
    use crate::solver::settings::Fabric;

    /// One cloth of `n` triangles, each about as large as the box that all of them lie in.
    fn heap(n: u32, effort: u32) -> Scene {
        let mut rng = fastrand::Rng::with_seed(1);
        let mut mesh = SourceMesh::default();
        for k in 0..n {
            let mut place = || vec3(rng.f32(), rng.f32(), rng.f32());
            let centre = place();
            mesh.positions.extend((0..3).map(|_| centre + 2.0 * place()));
            mesh.triangles.push([3 * k, 3 * k + 1, 3 * k + 2]);
        }
        let (rest, _) = RestShape::build(&mesh).expect("triangles");
        let scene = Scene::new(vec![SceneCloth::new(Arc::new(rest), Fabric::default(), Vec3::ZERO, &[])]);
        let settings = UntangleSettings { effort, ..UntangleSettings::default() };
        scene.untangled(settings, EvaluateSettings::default(), true).expect("a cloth")
    }

    /// What frames put off until nothing crosses, `most` frames at most, and the most work of one of them.
    fn frames(scene: &mut Scene, most: usize) -> (Vec<Deferred>, f32) {
        let (mut deferred, mut work) = (Vec::new(), 0.0f32);
        while deferred.len() < most && (deferred.is_empty() || scene.crossings() > 0) {
            scene.step(1.0 / 60.0);
            let island = &scene.untangle.as_ref().expect("untangling").island;
            deferred.push(island.deferred());
            work = work.max(island.work());
        }
        (deferred, work)
    }

    #[test]
    fn a_heap_of_crossing_triangles_comes_apart_in_frames_of_bounded_work() {
        for effort in [64, 256] {
            // Twice the triangles cross four times as much.
            for n in [60, 120] {
                let mut scene = heap(n, effort);
                let (deferred, work) = frames(&mut scene, 200);
                let what = format!("{n} triangles, {effort} visits: {work} in {} frames", deferred.len());
                // A look may take all of it by itself, and comes on top.
                assert!(work < 4.0 * effort as f32, "{what}");
                assert!(deferred[0].contours > 0, "{what}: nothing was put off");
                assert!(scene.crossings() == 0, "{what}: {} left", scene.crossings());
                scene.step(1.0 / 60.0);
                let left = scene.untangle.as_ref().expect("untangling").island.deferred();
                assert!(left.contours == 0 && !left.load, "{what}: {left:?}");
            }
        }
    }

    #[test]
    fn at_load_a_heap_comes_apart_over_frames_too() {
        let mut scene = heap(60, 64);
        scene.untangle.as_mut().expect("untangling").island.loading = Some(LoadReport::default());
        let (deferred, work) = frames(&mut scene, 100);
        assert!(deferred[0].load && work < 4.0 * 64.0, "{work} visits, {deferred:?}");
        assert!(deferred.len() > 1 && scene.crossings() == 0, "{} left after {deferred:?}", scene.crossings());
    }

    #[test]
    fn what_is_put_off_is_the_same_each_time() {
        let run = || {
            let mut scene = heap(80, 64);
            let (deferred, _) = frames(&mut scene, 10);
            (deferred, scene.cloths.remove(0).sim.state)
        };
        assert!(run() == run(), "other bits");
    }
}
