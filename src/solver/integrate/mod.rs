//! Substeps: prediction under forces, then constraints, one pass each (small-step XPBD, Macklin et al. 2019).

pub mod damp;
pub mod predict;
pub mod pull;
pub mod air;
pub mod anchor;
pub mod bend;
pub mod tether;
pub mod coarse;
pub mod follow_the_leader;
pub mod spring;
pub mod membrane;
mod rows;
