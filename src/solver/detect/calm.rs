//! What one look says of cloth that has hardly moved since.
//!
//! ```text
//! a look at everything, within `reach`                      ─►  pairs of faces that are close
//! while no particle has gone farther than half of `reach`   ─►  only these can cross
//! ```
//!
//! The normals by which flat cloth was dismissed turn by some 0.2 radians meanwhile, of the 45° and more that are left before it folds.

use glam::{Vec3A, Vec4};

use super::Surface;
use super::crossing::are_apart;

/// How far particles may go, as a share of the least height of the faces around them and of the mean edge (dimensionless).
const SLACK: f32 = 0.1;

/// The faces that can cross while cloth hardly moves. See the module.
#[derive(Clone, Debug, Default)]
pub struct Calm {
    /// Where each particle was at the last look at everything [m].
    noted: Vec<Vec3A>,
    /// Square of how far each may go [m²].
    slack: Vec<f32>,
    /// How close faces must be then to be able to cross [m].
    pub reach: f32,
    /// Pairs of faces that were.
    close: Vec<[u32; 2]>,
    /// How often [`Self::close`] did in place of a look at everything; none while it is not known.
    used: Option<u32>,
}

impl Calm {
    pub fn new(surface: &Surface) -> Self {
        let slack = |height: f32| SLACK * height.min(surface.mean_edge);
        Self {
            noted: vec![Vec3A::NAN; surface.len()],
            slack: surface.least_heights().into_iter().map(|height| slack(height).powi(2)).collect(),
            reach: 2.0 * slack(f32::INFINITY),
            ..Self::default()
        }
    }

    /// The pairs of faces that can cross at `positions` [m], if that is known.
    pub fn close(&mut self, positions: &[Vec4]) -> Option<&[[u32; 2]]> {
        if !self.is_near(positions) {
            return None;
        }
        self.used = Some(self.used? + 1);
        Some(&self.close)
    }

    /// Begins a look at everything, at `positions` [m]. Whether it is worth [taking in](Self::take_in) what is close: where cloth has hardly moved since the last look,
    /// or did so for some time.
    pub fn begin(&mut self, positions: &[Vec4]) -> bool {
        let pays = match self.used {
            Some(used) => used > 1,
            None => self.is_near(positions),
        };
        self.noted.iter_mut().zip(positions).for_each(|(noted, &x)| *noted = Vec3A::from_vec4(x));
        self.close.clear();
        self.used = None;
        pays
    }

    /// Takes in two faces whose boxes come within [`Self::reach`].
    pub fn take_in(&mut self, surface: &Surface, positions: &[Vec4], [f, g]: [u32; 2]) {
        let [tf, tg] = [f, g].map(|face| surface.topology.faces[face as usize]);
        let shared = tf.iter().filter(|v| tg.contains(v)).count();
        if shared == 1 || (shared == 0 && !are_apart(positions, tf, tg, None, self.reach)) {
            self.close.push([f, g]);
        }
    }

    /// Ends a look that took in all that is close, and found no crossing.
    pub fn end(&mut self) {
        self.used = Some(0);
    }

    fn is_near(&self, positions: &[Vec4]) -> bool {
        let places = self.noted.iter().zip(&self.slack);
        // NaN is not near.
        positions.iter().zip(places).all(|(&x, (noted, slack))| Vec3A::from_vec4(x).distance_squared(*noted) <= *slack)
    }
}
