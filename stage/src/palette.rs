//! 255 colours for a whole animation: the median cut, then an ordered dither.

use image::{Rgb, RgbImage};

/// Colours of an animation; the one after the last means "as before".
pub struct Palette {
    colors: Vec<[u8; 3]>,
    nearest: Vec<Option<u8>>,
}

/// Bits per channel of the histogram and of the cache of nearest colours.
const BITS: u32 = 6;
/// Stride between the pixels of an animation that are looked at.
const STRIDE: usize = 7;
/// Amplitude of the dither, about half the distance between two colours.
const DITHER: f32 = 5.0;
/// Order in which the dither lights up the pixels of a square of 4 x 4.
const BAYER: [u8; 16] = [0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5];

impl Palette {
    /// Index that leaves a pixel as the previous frame has shown it.
    pub const AS_BEFORE: u8 = 255;

    /// Colours such that each stands for about as much of the pictures as any other.
    pub fn of(frames: &[RgbImage]) -> Self {
        let pixels = frames.iter().flat_map(RgbImage::pixels).step_by(STRIDE);
        let mut boxes = vec![pixels.map(|pixel| pixel.0).collect::<Vec<_>>()];
        while boxes.len() < usize::from(Self::AS_BEFORE) {
            let widest = boxes.iter().enumerate().max_by_key(|(_, colors)| weight(colors));
            let Some((index, _)) = widest.filter(|(_, colors)| weight(colors) > 0) else {
                break;
            };
            let upper = cut(&mut boxes[index]);
            boxes.push(upper);
        }
        let colors = boxes.iter().map(|colors| mean(colors)).collect();
        Self { colors, nearest: vec![None; 1 << (3 * BITS)] }
    }

    /// Bytes of the colours, red first.
    pub fn bytes(&self) -> Vec<u8> {
        let mut bytes = self.colors.concat();
        bytes.resize(3 * (usize::from(Self::AS_BEFORE) + 1), 0);
        bytes
    }

    /// The index of the colour that stands for a pixel.
    pub fn index(&mut self, x: u32, y: u32, pixel: Rgb<u8>) -> u8 {
        let level = f32::from(BAYER[(y % 4 * 4 + x % 4) as usize]) / 15.0 - 0.5;
        let dithered = pixel.0.map(|channel| (f32::from(channel) + level * DITHER) as u8);
        let slot = dithered.iter().fold(0, |slot, channel| slot << BITS | usize::from(channel >> (8 - BITS)));
        *self.nearest[slot].get_or_insert_with(|| nearest(&self.colors, dithered))
    }
}

/// How much a box of colours gains by being cut: its spread, weighed by its size.
fn weight(colors: &[[u8; 3]]) -> u64 {
    let (_, spread) = widest(colors);
    u64::from(spread) * u64::from(spread) * (colors.len() as f64).sqrt() as u64
}

/// The channel in which the colours differ most, and by how much.
fn widest(colors: &[[u8; 3]]) -> (usize, u8) {
    let spread = |channel: usize| {
        let values = colors.iter().map(|color| color[channel]);
        values.clone().max().unwrap_or(0) - values.min().unwrap_or(0)
    };
    let spreads = [spread(0), spread(1), spread(2)];
    (0..3).map(|channel| (channel, spreads[channel])).max_by_key(|&(_, spread)| spread).unwrap_or((0, 0))
}

/// Cuts a box at the middle of its widest channel and returns the upper part.
fn cut(colors: &mut Vec<[u8; 3]>) -> Vec<[u8; 3]> {
    let (channel, _) = widest(colors);
    let low = colors.iter().map(|color| color[channel]).min().unwrap_or(0);
    let high = colors.iter().map(|color| color[channel]).max().unwrap_or(0);
    let middle = low + (high - low) / 2;
    let (lower, upper) = colors.iter().partition(|color| color[channel] <= middle);
    *colors = lower;
    upper
}

/// The mean of a box of colours.
fn mean(colors: &[[u8; 3]]) -> [u8; 3] {
    let count = colors.len().max(1) as u64;
    let channel = |channel: usize| {
        let sum: u64 = colors.iter().map(|color| u64::from(color[channel])).sum();
        ((sum + count / 2) / count) as u8
    };
    [channel(0), channel(1), channel(2)]
}

/// The index of the colour that differs least.
fn nearest(colors: &[[u8; 3]], wanted: [u8; 3]) -> u8 {
    let distance = |color: &[u8; 3]| -> u32 {
        let channels = color.iter().zip(wanted);
        channels.map(|(&is, wanted)| u32::from(is.abs_diff(wanted)).pow(2)).sum()
    };
    let nearest = colors.iter().enumerate().min_by_key(|(_, color)| distance(color));
    nearest.map_or(0, |(index, _)| index as u8)
}
