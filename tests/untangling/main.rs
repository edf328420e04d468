//! Untangling, without an engine: what crosses is found, and comes apart.

mod detection;
mod meshes;
mod methods;
mod scenes;
