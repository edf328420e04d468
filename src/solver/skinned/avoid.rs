//! Takes targets out of bodies: skins pass through them, and a limit around a place inside would hold cloth there.

use glam::{Vec3, Vec4};

use super::Skinned;
use crate::solver::body::{Body, take_out};

/// Fastest that the way out of a body changes `[m/s]`: which side is out may change at once.
const FASTEST: f32 = 2.0;

impl Skinned {
    /// Takes the targets at the end of a frame of `dt` `[s]` out of bodies, to the distance `keep` `[m]`. `planes` is a buffer.
    pub fn avoid(&mut self, bodies: &[Body], keep: f32, dt: f32, planes: &mut Vec<Vec4>) {
        let Self { to, way_out, .. } = self;
        way_out.resize(to.len(), Vec3::ZERO);
        if bodies.is_empty() && way_out.iter().all(|way| *way == Vec3::ZERO) {
            return;
        }
        self.skin.clone_from(to);
        take_out(bodies, keep, to, planes);
        for ((to, skin), way) in to.iter_mut().zip(&self.skin).zip(way_out) {
            *way += (*to - *skin - *way).clamp_length_max(FASTEST * dt);
            *to = *skin + *way;
        }
    }
}
