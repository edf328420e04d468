//! The traditional method (1995). Every close pair of a particle and a face remembers on which side it was first seen. Found on
//! the other side, it is pushed back.
//!
//! ```text
//!   s = sign((x - c) · N)  when the pair is first seen        push by (thickness - s (x - c)·N) / 2 along s N, both ways
//! ```
//!
//! It keeps clean cloth clean, and it keeps tangled cloth tangled: a pair first seen on the wrong side stays there.

use glam::{Vec3, Vec4};

use crate::solver::detect::{Detector, Proximity, Surface};
use crate::solver::effort::Meter;

/// Sides remembered, sorted by particle and face.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct History {
    sides: Vec<([u32; 4], f32)>,
    before: Vec<([u32; 4], f32)>,
    close: Vec<Proximity>,
}

/// Displacement `[m]` asked for at one particle.
pub(crate) type Push = (u32, Vec3);

impl History {
    /// Looks for close pairs within `reach` `[m]` and remembers new ones. Returns where those on the wrong side should be
    /// pushed, until they are `thickness` `[m]` on the right one. Pairs that `meter` leaves out are forgotten.
    pub(crate) fn pushes(
        &mut self,
        surface: &Surface,
        detector: &mut Detector,
        positions: &[Vec4],
        (reach, thickness): (f32, f32),
        meter: &Meter,
        out: &mut Vec<Push>,
    ) {
        out.clear();
        detector.close_pairs(surface, positions, reach, meter, &mut self.close);
        core::mem::swap(&mut self.sides, &mut self.before);
        self.sides.clear();
        let mut known = self.before.iter().copied().peekable();
        for pair in &self.close {
            let [p, a, b, c] = pair.particles.map(|v| positions[v as usize].truncate());
            let normal = (b - a).cross(c - a).normalize_or_zero();
            let height = (p - a).dot(normal);
            while known.next_if(|k| k.0 < pair.particles).is_some() {}
            let side = match known.next_if(|k| k.0 == pair.particles) {
                Some((_, side)) => side,
                None => height.signum(),
            };
            self.sides.push((pair.particles, side));
            let depth = thickness - side * height;
            let inside = pair.weights[1..].iter().all(|&w| w < 0.0);
            if depth <= 0.0 || !inside {
                continue;
            }
            let w = pair.particles.map(|v| positions[v as usize].w);
            let sum: f32 = w.iter().zip(pair.weights).map(|(w, c)| w * c * c).sum();
            if sum > 0.0 {
                let parts = pair.particles.into_iter().zip(w).zip(pair.weights);
                out.extend(parts.map(|((v, w), c)| (v, normal * (side * depth * w * c / sum))));
            }
        }
    }
}
