//! Untangling, without an engine: what crosses is found, and comes apart.

mod checker;
mod detection;
mod methods;
