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
        let step = every * keep as u32;
        bytes = animation(&frames, step).map_err(|error| error.to_string())?;
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

/// Encodes frames that follow each other after `step` sixtieths of a second.
fn animation(frames: &[RgbImage], step: u32) -> Result<Vec<u8>, gif::EncodingError> {
    let (width, height) = frames.first().map_or((1, 1), |frame| (frame.width() as u16, frame.height() as u16));
    let mut palette = Palette::of(frames);
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, width, height, &palette.bytes())?;
    encoder.set_repeat(Repeat::Infinite)?;
    let mut shown = Vec::new();
    for (index, frame) in (0..).zip(frames) {
        let pixels = frame.enumerate_pixels();
        let indices: Vec<u8> = pixels.map(|(x, y, &pixel)| palette.index(x, y, pixel)).collect();
        let changes = changes(&indices, &shown);
        encoder.write_frame(&Frame {
            width,
            height,
            delay: (hundredths(step * (index + 1)) - hundredths(step * index)) as u16,
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

/// A number of sixtieths of a second in hundredths, so that the errors do not add up.
fn hundredths(sixtieths: u32) -> u32 {
    (sixtieths * 100 + 30) / 60
}

/// The pixels that are not as before.
fn changes(indices: &[u8], shown: &[u8]) -> Vec<u8> {
    let before = shown.iter().copied().map(Some).chain(std::iter::repeat(None));
    let change = |(&index, before): (&u8, Option<u8>)| {
        if before == Some(index) { Palette::AS_BEFORE } else { index }
    };
    indices.iter().zip(before).map(change).collect()
}
