//! The file that a run without a window writes, checked before anything is simulated.

use image::{ImageFormat, RgbImage};
use std::{fs, io, path::Path, path::PathBuf};

/// Kinds of pictures the stage can write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureKind {
    /// The last frame.
    Png,
    /// Every few frames, as an animation.
    Gif,
}

/// A picture that can be written.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Where to.
    pub path: PathBuf,
    /// What the extension says it is.
    pub kind: PictureKind,
}

impl Picture {
    /// Looks at the extension and tries to open the file for writing.
    pub fn at(path: &Path) -> Result<Self, String> {
        let extension = path.extension().and_then(|name| name.to_str());
        let kind = match extension.map(str::to_ascii_lowercase).as_deref() {
            Some("png") => PictureKind::Png,
            Some("gif") => PictureKind::Gif,
            _ => return Err(format!("{}: expected a name that ends in .png or .gif", path.display())),
        };
        probe(path).map_err(|error| cannot_write(path, &error))?;
        Ok(Self { path: path.to_owned(), kind })
    }

    /// Writes the frames that were shot, the last one for a PNG.
    pub fn write(&self, shots: &[RgbImage], every: u32) -> Result<(), String> {
        let bytes = match self.kind {
            PictureKind::Png => png(shots),
            PictureKind::Gif => super::gif::encode(shots, every),
        };
        let bytes = bytes.map_err(|error| format!("{}: {error}", self.path.display()))?;
        fs::write(&self.path, bytes).map_err(|error| cannot_write(&self.path, &error))
    }
}

/// The last of the frames as a PNG file.
fn png(shots: &[RgbImage]) -> Result<Vec<u8>, String> {
    let last = shots.last().ok_or("no frame was drawn")?;
    let mut bytes = io::Cursor::new(Vec::new());
    last.write_to(&mut bytes, ImageFormat::Png).map_err(|error| error.to_string())?;
    Ok(bytes.into_inner())
}

/// Opens the file as a later write would, and leaves no trace of having done so.
fn probe(path: &Path) -> io::Result<()> {
    let existed = path.exists();
    fs::OpenOptions::new().append(true).create(true).open(path)?;
    if existed { Ok(()) } else { fs::remove_file(path) }
}

/// The one line for a file that cannot be written.
fn cannot_write(path: &Path, error: &io::Error) -> String {
    format!("{}: cannot be written: {error}", path.display())
}
