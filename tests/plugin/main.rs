//! The plugin in a headless app. One binary, because linking Bevy is what takes long.

#[path = "../common/mod.rs"]
mod common;

#[cfg(feature = "avian")]
mod avian;
mod bind;
mod bodies;
mod contact;
mod frame;
#[cfg(feature = "gltf")]
mod gltf;
mod lifecycle;
mod pins;
mod sync;
mod untangle;
mod warnings;
mod wiring;
