//! The command line that every windowed example understands.

use super::picture::Picture;
use bevy_drape::ClothDebug;
use clap::Parser;
use clap::builder::PossibleValuesParser;
use std::path::PathBuf;

/// Runs in a window, or, without one, for a number of frames and into a picture.
// An example with options of its own flattens these into its `clap` struct.
#[derive(Parser, Clone, Debug, Default)]
pub struct StageArgs {
    /// Simulate without a window and at a fixed time step of 1/60 s.
    #[arg(long)]
    pub headless: bool,
    /// How many frames to simulate; implies --headless [default: 240].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub frames: Option<u32>,
    /// Write the last frame (.png), or an animation of at most 61 frames and 2 MB (.gif); implies --headless.
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Width of what --out writes, 160 to 3840; its height is 9/16 of that [default: 960 for .png, 480 for .gif].
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(160..=3840))]
    pub width: Option<u32>,
    /// Draw what the solver sees: pins, maps, targets, wind, springs, contacts, bvh, crossings, contours, regions, sleep,
    /// normals, bounds.
    #[arg(long, value_name = "ITEM,...", value_delimiter = ',', value_parser = PossibleValuesParser::new(ClothDebug::ITEMS))]
    pub debug: Vec<String>,
}

impl StageArgs {
    /// Frames that a run without a window simulates if nothing else is asked for.
    const DEFAULT_FRAMES: u32 = 240;

    /// Whether the user asked for a run without a window.
    pub fn asks_for_headless(&self) -> bool {
        self.headless || self.frames.is_some() || self.out.is_some()
    }

    /// How many frames a run without a window simulates.
    pub fn frame_count(&self) -> u32 {
        self.frames.unwrap_or(Self::DEFAULT_FRAMES)
    }

    /// The picture to write, once it is sure that it can be written.
    pub fn picture(&self) -> Result<Option<Picture>, String> {
        self.out.as_deref().map(Picture::at).transpose()
    }
}
