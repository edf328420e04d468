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
