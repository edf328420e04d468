//! Animations: one palette for all frames, pixels that stay the same left out, small enough
//! for a page.

use super::palette::Palette;
use gif::{DisposalMethod, Encoder, Frame, Repeat};
use image::{RgbImage, imageops};

/// A page should not have to load more than this [byte].
const LARGEST: usize = 2_000_000;
/// What is tried one after the other to stay below: the size, and which of the frames to keep.
const ATTEMPTS: [(f32, usize); 5] = [(1.0, 1), (0.85, 1), (0.85, 2), (0.65, 2), (0.5, 2)];

/// Encodes frames that are `every` sixtieths of a second apart.
pub fn encode(shots: &[RgbImage], every: u32) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    for (scale, keep) in ATTEMPTS {
        let frames: Vec<_> = shots.iter().step_by(keep).map(|shot| scaled(shot, scale)).collect();
        let delay = every * keep as u32 * 100 / 60;
        bytes = animation(&frames, delay as u16).map_err(|error| error.to_string())?;
        if bytes.len() <= LARGEST {
            break;
        }
    }
    Ok(bytes)
}

/// The picture at another size.
fn scaled(shot: &RgbImage, scale: f32) -> RgbImage {
    if scale >= 1.0 {
        return shot.clone();
    }
    let side = |pixels: u32| (pixels as f32 * scale).round() as u32;
    imageops::resize(shot, side(shot.width()), side(shot.height()), imageops::FilterType::Triangle)
}

/// Encodes frames that follow each other after `delay` [10 ms].
fn animation(frames: &[RgbImage], delay: u16) -> Result<Vec<u8>, gif::EncodingError> {
    let (width, height) = frames.first().map_or((1, 1), |frame| (frame.width() as u16, frame.height() as u16));
    let mut palette = Palette::of(frames);
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, width, height, &palette.bytes())?;
    encoder.set_repeat(Repeat::Infinite)?;
    let mut shown = Vec::new();
    for frame in frames {
        let pixels = frame.enumerate_pixels();
        let indices: Vec<u8> = pixels.map(|(x, y, &pixel)| palette.index(x, y, pixel)).collect();
        let changes = changes(&indices, &shown);
        encoder.write_frame(&Frame {
            width,
            height,
            delay,
            dispose: DisposalMethod::Keep,
            transparent: Some(Palette::AS_BEFORE),
            buffer: changes.into(),
            ..Frame::default()
        })?;
        shown = indices;
    }
    drop(encoder);
    Ok(bytes)
}

/// The pixels that are not as before.
fn changes(indices: &[u8], shown: &[u8]) -> Vec<u8> {
    let before = shown.iter().copied().map(Some).chain(std::iter::repeat(None));
    let change = |(&index, before): (&u8, Option<u8>)| {
        if before == Some(index) { Palette::AS_BEFORE } else { index }
    };
    indices.iter().zip(before).map(change).collect()
}
