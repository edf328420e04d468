//! Provisional projection: cloth on bodies is put where they will put it while pairs of cloth are looked at, and while skinned
//! cloth is tightened.
//!
//! ```text
//!   constrain   x      springs and gravity draw what lies on a body into it
//!   provisional x + u  out again, along the plane of its last touch      ◄ what lies on it meets it here, and does not
//!                                                                          follow it in; once more when that has pushed it in
//!   restore     x      with what was done to it meanwhile
//!   project            the body bears it, as if nothing had been
//! ```

use glam::{Vec3, Vec3A, Vec4};

/// Where particles were before they were laid, and where to `[m]`.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Provisional {
    moved: Vec<(u32, Vec3, Vec3)>,
}

impl Provisional {
    /// Begins a frame in which a substep moves at most `most` particles.
    pub(crate) fn begin(&mut self, most: usize) {
        self.moved.clear();
        self.moved.reserve(most);
    }

    /// Moves a particle `by` `[m]`.
    pub(super) fn put(&mut self, particle: u32, by: Vec3A, positions: &mut [Vec4]) {
        if let Some(x) = positions.get_mut(particle as usize) {
            let from = x.truncate();
            *x += by.extend(0.0);
            self.moved.push((particle, from, x.truncate()));
        }
    }

    /// Takes all of it back; what nothing else moved has the same bits as before.
    pub(crate) fn restore(&mut self, positions: &mut [Vec4]) {
        for (particle, from, to) in self.moved.drain(..).rev() {
            if let Some(x) = positions.get_mut(particle as usize) {
                let now = x.truncate();
                *x = if now == to { from } else { now - (to - from) }.extend(x.w);
            }
        }
    }
}
