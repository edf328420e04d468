//! The boxes of the faces of a leaf, one lane each, so that a box is tested against all of them at once.
//!
//! ```text
//! min.x: 0 1 2 3 4 5 6 7     bit k of what meets:  lane k's box does
//! …
//! max.z: 0 1 2 3 4 5 6 7     lanes without a face hold the empty box
//! ```

use glam::{Vec3A, Vec4};

use super::{Bounds, LEAF};
use crate::solver::detect::four::WIDE;

/// The boxes of up to [`LEAF`] faces `[m]`, by axis.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Pack {
    min: [[Vec4; LEAF / WIDE]; 3],
    max: [[Vec4; LEAF / WIDE]; 3],
}

impl Pack {
    pub(super) const EMPTY: Self =
        Self { min: [[Vec4::INFINITY; LEAF / WIDE]; 3], max: [[Vec4::NEG_INFINITY; LEAF / WIDE]; 3] };

    /// The box in a lane.
    #[inline]
    pub(super) fn get(&self, lane: usize) -> Bounds {
        let (half, k) = (lane / WIDE, lane % WIDE);
        let at = |of: &[[Vec4; LEAF / WIDE]; 3]| Vec3A::new(of[0][half][k], of[1][half][k], of[2][half][k]);
        Bounds { min: at(&self.min), max: at(&self.max) }
    }

    /// Puts a box into a lane.
    #[inline]
    pub(super) fn set(&mut self, lane: usize, bounds: &Bounds) {
        let (half, k) = (lane / WIDE, lane % WIDE);
        for axis in 0..3 {
            self.min[axis][half][k] = bounds.min[axis];
            self.max[axis][half][k] = bounds.max[axis];
        }
    }

    /// Which boxes come within `margin` `[m]` of another along every axis, as [`Bounds::meets`].
    #[inline]
    pub(super) fn meets(&self, other: &Bounds, margin: Vec3A) -> u32 {
        let (low, high) = (other.min - margin, other.max);
        let mut met = 0;
        for half in 0..LEAF / WIDE {
            let within = |axis: usize| {
                Vec4::splat(low[axis]).cmple(self.max[axis][half])
                    & (self.min[axis][half] - Vec4::splat(margin[axis])).cmple(Vec4::splat(high[axis]))
            };
            met |= (within(0) & within(1) & within(2)).bitmask() << (WIDE * half);
        }
        met
    }
}

/// The lanes whose bits are set, in ascending order.
#[inline]
pub(crate) fn lanes(mut bits: u32) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let lane = bits.trailing_zeros();
        bits &= bits.wrapping_sub(1);
        (lane < u32::BITS).then_some(lane as usize)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_meet_as_their_boxes_do() {
        let mut rng = fastrand::Rng::with_seed(1);
        // Coarse numbers, so that boxes also touch.
        let mut point = || Vec3A::from([(); 3].map(|()| rng.u32(0..12) as f32));
        let mut met = 0;
        for round in 0..200 {
            let mut bounds = || {
                let (a, b) = (point(), point());
                Bounds { min: a.min(b), max: a.max(b) }
            };
            let (other, boxes, count) = (bounds(), [(); LEAF].map(|()| bounds()), round % (LEAF + 1));
            let mut pack = Pack::EMPTY;
            boxes[..count].iter().enumerate().for_each(|(lane, b)| pack.set(lane, b));
            for margin in [0.0, 1.0].map(Vec3A::splat) {
                let expected: Vec<_> = (0..count).filter(|&k| boxes[k].meets(&other, margin)).collect();
                assert_eq!(lanes(pack.meets(&other, margin)).collect::<Vec<_>>(), expected);
                met += expected.len();
            }
            assert!((0..count).all(|k| pack.get(k).min == boxes[k].min && pack.get(k).max == boxes[k].max));
        }
        assert!(met > 200, "{met}");
    }

    #[test]
    fn the_empty_box_meets_nothing() {
        let everything = Bounds { min: Vec3A::splat(f32::MIN), max: Vec3A::splat(f32::MAX) };
        assert_eq!(Pack::EMPTY.meets(&everything, Vec3A::ONE), 0);
        let mut pack = Pack::EMPTY;
        pack.set(5, &everything);
        assert_eq!(pack.meets(&everything, Vec3A::ZERO), 1 << 5);
        assert_eq!(pack.meets(&Bounds::EMPTY, Vec3A::ONE), 0);
    }
}
