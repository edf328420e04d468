//! Limits of tangles: a tangle is drawn to its skin, until nothing crosses or what crosses is the skin itself.
//!
//! ```text
//!   tangled   r ← max(0, min(r, d) - v Δt)     d: maximum distance, v: 2 m/s
//!   else      r ← r + d Δt / 0.25 s              until it is d again
//! ```
//!
//! Cloth that may go no farther than a few centimetres from its skin cannot be taken apart like other cloth: there is no room.
//! Its skin is where it was authored, and that is whole. Where it is not, nothing can be done: such crossings are *authored*.

use super::Skinned;
use super::avoid::FASTEST;
use crate::solver::scales::RESPONSE_TIME;

/// How far from their targets particles may be for now.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct TangledLimits {
    /// By particle `[m]`; infinite: as far as its maximum distance lets it. Empty while there is no tangle.
    most: Vec<f32>,
}

impl TangledLimits {
    /// Farthest distance of particle `i` from its target `[m]`; infinite where there is no limit.
    #[inline]
    #[must_use]
    pub fn distance(&self, skinned: &Skinned, i: usize) -> f32 {
        let most = skinned.distance(i);
        self.most.get(i).map_or(most, |limit| limit.min(most))
    }

    /// Takes tangled particles nearer to their skin in a frame of `dt` `[s]`, and lets others go. `tangled`: how much each
    /// belongs to a tangle, 0 to 1; empty when nothing is.
    pub fn advance(&mut self, skinned: &Skinned, tangled: &[f32], dt: f32) {
        let count = skinned.to.len();
        if tangled.len() == count && self.most.is_empty() && tangled.iter().any(|weight| *weight > 0.0) {
            self.most.resize(count, f32::INFINITY);
        }
        let mut any = false;
        for (i, limit) in self.most.iter_mut().enumerate() {
            let most = skinned.distance(i);
            let weight = tangled.get(i).copied().unwrap_or(0.0);
            if weight > 0.0 && most < f32::INFINITY {
                *limit = (limit.min(most) - FASTEST * dt).max(0.0);
            } else {
                *limit += most * dt / RESPONSE_TIME;
            }
            if *limit >= most {
                *limit = f32::INFINITY;
            }
            any |= *limit < f32::INFINITY;
        }
        if !any {
            self.most.clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn a_tangle_is_at_its_skin_in_time_and_gets_its_limits_back() {
        let skinned =
            Skinned { to: vec![Vec3::ZERO; 3], max_distance: vec![0.04, 0.04, f32::INFINITY], ..Skinned::of_radius(1.0) };
        let distances = |tangled_limits: &TangledLimits| [0, 1, 2].map(|i| tangled_limits.distance(&skinned, i));
        for rate in [30.0f32, 60.0, 144.0] {
            let mut tangled_limits = TangledLimits::default();
            (0..(0.02 * rate).ceil() as u32).for_each(|_| tangled_limits.advance(&skinned, &[1.0, 0.0, 1.0], 1.0 / rate));
            assert_eq!(distances(&tangled_limits), [0.0, 0.04, f32::INFINITY], "{rate}");
            let frames = (0.125 * rate) as u32;
            (0..frames).for_each(|_| tangled_limits.advance(&skinned, &[], 1.0 / rate));
            let ([half, ..], expected) = (distances(&tangled_limits), 0.04 * frames as f32 / rate / RESPONSE_TIME);
            assert!((half - expected).abs() < 1.0e-6, "{half} at {rate}");
            (0..(0.2 * rate) as u32).for_each(|_| tangled_limits.advance(&skinned, &[], 1.0 / rate));
            assert_eq!(tangled_limits, TangledLimits::default(), "{rate}");
        }
    }
}
