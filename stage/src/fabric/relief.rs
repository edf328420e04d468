//! A surface that repeats: its height and colour at every texel.

use bevy::prelude::*;

/// One repeat of a surface, `TEXELS` along each side.
pub struct Relief {
    /// Height [texel].
    pub heights: Vec<f32>,
    /// Colour (linear).
    pub colors: Vec<Vec3>,
}

impl Relief {
    /// Texels along a side.
    pub const TEXELS: usize = 512;

    /// Asks for height and colour at every texel; coordinates run from 0 to 1.
    pub fn from_fn(texel: impl Fn(Vec2) -> (f32, Vec3)) -> Self {
        let center = |index: usize| Vec2::new((index % Self::TEXELS) as f32, (index / Self::TEXELS) as f32) + 0.5;
        let (heights, colors) =
            (0..Self::TEXELS * Self::TEXELS).map(|index| texel(center(index) / Self::TEXELS as f32)).unzip();
        Self { heights, colors }
    }

    /// The normals in tangent space, whose second axis points up the texture.
    pub fn normals(&self) -> Vec<Vec3> {
        let height = |x: usize, y: usize| self.heights[y % Self::TEXELS * Self::TEXELS + x % Self::TEXELS];
        let normal = |index: usize| {
            let (x, y) = (index % Self::TEXELS + Self::TEXELS, index / Self::TEXELS + Self::TEXELS);
            let right = (height(x + 1, y) - height(x - 1, y)) / 2.0;
            let down = (height(x, y + 1) - height(x, y - 1)) / 2.0;
            Vec3::new(-right, down, 1.0).normalize()
        };
        (0..self.heights.len()).map(normal).collect()
    }
}
