//! Cloth on bodies, put where they will put it while pairs of cloth are looked at.
//!
//! ```text
//!   constrain   x      springs and gravity draw what lies on a body into it
//!   lay         x + u  out again, along the plane of its last touch            ◄ what lies on it meets it here, and does not follow it in
//!   take back   x      with what was done to it meanwhile
//!   project            the body bears it, as if nothing had been
//! ```

use glam::{Vec3A, Vec4};

use super::respond::Plane;

/// Where particles were before they were laid, and where to [m].
#[derive(Clone, Debug, Default)]
pub struct Laid {
    moved: Vec<(u32, Vec4, Vec4)>,
}

impl Laid {
    /// Begins a frame in which at most so many touch.
    pub fn begin(&mut self, most: usize) {
        self.moved.clear();
        self.moved.reserve(most);
    }

    /// Moves a particle `by` [m].
    pub(super) fn put(&mut self, particle: u32, by: Vec3A, positions: &mut [Vec4]) {
        if let Some(x) = positions.get_mut(particle as usize) {
            let from = *x;
            *x += by.extend(0.0);
            self.moved.push((particle, from, *x));
        }
    }

    /// Takes all of it back; what nothing else moved has the same bits as before.
    pub fn take_back(&mut self, positions: &mut [Vec4]) {
        for (particle, from, to) in self.moved.drain(..).rev() {
            if let Some(x) = positions.get_mut(particle as usize) {
                *x = if *x == to { from } else { *x - (to - from) };
            }
        }
    }
}

/// How far below a plane `q` is [m], if it is, and less than `deepest` [m]: what is deeper is not where it was when it last touched.
pub(super) fn below(plane: Plane, q: Vec3A, deepest: f32) -> Option<f32> {
    let gap = plane.gap(q);
    (gap < 0.0 && gap > -deepest).then_some(-gap)
}
