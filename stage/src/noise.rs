//! Noise that repeats with the unit square, the same on every machine.

use bevy::math::Vec2;

/// A number in 0..1 that depends on the three in no visible way.
pub fn at(x: u32, y: u32, seed: u32) -> f32 {
    let mut bits = x.wrapping_mul(0x9E37_79B1) ^ y.wrapping_mul(0x85EB_CA77) ^ seed.wrapping_mul(0xC2B2_AE3D);
    bits = (bits ^ bits >> 15).wrapping_mul(0x2C1B_3C6D);
    bits = (bits ^ bits >> 12).wrapping_mul(0x297A_2D39);
    (bits ^ bits >> 15) as f32 / u32::MAX as f32
}

/// Smooth noise in 0..1 with `cells` bumps along each side of the unit square.
pub fn smooth(point: Vec2, cells: Vec2, seed: u32) -> f32 {
    let scaled = point * cells;
    let corner = scaled.floor();
    let inside = scaled - corner;
    let weight = inside * inside * (3.0 - 2.0 * inside);
    let value = |dx: f32, dy: f32| {
        let x = (corner.x + dx).rem_euclid(cells.x) as u32;
        let y = (corner.y + dy).rem_euclid(cells.y) as u32;
        at(x, y, seed)
    };
    let top = value(0.0, 0.0) + (value(1.0, 0.0) - value(0.0, 0.0)) * weight.x;
    let bottom = value(0.0, 1.0) + (value(1.0, 1.0) - value(0.0, 1.0)) * weight.x;
    top + (bottom - top) * weight.y
}

/// Smooth noise of several sizes, in 0..1.
pub fn cloud(point: Vec2, cells: u32, octaves: u32) -> f32 {
    let weight = |octave: u32| 0.5f32.powi(octave as i32);
    let layer = |octave: u32| {
        let cells = Vec2::splat((cells << octave) as f32);
        smooth(point, cells, octave) * weight(octave)
    };
    (0..octaves).map(layer).sum::<f32>() / (0..octaves).map(weight).sum::<f32>()
}
