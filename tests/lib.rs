//! What the tests of bevy_drape share, and the program `torture` that goes on with them: a headless app, and the random attack.
#![allow(missing_docs, reason = "names say it, and nobody else uses it")]

pub mod attack;
pub mod common;

use std::path::PathBuf;

/// The folder of the project.
#[must_use]
pub fn root() -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}
