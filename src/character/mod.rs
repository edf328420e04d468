//! Characters that wear cloth: what of them the cloth meets.
//!
//! Nothing in this module knows of the engine: it takes slices of numbers and gives numbers back.

mod fit;
mod group;
mod spread;
mod capsule;
mod hull;
mod shape;
mod outside;
#[cfg(test)]
mod tests;

pub use fit::{BoneCollider, FitSettings, SkinnedBody, fit, measure};
pub use outside::Outside;
pub use shape::BoneShape;
