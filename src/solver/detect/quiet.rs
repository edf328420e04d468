//! What one look says of cloth that has hardly moved since.
//!
//! ```text
//! a look at everything, within `reach`                      ─►  pairs of faces that are close
//! while no particle has gone farther than half of `reach`   ─►  only these can cross
//! ```
//!
//! No particle may go farther than a tenth of the height that the faces around it had at the look. So the normals that
//! dismissed flat cloth turn by some 0.2 radians meanwhile.

use glam::{Vec3A, Vec4};

use super::Surface;
use super::crossing::are_apart;

/// How far particles may go, as a share of the least height of the faces around them and of the mean edge (dimensionless).
const SLACK: f32 = 0.1;

/// The faces that can cross while cloth hardly moves. See the module.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct QuietPairs {
    /// Where each particle was at the last look at everything `[m]`.
    noted: Vec<Vec3A>,
    /// Square of how far each may go, while [`Self::close`] is known `[m²]`.
    slack: Vec<f32>,
    /// How close faces must be then to be able to cross `[m]`.
    pub reach: f32,
    /// Pairs of faces that were.
    close: Vec<[u32; 2]>,
    /// How often [`Self::close`] did in place of a look at everything; none while it is not known.
    used: Option<u32>,
}

impl QuietPairs {
    pub(super) fn new(surface: &Surface) -> Self {
        let most = SLACK * surface.mean_edge;
        Self {
            noted: vec![Vec3A::INFINITY; surface.len()],
            slack: vec![most * most; surface.len()],
            reach: 2.0 * most,
            // Grows where cloth folds: what hangs has none.
            close: Vec::with_capacity(surface.len()),
            used: None,
        }
    }

    /// The pairs of faces that can cross at `positions` `[m]`, if that is known.
    pub(super) fn close(&mut self, positions: &[Vec4]) -> Option<&[[u32; 2]]> {
        let used = self.used?;
        if !self.is_near(positions) {
            return None;
        }
        self.used = Some(used + 1);
        Some(&self.close)
    }

    /// Begins a look at everything, at `positions` `[m]`. Whether it is worth [taking in](Self::take_in) what is close: where
    /// cloth has hardly moved since the last look, or did so for some time.
    pub(super) fn begin(&mut self, surface: &Surface, positions: &[Vec4]) -> bool {
        let pays = match self.used {
            Some(used) => used > 1,
            None => self.is_near(positions),
        };
        if pays {
            surface.least_heights_squared(|v| Vec3A::from_vec4(positions[v as usize]), &mut self.slack);
            let most = 0.25 * self.reach * self.reach;
            self.slack.iter_mut().for_each(|slack| *slack = (SLACK * SLACK * *slack).min(most));
        }
        self.noted.iter_mut().zip(positions).for_each(|(noted, &x)| *noted = Vec3A::from_vec4(x));
        self.close.clear();
        self.used = None;
        pays
    }

    /// Takes in two faces whose boxes come within [`Self::reach`].
    pub(super) fn take_in(&mut self, surface: &Surface, positions: &[Vec4], [f, g]: [u32; 2]) {
        let [tf, tg] = [f, g].map(|face| surface.topology.faces[face as usize]);
        let shared = tf.iter().filter(|v| tg.contains(v)).count();
        if shared == 1 || (shared == 0 && !are_apart(positions, tf, tg, None, self.reach)) {
            self.close.push([f, g]);
        }
    }

    /// Ends a look that took in all that is close, and found no crossing.
    pub(super) fn end(&mut self) {
        self.used = Some(0);
    }

    /// Forgets what was close, of a surface whose edges have another length.
    pub(super) fn rescale(&mut self, surface: &Surface) {
        self.reach = 2.0 * SLACK * surface.mean_edge;
        self.noted.fill(Vec3A::INFINITY);
        self.forget();
    }

    /// Forgets what was close.
    pub(super) fn forget(&mut self) {
        self.used = None;
    }

