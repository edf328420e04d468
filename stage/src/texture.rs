//! Textures with mip maps, made from numbers: without mips a weave aliases into sparks.

use bevy::{
    asset::RenderAssetUsages,
    image::{ImageAddressMode, ImageSampler, ImageSamplerDescriptor},
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat, TextureViewDescriptor, TextureViewDimension},
};

/// What the three numbers of a texel mean, hence how they are averaged and stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meaning {
    /// Linear red, green and blue, stored as sRGB.
    Color,
    /// A unit vector in tangent space.
    Normal,
}

/// A square texture (side: a power of two) that repeats, with all its mip levels.
pub fn tile(side: usize, texels: Vec<Vec3>, meaning: Meaning) -> Image {
    let levels = side.ilog2() + 1;
    let mut data = Vec::with_capacity(side * side * 16 / 3);
    let mut level = texels;
    for step in 0..levels {
        data.extend(level.iter().flat_map(|&texel| store(texel, meaning)));
        if step + 1 < levels {
            level = halve(&level, side >> step, meaning);
        }
    }
    let format = match meaning {
        Meaning::Color => TextureFormat::Rgba8UnormSrgb,
        Meaning::Normal => TextureFormat::Rgba8Unorm,
    };
    let mut image = image_of(side, 1, levels, format, data);
    image.sampler = ImageSampler::Default;
    image
}

/// How tiles are filtered; the stage makes it the default of all images.
pub fn sampler(anisotropy: u16) -> ImageSamplerDescriptor {
    ImageSamplerDescriptor {
        address_mode_u: ImageAddressMode::Repeat,
        address_mode_v: ImageAddressMode::Repeat,
        anisotropy_clamp: anisotropy,
        ..ImageSamplerDescriptor::linear()
    }
}

/// A cube map of radiance; `radiance` is asked for a direction and a mip level.
pub fn cube(side: usize, levels: u32, radiance: impl Fn(Vec3, u32) -> Vec3) -> Image {
    let mut data = Vec::new();
    for face in 0..6 {
        for level in 0..levels {
            let side = side >> level;
            for texel in 0..side * side {
                let at = |index: usize| (2.0 * index as f32 + 1.0) / side as f32 - 1.0;
                let direction = cube_direction(face, at(texel % side), at(texel / side));
                data.extend(shared_exponent(radiance(direction, level)).to_le_bytes());
            }
        }
    }
    let mut image = image_of(side, 6, levels, TextureFormat::Rgb9e5Ufloat, data);
    image.sampler = ImageSampler::linear();
    image.texture_view_descriptor = Some(TextureViewDescriptor { dimension: Some(TextureViewDimension::Cube), ..default() });
    image
}

/// Puts bytes, ordered by layer and then by level, into an image.
fn image_of(side: usize, layers: u32, levels: u32, format: TextureFormat, data: Vec<u8>) -> Image {
    let size = Extent3d { width: side as u32, height: side as u32, depth_or_array_layers: layers };
    let usage = RenderAssetUsages::RENDER_WORLD;
    let mut image = Image::new_uninit(size, TextureDimension::D2, format, usage);
    image.texture_descriptor.mip_level_count = levels;
    image.data = Some(data);
    image
}

/// The mean of every 2 x 2 texels.
fn halve(level: &[Vec3], side: usize, meaning: Meaning) -> Vec<Vec3> {
    let half = side / 2;
    let texel = |index: usize| {
        let corner = index / half * 2 * side + index % half * 2;
        let sum = level[corner] + level[corner + 1] + level[corner + side] + level[corner + side + 1];
        match meaning {
            Meaning::Color => sum / 4.0,
            Meaning::Normal => sum.normalize_or(Vec3::Z),
        }
    };
    (0..half * half).map(texel).collect()
}

/// A texel as bytes.
fn store(texel: Vec3, meaning: Meaning) -> [u8; 4] {
    match meaning {
        Meaning::Color => Srgba::from(LinearRgba::from_vec3(texel)).to_u8_array(),
        Meaning::Normal => {
            let [x, y, z] = (texel * 127.5 + 127.5).round().to_array().map(|value| value as u8);
            [x, y, z, u8::MAX]
        }
    }
}

/// The direction in the world that a point of a face shows; cube maps are left-handed.
fn cube_direction(face: usize, u: f32, v: f32) -> Vec3 {
    let (x, y, z) = match face {
        0 => (1.0, -v, -u),
        1 => (-1.0, -v, u),
        2 => (u, 1.0, v),
        3 => (u, -1.0, -v),
        4 => (u, -v, 1.0),
        _ => (-u, -v, -1.0),
    };
    Vec3::new(x, y, -z).normalize()
}

/// Packs a colour into 9 bits each and 5 bits of exponent (`Rgb9e5Ufloat`).
fn shared_exponent(color: Vec3) -> u32 {
    const BITS: i32 = 9;
    const BIAS: i32 = 15;
    let largest = color.max_element().clamp(1e-4, 6e4);
    let exponent = (largest.log2().floor() as i32).max(-BIAS - 1) + 1;
    let scale = f32::from(2u8).powi(BITS - exponent);
    let [r, g, b] = (color * scale).round().to_array().map(|value| value.clamp(0.0, 511.0) as u32);
    r | g << 9 | b << 18 | ((exponent + BIAS) as u32) << 27
}
