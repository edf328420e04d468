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

/// Keeps the position of a particle, and leaves out its inverse mass.
const XYZ: Vec4 = Vec4::new(1.0, 1.0, 1.0, 0.0);
const IS_XYZ: BVec4A = BVec4A::from_array([true, true, true, false]);
