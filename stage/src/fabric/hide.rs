//! Surfaces that are not woven: grains of skin, or the faint ones of rubber.

use super::relief::Relief;
use crate::noise;
use bevy::prelude::*;

/// How a hide is grained.
pub struct Hide {
    /// Colour (linear).
    pub color: Vec3,
    /// Grains along one repeat.
    pub grains: u32,
    /// Depth of the creases between them [texel].
    pub depth: f32,
}

impl Hide {
    /// One repeat of the hide.
    pub fn relief(&self) -> Relief {
        Relief::from_fn(|point| {
            let crease = self.crease(point);
            let cloud = noise::cloud(point, 4, 4) - 0.5;
            let fine = noise::cloud(point, 64, 2) - 0.5;
            let tone = (0.82 + 0.18 * crease) * (1.0 + 0.18 * cloud);
            let height = self.depth * (crease + 0.35 * fine);
            (height, (self.color * tone).clamp(Vec3::ZERO, Vec3::ONE))
        })
    }

    /// From 0 in a crease to 1 on a grain: how much nearer the nearest grain is than the second.
    fn crease(&self, point: Vec2) -> f32 {
        let scaled = point * self.grains as f32;
        let corner = scaled.floor();
        let (mut nearest, mut second) = (f32::MAX, f32::MAX);
        for cell in 0..9u8 {
            let cell = corner + Vec2::new(f32::from(cell % 3), f32::from(cell / 3)) - 1.0;
            let wrapped = cell.rem_euclid(Vec2::splat(self.grains as f32)).as_uvec2();
            let jitter = Vec2::new(noise::at(wrapped.x, wrapped.y, 21), noise::at(wrapped.x, wrapped.y, 22));
            let distance = scaled.distance(cell + jitter);
            second = second.min(distance.max(nearest));
            nearest = nearest.min(distance);
        }
        let gap = ((second - nearest) / 0.45).min(1.0);
        gap * (2.0 - gap)
    }
}
