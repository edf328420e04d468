//! The plugin in a headless app. One binary, because linking Bevy is what takes long.

#[path = "../common/mod.rs"]
mod common;

#[cfg(feature = "avian")]
mod avian;
mod bind;
mod bits;
mod bodies;
mod budget;
mod character;
mod contact;
mod crowd;
mod debug;
mod decimation;
mod diagnostics;
mod frame;
#[cfg(feature = "gltf")]
mod gltf;
mod grab;
mod hello;
mod lifecycle;
mod loading;
mod lod;
mod picking;
mod mannequin;
mod pieces;
mod pins;
mod query;
mod record;
mod render_mesh;
mod rest;
mod skinned;
mod sleep;
mod snapshot;
mod subdivision;
mod presets;
mod reflection;
mod sync;
mod touch;
mod untangle;
mod warnings;
mod wiring;
