//! Untangling, without an engine: what crosses is found, and comes apart.

mod detection;
mod methods;
