//! What a question about a cloth is answered with: a point of it.

use bevy::prelude::*;

/// A point of a cloth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClothHit {
    /// The cloth.
    pub entity: Entity,
    /// Number of the simulated triangle, see [`ClothRest::shape`](crate::ClothRest::shape).
    pub triangle: u32,
    /// Its particles.
    pub particles: [u32; 3],
    /// Weights of its particles; they add up to one.
    pub barycentric: Vec3,
    /// The point in the world `[m]`.
    pub point: Vec3,
    /// Unit normal of the triangle; zero for one without area.
    pub normal: Vec3,
    /// Distance from the origin of the ray, or from the point that was asked for `[m]`.
    pub distance: f32,
}
