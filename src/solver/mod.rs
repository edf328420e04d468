//! The cloth solver, free of the engine.
//!
//! Nothing below this module knows of entities, worlds, handles or clocks: it takes slices of numbers in
//! SI units and gives numbers back, so that tests, benchmarks and other engines can call it directly.
//! Modules stand in the order of the data flow.

pub mod body;
pub mod detect;
pub mod evaluate;
pub mod group;
pub mod integrate;
pub mod recover;
pub mod resolve;
pub mod rest;
pub mod settings;
pub mod state;
pub mod step;
pub mod surface;
pub mod wind;
