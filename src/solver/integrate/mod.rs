//! Substeps: prediction under forces, then constraints, one pass each (small-step XPBD, Macklin et al. 2019).

pub(crate) mod damp;
pub(crate) mod predict;
pub(crate) mod pull;
pub(crate) mod air;
pub(crate) mod anchor;
pub(crate) mod bend;
pub(crate) mod tether;
pub(crate) mod coarse;
pub(crate) mod follow_the_leader;
pub(crate) mod spring;
pub(crate) mod membrane;
mod rows;

use glam::{BVec4A, Vec4};

/// Factor that leaves out the inverse mass of a particle: cheaper than a mask, with the same bits.
const XYZ: Vec4 = Vec4::new(1.0, 1.0, 1.0, 0.0);
/// Mask that keeps the position of a particle.
const IS_XYZ: BVec4A = BVec4A::from_array([true, true, true, false]);
