//! The cloth solver, free of the engine.
//!
//! Nothing below this module knows of entities, worlds, handles or clocks: it takes slices of numbers in
//! SI units and gives numbers back. Tests, benchmarks and other engines call it directly.
//! Modules stand in the order of the data flow. What is public serves one of these:
//!
//! | to do this | use |
//! |---|---|
//! | step a scene of cloths, bodies and wind | `scene`, with the feature `lab` |
//! | make a shape at rest of triangles | [`rest`], [`topology`] |
//! | step one cloth, or those of an island | [`step`], [`island`], with [`sim`], [`state`], [`anchors`], [`skinned`], [`body`], [`couple`], [`wind`], [`settings`] |
//! | find crossings and take them apart | [`detect`], [`resolve`], [`verdict`] |
//! | decide what to show, and take back what blew up | [`evaluate`], [`display`], [`recover`] |
//! | lend threads to an island | [`jobs`] |
//! | step a recorded frame again | `recording` (feature `record`) |

pub mod settings;
mod buffer;
pub(crate) mod scales;
pub(crate) mod ramp;
pub mod topology;
pub mod rest;
pub mod state;
pub mod anchors;
pub mod skinned;
pub mod body;
pub mod couple;
pub mod wind;
pub(crate) mod integrate;
pub mod step;
pub mod detect;
pub(crate) mod effort;
pub mod jobs;
pub mod verdict;
pub mod resolve;
pub mod evaluate;
pub mod display;
pub(crate) mod respond;
pub(crate) mod rigid;
pub(crate) mod rollback;
pub mod sim;
pub mod island;
#[cfg(feature = "record")]
pub mod recording;
#[cfg(feature = "lab")]
pub mod scene;
pub(crate) mod fit;
pub mod recover;
pub(crate) mod surface;
pub(crate) mod embed;
pub(crate) mod raycast;
pub(crate) mod impulse;
