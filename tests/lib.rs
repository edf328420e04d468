//! What the tests of bevy_drape share, and the program `torture` that goes on with them: a headless app, and the random attack.
#![allow(missing_docs, reason = "names say it, and nobody else uses it")]

pub mod attack;
pub mod common;

use std::path::{Path, PathBuf};

/// The folder of the project.
#[must_use]
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().map(Path::to_path_buf).unwrap_or_default()
}
