//! What the tests of bevy_drape share, and the programs that go on with them: a headless app, a checker of crossings that
//! shares nothing with the detector, and the random attack.
#![allow(missing_docs, reason = "names say it, and nobody else uses it")]

pub mod attack;
pub mod checker;
pub mod common;
pub mod shown;

use std::path::{Path, PathBuf};

/// The folder of the project.
#[must_use]
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().map(Path::to_path_buf).unwrap_or_default()
}
