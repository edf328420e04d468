//! Random numbers: those that people set, and those that nobody should.

use bevy::prelude::*;
use fastrand::Rng;

/// True once in `n` times.
pub fn once_in(rng: &mut Rng, n: u32) -> bool {
    rng.u32(0..n.max(1)) == 0
}

/// One of a list.
pub fn one_of<T: Clone>(rng: &mut Rng, list: &[T]) -> T {
    list[rng.usize(0..list.len())].clone()
}

/// Between `low` and `high`, each power of ten as likely.
pub fn span(rng: &mut Rng, low: f32, high: f32) -> f32 {
    (low.ln() + rng.f32() * (high / low).ln()).exp()
}

/// Between `-most` and `most`.
pub fn signed(rng: &mut Rng, most: f32) -> f32 {
    (2.0 * rng.f32() - 1.0) * most
}

/// Each coordinate between `-most` and `most`.
pub fn vector(rng: &mut Rng, most: f32) -> Vec3 {
    Vec3::new(signed(rng, most), signed(rng, most), signed(rng, most))
}

/// A turn.
pub fn turn(rng: &mut Rng) -> Quat {
    Quat::from_euler(EulerRot::XYZ, signed(rng, 3.2), signed(rng, 3.2), signed(rng, 3.2))
}

/// How large something is `[m]`: about a metre for the most part, and from 1 mm to 1 km.
pub fn size(rng: &mut Rng) -> f32 {
    if rng.bool() { span(rng, 0.3, 3.0) } else { span(rng, 1.0e-3, 1.0e3) }
}

/// A number that nobody should set, or an ordinary one.
pub fn number(rng: &mut Rng) -> f32 {
    match rng.u32(0..14) {
        0 | 1 => f32::NAN,
        2 => f32::INFINITY,
        3 => f32::NEG_INFINITY,
        4 => 0.0,
        5 => -0.0,
        6 => 1.0e-40,
        7 => f32::MAX,
        8 => f32::MIN,
        9 => -span(rng, 1.0e-6, 1.0e6),
        10 => span(rng, 1.0e-30, 1.0e30),
        _ => span(rng, 1.0e-3, 1.0e3),
    }
}

/// A vector with wild numbers in it, at least one.
pub fn wild_vector(rng: &mut Rng) -> Vec3 {
    let mut v = vector(rng, 1.0);
    v[rng.usize(0..3)] = number(rng);
    if once_in(rng, 3) {
        v[rng.usize(0..3)] = number(rng);
    }
    v
}