    fn is_near(&self, positions: &[Vec4]) -> bool {
        let places = self.noted.iter().zip(&self.slack);
        // What is not known is infinitely far.
        positions.iter().zip(places).all(|(&x, (noted, slack))| Vec3A::from_vec4(x).distance_squared(*noted) <= *slack)
    }
}

#[cfg(test)]
mod tests {
    use glam::vec3;

    use super::super::{Detector, PartRef};
    use super::*;
    use crate::solver::rest::{RestShape, SourceMesh};

    const N: u32 = 12;

    /// A sheet in the plane y = 0 that collides with itself.
    fn sheet() -> Surface {
        let at = |i: u32| vec3((i / N) as f32, 0.0, (i % N) as f32) / (N - 1) as f32;
        let positions = (0..N * N).map(at).collect();
        let cells = (0..N * (N - 1)).filter(|i| i % N < N - 1);
        let triangles = cells.flat_map(|i| [[i, i + 1, i + N], [i + 1, i + N + 1, i + N]]).collect();
        let (rest, _) = RestShape::build(&SourceMesh { positions, triangles, ..SourceMesh::default() }).expect("a sheet");
        let (topology, rest) = (&rest.topology, &rest.positions);
        Surface::new(&[PartRef { topology, rest, garment_layer: 0, self_collision: true, thickness: 0.005 }])
            .expect("one cloth")
    }

    #[test]
    fn at_rest_only_what_is_close_is_asked_and_in_motion_everything() {
        let surface = sheet();
        let mut detector = Detector::new(&surface);
        let mut look = |by: f32| {
            let positions: Vec<Vec4> = surface.rest.iter().map(|x| (*x + by).extend(1.0)).collect();
            assert!(detector.detect_again(&surface, &positions).is_empty());
            detector.quiet.used
        };
        let edge = surface.mean_edge;
        let used: Vec<_> = [0.0, 0.0, 0.01, 0.01, 0.02, 0.5, 0.51, 0.52].into_iter().map(|by| look(by * edge)).collect();
        assert_eq!(used, [None, Some(0), Some(1), Some(2), Some(3), Some(0), Some(1), Some(2)]);
        let used: Vec<_> = (1u8..5).map(|i| look(f32::from(i) * edge)).collect();
        assert_eq!(used, [Some(0), None, None, None], "fast");
    }

    /// Faces that are squeezed turn over before they have gone far; some come to cross others with which they share a particle.
    #[test]
    fn what_comes_to_cross_within_the_slack_is_seen_in_squeezed_cloth_too() {
        let surface = sheet();
        let mut rng = fastrand::Rng::with_seed(11);
        let mut jitter = || 2.0 * vec3(rng.f32() - 0.5, rng.f32() - 0.5, rng.f32() - 0.5);
        let (mut clean, mut crossing) = (0, 0);
        for (squeeze, flat) in [(1.0, 0.35), (0.5, 0.25), (0.3, 0.1)].into_iter().flat_map(|case| [case; 300]) {
            let shift = surface.mean_edge * vec3(flat, 0.5 * flat, flat);
            let base: Vec<Vec4> =
                surface.rest.iter().map(|x| (vec3(squeeze * x.x, x.y, x.z) + shift * jitter()).extend(1.0)).collect();
            let mut detector = Detector::new(&surface);
            if !(0..2).all(|_| detector.detect_again(&surface, &base).is_empty()) {
                continue;
            }
            clean += 1;
            let slack = detector.quiet.slack.clone();
            for _ in 0..20 {
                let moved =
                    base.iter().zip(&slack).map(|(x, slack)| *x + (0.99 * slack.sqrt() * jitter().normalize()).extend(0.0));
                let moved: Vec<Vec4> = moved.collect();
                assert!(detector.quiet.is_near(&moved));
                let expected = Detector::new(&surface).detect(&surface, &moved).to_vec();
                assert_eq!(detector.detect_again(&surface, &moved), expected, "squeezed to {squeeze}");
                crossing += u32::from(!expected.is_empty());
                if !expected.is_empty() {
                    break;
                }
            }
        }
        assert!(clean > 100 && crossing > 20, "{crossing} of {clean}");
    }
}
