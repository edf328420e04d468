//! Yarns that go over and under each other.
//!
//! ```text
//!    warp (runs along v)             a yarn from the side: over, over, under
//!   | | | |                             ____________
//!  -|---|---  weft (runs along u)      /            \
//!   | | | |                                          \______
//! ```

use super::relief::Relief;
use crate::noise;
use bevy::{math::ops, prelude::*};
use std::f32::consts::{PI, TAU};

/// How a weave is made.
pub struct Weave {
    /// Which yarn is on top.
    pub pattern: Pattern,
    /// Which yarn has which colour.
    pub yarns: Yarns,
    /// How much of the height is the way over and under, rather than the yarn's roundness.
    pub lift: f32,
    /// Height over the width of a yarn.
    pub depth: f32,
    /// How much yarns differ in tone, from each other and along themselves.
    pub uneven: f32,
    /// How much single fibres stand out.
    pub fuzz: f32,
}

/// The rule by which warp yarns pass over weft yarns.
#[derive(Clone, Copy)]
pub enum Pattern {
    /// Over one, under one.
    Plain,
    /// Over two, under two, a step further in each row.
    Twill,
    /// Over three, under one.
    Denim,
    /// Over seven, under one, scattered.
    Satin,
}

/// Which yarn has which colour (linear).
#[derive(Clone, Copy)]
pub enum Yarns {
    /// All the same.
    Plain(Vec3),
    /// Dyed warp, paler weft.
    Denim(Vec3),
    /// Bands of two colours, dyed through.
    Stripes([Vec3; 2]),
    /// Bands of two colours both ways; where they cross, the colours mix.
    Gingham([Vec3; 2]),
}

/// Yarns along one repeat.
const YARNS: usize = 32;
/// Strands that a yarn is twisted from.
const STRANDS: f32 = 3.0;

impl Pattern {
    /// Whether the warp yarn is on top of the weft yarn.
    fn warp_on_top(self, warp: usize, weft: usize) -> bool {
        match self {
            Self::Plain => (warp + weft).is_multiple_of(2),
            Self::Twill => (warp + weft) % 4 < 2,
            Self::Denim => !(warp + weft).is_multiple_of(4),
            Self::Satin => !(3 * warp + weft).is_multiple_of(8),
        }
    }
}

impl Yarns {
    /// The colour where a warp and a weft yarn cross, of the one on top.
    fn color(self, warp: usize, weft: usize, warp_on_top: bool) -> Vec3 {
        let band = |yarn: usize| yarn / (YARNS / 2) % 2;
        match self {
            Self::Plain(color) => color,
            Self::Denim(color) if warp_on_top => color,
            Self::Denim(color) => color.lerp(Vec3::splat(0.7), 0.35),
            Self::Stripes(colors) => colors[band(warp)],
            Self::Gingham(colors) => colors[band(if warp_on_top { warp } else { weft })],
        }
    }
}

impl Weave {
    /// One repeat of the weave.
    pub fn relief(&self) -> Relief {
        let texels_per_yarn = Relief::TEXELS as f32 / YARNS as f32;
        Relief::from_fn(|point| {
            let (height, color) = self.at(point);
            (height * self.depth * texels_per_yarn, color)
        })
    }

    /// Height [width of a yarn] and colour at a point of the unit square.
    fn at(&self, point: Vec2) -> (f32, Vec3) {
        let (u, v) = (point.x * YARNS as f32, point.y * YARNS as f32);
        let (warp, weft) = (u as usize % YARNS, v as usize % YARNS);
        let over = |warp: usize, weft: usize| if self.pattern.warp_on_top(warp, weft) { 1.0 } else { -1.0 };
        let way_of_warp = between(v, |weft| over(warp, weft));
        let way_of_weft = between(u, |warp| -over(warp, weft));
        let height_of_warp = self.height(u.fract(), way_of_warp);
        let height_of_weft = self.height(v.fract(), way_of_weft);
        if height_of_warp >= height_of_weft {
            let color = self.yarns.color(warp, weft, true);
            self.finish(height_of_warp, color, warp, u.fract(), point.yx())
        } else {
            let color = self.yarns.color(warp, weft, false);
            self.finish(height_of_weft, color, weft + YARNS, v.fract(), point)
        }
    }

    /// Height of a yarn at `across` (0..1) where its way is at -1 (under) to 1 (over).
    fn height(&self, across: f32, way: f32) -> f32 {
        let edge = 1.9 * across - 0.95;
        let round = ops::sqrt(1.0 - edge * edge);
        self.lift * way + (1.0 - self.lift) * round
    }

    /// Adds what makes a yarn a yarn: strands, fibres, uneven dye, and shade in the gaps.
    fn finish(&self, height: f32, color: Vec3, yarn: usize, across: f32, along: Vec2) -> (f32, Vec3) {
        let seed = yarn as u32;
        let twist = ops::sin(TAU * (across * STRANDS + along.x * YARNS as f32 * 0.5));
        let fibres = Vec2::new(4.0 * YARNS as f32, 8.0 * YARNS as f32);
        let fibre = noise::smooth(along, fibres, 3) - 0.5;
        let slub = noise::smooth(Vec2::new(along.x, 0.5), Vec2::new(7.0, 1.0), 100 + seed) - 0.5;
        let dye = noise::at(seed, 1, 11) - 0.5;
        let tone = self.uneven * (slub + 0.8 * dye) + self.fuzz * fibre + 0.04 * twist;
        let shade = 0.5 + 0.5 * smoothstep(-0.35, 0.75, height);
        let height = height + 0.05 * twist + 0.8 * self.fuzz * fibre;
        (height, (color * (1.0 + tone) * shade).clamp(Vec3::ZERO, Vec3::ONE))
    }
}

/// A value given at the middle of each yarn, with round transitions between.
fn between(position: f32, value: impl Fn(usize) -> f32) -> f32 {
    let shifted = position + YARNS as f32 - 0.5;
    let (first, way) = (shifted as usize, shifted.fract());
    let weight = 0.5 - 0.5 * ops::cos(PI * way);
    let (from, to) = (value(first % YARNS), value((first + 1) % YARNS));
    from + (to - from) * weight
}

/// From 0 below `low` to 1 above `high`.
fn smoothstep(low: f32, high: f32, value: f32) -> f32 {
    let t = ((value - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
