//! Takes a picture: the mean of many drawings of one moment, each from another point in the
//! pixel and with light from another point of the lamps. That gives soft shadows and smooth
//! edges on any device, at the price of time.

use super::{
    light::{self, KeyLight, SkyLight},
    quality::Quality,
};
use bevy::{
    camera::RenderTarget,
    prelude::*,
    render::{
        RenderApp,
        camera::TemporalJitter,
        render_asset::RenderAssets,
        render_resource::{
            BufferDescriptor, BufferUsages, CommandEncoderDescriptor, MapMode, PipelineCache, PollType, TexelCopyBufferInfo,
            TexelCopyBufferLayout, TextureFormat, TextureUsages,
        },
        renderer::{RenderDevice, RenderQueue},
        texture::GpuImage,
    },
};
use image::{Rgb, RgbImage};
use std::sync::OnceLock;

/// Bytes per pixel of the picture on the device.
const PIXEL: usize = 4;
/// Drawings after which missing pipelines are a failure rather than slow.
const PATIENCE: u32 = 2000;

/// The picture that the camera draws into.
#[derive(Resource, Clone, Debug)]
pub struct Film(Handle<Image>);

impl Film {
    /// A film for the camera of the stage.
    pub fn new(images: &mut Assets<Image>, size: UVec2) -> Self {
        let mut film = Image::new_target_texture(size.x, size.y, TextureFormat::Rgba8UnormSrgb, None);
        film.texture_descriptor.usage |= TextureUsages::COPY_SRC;
        Self(images.add(film))
    }

    /// Where the camera draws.
    pub fn target(&self) -> RenderTarget {
        RenderTarget::Image(self.0.clone().into())
    }
}

/// Opens the shutter; `draw` is asked to draw the same moment again and again.
pub fn shoot(app: &mut App, mut draw: impl FnMut(&mut App)) -> Result<RgbImage, String> {
    let quality = *app.world().resource::<Quality>();
    open(app, true);
    let mut light = vec![Vec3::ZERO; (quality.size.x * quality.size.y) as usize];
    for exposure in 0..quality.exposures {
        expose(app, exposure, quality.exposures);
        draw_all(app, &mut draw)?;
        let bytes = read_back(app)?;
        for (sum, pixel) in light.iter_mut().zip(bytes.chunks_exact(PIXEL)) {
            *sum += Vec3::new(linear(pixel[0]), linear(pixel[1]), linear(pixel[2]));
        }
    }
    open(app, false);
    Ok(RgbImage::from_fn(quality.size.x, quality.size.y, |x, y| {
        let mean = light[(y * quality.size.x + x) as usize] / quality.exposures as f32;
        let [red, green, blue, _] = Srgba::from(LinearRgba::from_vec3(mean)).to_u8_array();
        Rgb([red, green, blue])
    }))
}

/// A camera that is not active costs nothing while time passes between two pictures.
fn open(app: &mut App, open: bool) {
    let mut cameras = app.world_mut().query::<&mut Camera>();
    for mut camera in cameras.iter_mut(app.world_mut()) {
        camera.is_active = open;
    }
}

/// Moves the lights and the pixels to where this exposure has them.
fn expose(app: &mut App, exposure: u32, exposures: u32) {
    let world = app.world_mut();
    let mut keys = world.query_filtered::<&mut Transform, With<KeyLight>>();
    for mut transform in keys.iter_mut(world) {
        *transform = light::key_from(exposure, exposures);
    }
    let mut skies = world.query_filtered::<&mut Transform, With<SkyLight>>();
    for mut transform in skies.iter_mut(world) {
        *transform = light::sky_from(exposure, exposures);
    }
    let mut pixels = world.query::<&mut TemporalJitter>();
    for mut jitter in pixels.iter_mut(world) {
        jitter.offset = Vec2::new(inverse_radix(exposure + 1, 2), inverse_radix(exposure + 1, 3)) - 0.5;
    }
}

/// Draws until nothing is left out because its shader is still loading.
fn draw_all(app: &mut App, draw: &mut impl FnMut(&mut App)) -> Result<(), String> {
    for _ in 0..PATIENCE {
        draw(app);
        let pipelines = app.sub_app(RenderApp).world().resource::<PipelineCache>();
        if pipelines.waiting_pipelines().next().is_none() {
            return Ok(());
        }
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    Err("the shaders did not get ready".into())
}

/// Copies the film from the device, rows packed.
fn read_back(app: &App) -> Result<Vec<u8>, String> {
    let world = app.sub_app(RenderApp).world();
    let film = app.world().resource::<Film>();
    let film = world.resource::<RenderAssets<GpuImage>>().get(&film.0).ok_or("there is no film")?;
    let (device, queue) = (world.resource::<RenderDevice>(), world.resource::<RenderQueue>());
    let size = film.texture_descriptor.size;
    let row = size.width as usize * PIXEL;
    let padded_row = RenderDevice::align_copy_bytes_per_row(row);
    let buffer = device.create_buffer(&BufferDescriptor {
        label: Some("picture"),
        size: (padded_row * size.height as usize) as u64,
        usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let layout = TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(padded_row as u32), rows_per_image: None };
    let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor::default());
    encoder.copy_texture_to_buffer(film.texture.as_image_copy(), TexelCopyBufferInfo { buffer: &buffer, layout }, size);
    queue.submit([encoder.finish()]);
    buffer.slice(..).map_async(MapMode::Read, |_| ());
    device.poll(PollType::wait_indefinitely()).map_err(|error| error.to_string())?;
    let bytes = buffer.slice(..).get_mapped_range();
    Ok(bytes.chunks_exact(padded_row).flat_map(|padded| &padded[..row]).copied().collect())
}

/// A byte of the film as linear light.
fn linear(byte: u8) -> f32 {
    static TABLE: OnceLock<[f32; 256]> = OnceLock::new();
    TABLE.get_or_init(|| std::array::from_fn(|byte| Srgba::gamma_function(byte as f32 / 255.0)))[usize::from(byte)]
}

/// The digits of a number in a base, mirrored at the point: fills 0..1 evenly.
fn inverse_radix(mut number: u32, base: u32) -> f32 {
    let (mut value, mut weight) = (0.0, 1.0 / base as f32);
    while number > 0 {
        value += (number % base) as f32 * weight;
        number /= base;
        weight /= base as f32;
    }
    value
}
