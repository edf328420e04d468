//! The plugin in a headless app. One binary, because linking Bevy is what takes long.

#[path = "../common/mod.rs"]
mod common;

mod bind;
mod lifecycle;
mod frame;
mod pins;
mod bodies;
mod sync;
mod wiring;
