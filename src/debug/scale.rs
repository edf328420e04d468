//! Colours by quantity.

use bevy::prelude::*;

use crate::solver::resolve::ContourKind;

/// From blue (-1) over white (0) to red (1).
pub(super) fn diverging(x: f32) -> Color {
    let x = x.clamp(-1.0, 1.0);
    let fade = |end: f32| 1.0 - (1.0 - end) * x.abs();
    if x < 0.0 { Color::srgb(fade(0.10), fade(0.35), fade(1.0)) } else { Color::srgb(fade(1.0), fade(0.10), fade(0.05)) }
}

/// From blue (0) over green and yellow to red (1).
pub(super) fn sequential(x: f32) -> Color {
    Color::hsl(230.0 * (1.0 - x.clamp(0.0, 1.0)), 1.0, 0.5)
}

/// A colour for each of a few numbers, far from those of its neighbours.
pub(super) fn number(n: u32) -> Color {
    Color::hsl((n as f32 * 137.5) % 360.0, 0.9, 0.5)
}

/// A colour for each way in which a contour ends (Okabe and Ito 2008: told apart by eyes of any kind).
#[must_use]
pub fn contour(kind: ContourKind) -> Color {
    match kind {
        ContourKind::Closed => Color::srgb_u8(213, 94, 0),
        ContourKind::Eight => Color::srgb_u8(230, 159, 0),
        ContourKind::Ll => Color::srgb_u8(240, 228, 66),
        ContourKind::Bbii => Color::srgb_u8(0, 158, 115),
        ContourKind::Bibi => Color::srgb_u8(86, 180, 233),
        ContourKind::Bli => Color::srgb_u8(0, 114, 178),
        ContourKind::Cross => Color::srgb_u8(204, 121, 167),
        ContourKind::Unknown => Color::srgb_u8(90, 90, 90),
    }
}

/// A force as a share of its colours, by its logarithm: 0 at 0.1 mN, 1 at 1 N.
pub(super) fn force(newtons: f32) -> f32 {
    (newtons.max(1.0e-9).log10() * 0.25 + 1.0).clamp(0.0, 1.0)
}

/// A speed as a share of its colours: 0 in still air, 1 at 20 m/s.
pub(super) fn speed(metres_per_second: f32) -> f32 {
    metres_per_second / 20.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_end_where_the_legend_says() {
        assert_eq!(diverging(0.0), Color::srgb(1.0, 1.0, 1.0));
        assert_eq!((force(1.0e-4), force(1.0)), (0.0, 1.0));
        assert!((force(0.01) - 0.5).abs() < 1.0e-6);
        assert_eq!((force(0.0), force(f32::INFINITY)), (0.0, 1.0));
        assert_eq!((speed(0.0), speed(20.0)), (0.0, 1.0));
    }
}
