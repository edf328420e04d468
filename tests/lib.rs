//! What the tests of bevy_drape share, and the program `torture` that goes on with them: a headless app, and the random attack.
#![allow(missing_docs, reason = "names say it, and nobody else uses it")]

pub mod attack;
pub mod common;

use std::path::{Path, PathBuf};

/// The folder of the project.
#[must_use]
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().map_or_else(PathBuf::new, Path::to_owned)
}

/// A file or folder of data that the repository does not hold; none, and a line that says so, where it is not beside it.
#[expect(clippy::print_stderr, reason = "says why a test was skipped")]
#[must_use]
pub fn data(name: &str) -> Option<PathBuf> {
    let path = root().join("../shared/data").join(name);
    let there = path.exists();
    if !there {
        eprintln!("skipped: {} is not here", path.display());
    }
    there.then_some(path)
}
