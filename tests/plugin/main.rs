//! The plugin in a headless app. One binary, because linking Bevy is what takes long.

#[path = "../common/mod.rs"]
mod common;

mod bind;
mod bodies;
mod contact;
mod debug;
mod diagnostics;
mod frame;
#[cfg(feature = "gltf")]
mod gltf;
mod lifecycle;
mod pins;
mod presets;
mod reflection;
mod sync;
mod untangle;
mod warnings;
mod wiring;
