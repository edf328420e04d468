//! Displacements of one iteration: summed, then capped, then applied to positions and previous positions together.

use glam::{Vec3, Vec4};

#[derive(Debug, Default)]
pub(super) struct Displacements {
    /// Displacement and cap `[m]` per particle.
    pub of: Vec<Vec4>,
    pub touched: Vec<u32>,
}

impl Displacements {
    pub(super) fn add(&mut self, particle: u32, by: Vec3, cap: f32) {
        let displacement = &mut self.of[particle as usize];
        if *displacement == Vec4::ZERO {
            self.touched.push(particle);
        }
        *displacement = (displacement.truncate() + by).extend(displacement.w.max(cap));
    }

    /// Moves both arrays by the capped displacements and forgets them.
    pub(super) fn apply(&mut self, positions: &mut [Vec4], previous: &mut [Vec4]) {
        for &v in &self.touched {
            let v = v as usize;
            let displacement = core::mem::take(&mut self.of[v]);
            if positions[v].w == 0.0 {
                continue;
            }
            let by = displacement.truncate().clamp_length_max(displacement.w).extend(0.0);
            if by.is_finite() {
                positions[v] += by;
                previous[v] += by;
            }
        }
        self.touched.clear();
    }

    /// Takes the displacements off the previous positions only: they become changes of velocity per substep.
    pub(super) fn apply_to_velocity(&mut self, positions: &[Vec4], previous: &mut [Vec4]) {
        for &v in &self.touched {
            let by = core::mem::take(&mut self.of[v as usize]).truncate();
            if positions[v as usize].w > 0.0 && by.is_finite() {
                previous[v as usize] -= by.extend(0.0);
            }
        }
        self.touched.clear();
    }
}
