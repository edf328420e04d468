//! The studio around the stage: a dim room with a few soft boxes, as spherical Gaussians.
//!
//! `radiance(d) = room + slope d.y + sum color_i exp(sharpness_i (d . axis_i - 1))`
//!
//! Blurring a Gaussian with another gives a Gaussian again, so diffuse and glossy reflections
//! of this room have the same closed form and need no filtering on the GPU.

use super::texture;
use bevy::{light::EnvironmentMapLight, light::Skybox, prelude::*};

/// A soft box.
struct SoftBox {
    /// Direction in which it hangs (not normalized).
    axis: Vec3,
    /// Radiance in its middle.
    color: Vec3,
    /// Larger is smaller.
    sharpness: f32,
}

/// Radiance of the room at the horizon.
const ROOM: Vec3 = Vec3::new(0.25, 0.27, 0.30);
/// How much brighter the ceiling is than the horizon; the floor is darker by as much.
const SLOPE: Vec3 = Vec3::new(0.16, 0.17, 0.19);
/// One box above, a strip behind that draws silhouettes, one on the shadow side.
const BOXES: [SoftBox; 3] = [
    SoftBox { axis: Vec3::new(-0.2, 1.0, 0.3), color: Vec3::new(1.0, 0.98, 0.94), sharpness: 6.0 },
    SoftBox { axis: Vec3::new(-0.5, 0.45, -1.0), color: Vec3::new(1.9, 2.1, 2.4), sharpness: 10.0 },
    SoftBox { axis: Vec3::new(1.0, 0.35, 0.3), color: Vec3::new(0.75, 0.68, 0.6), sharpness: 5.0 },
];

/// A cosine lobe blurs about as much as a Gaussian of this sharpness.
const COSINE_LOBE: f32 = 2.9;
/// Side and mip levels of the map for glossy reflections.
const SPECULAR: (usize, u32) = (64, 6);
/// Side of the map for diffuse reflections.
const DIFFUSE: usize = 16;

/// The backdrop at the horizon, into which the floor fades (linear).
pub const HORIZON: Vec3 = Vec3::new(0.41, 0.42, 0.44);
/// The backdrop overhead (linear).
const ZENITH: Vec3 = Vec3::new(0.17, 0.205, 0.25);

/// The light that comes from everywhere, without the share that is drawn with shadows.
pub fn light(images: &mut Assets<Image>, unshadowed: f32, brightness: f32) -> EnvironmentMapLight {
    let diffuse = texture::cube(DIFFUSE, 1, |normal, _| radiance(normal, COSINE_LOBE) * unshadowed);
    let (side, levels) = SPECULAR;
    let specular = texture::cube(side, levels, |mirrored, level| {
        let roughness = level as f32 / (levels - 1) as f32;
        radiance(mirrored, glossy_lobe(roughness))
    });
    EnvironmentMapLight {
        diffuse_map: images.add(diffuse),
        specular_map: images.add(specular),
        intensity: brightness,
        ..default()
    }
}

/// What is seen behind the stage.
pub fn backdrop(images: &mut Assets<Image>, brightness: f32) -> Skybox {
    let gradient = texture::cube(64, 1, |direction, _| {
        let height = (direction.y.max(0.0) / 0.5).min(1.0);
        HORIZON.lerp(ZENITH, height * (2.0 - height))
    });
    Skybox { image: Some(images.add(gradient)), brightness, ..default() }
}

/// Mean radiance of everything above, as an upward surface sees it.
pub fn sky() -> Vec3 {
    radiance(Vec3::Y, COSINE_LOBE)
}

/// Radiance from a direction, blurred with a Gaussian of the given sharpness.
fn radiance(direction: Vec3, lobe: f32) -> Vec3 {
    let mean_cosine = 1.0 / lobe.tanh() - 1.0 / lobe;
    let room = ROOM + SLOPE * direction.y * mean_cosine;
    let boxes = BOXES.iter().map(|light| {
        let sharpness = light.sharpness * lobe / (light.sharpness + lobe);
        let dimmed = integral(light.sharpness) / integral(sharpness);
        let away = direction.dot(light.axis.normalize()) - 1.0;
        light.color * dimmed * (sharpness * away).exp()
    });
    room + boxes.sum::<Vec3>()
}

/// The integral of a spherical Gaussian over the sphere, over 2 pi.
fn integral(sharpness: f32) -> f32 {
    (1.0 - (-2.0 * sharpness).exp()) / sharpness
}

/// The Gaussian that fits the reflection lobe of a perceptual roughness (GGX).
fn glossy_lobe(roughness: f32) -> f32 {
    let alpha = roughness * roughness;
    (0.5 / (alpha * alpha).max(1e-4)).clamp(1.5, 500.0)
}
