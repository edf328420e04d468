//! The lights that cast shadows: a large key light, and the sky where it can be sampled.

use super::{environment, orbit::OrbitCamera, quality::Quality};
use bevy::{
    light::{CascadeShadowConfig, CascadeShadowConfigBuilder},
    prelude::*,
};
use std::f32::consts::TAU;

/// A point of the key light.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct KeyLight;

/// A point of the sky.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct SkyLight;

/// Where the key light stands (not normalized).
const KEY: Vec3 = Vec3::new(-0.65, 1.0, 0.55);
/// Radius of the key light over its distance: the width of a penumbra over the height of the edge.
const KEY_RADIUS: f32 = 0.11;
/// Illuminance by the key light [lx].
const KEY_ILLUMINANCE: f32 = 3700.0;
/// Colour of the key light.
const KEY_COLOR: Color = Color::srgb(1.0, 0.955, 0.89);
/// The most of the environment that is drawn as points of the sky, with shadows ...
const SHADOWED_SHARE: f32 = 0.75;
/// ... for which this many of them must be drawn: the shadow of each must not show.
const SKY_POINTS: f32 = 16.0;
/// The part of the environment that is left in a window, since it reaches what it should not.
const UNSHADED: f32 = 0.85;

/// Part of the environment that lights without shadows.
pub fn unshadowed(quality: &Quality) -> f32 {
    if quality.exposures > 1 { 1.0 - shadowed(quality) } else { UNSHADED }
}

/// Part of the environment that is drawn as points of the sky.
fn shadowed(quality: &Quality) -> f32 {
    SHADOWED_SHARE * (quality.exposures as f32 / SKY_POINTS).min(1.0).sqrt()
}

/// Hangs up the lights.
pub fn spawn(commands: &mut Commands, quality: &Quality, brightness: f32) {
    let light = DirectionalLight { shadow_maps_enabled: true, shadow_depth_bias: 0.02, shadow_normal_bias: 1.8, ..default() };
    for index in 0..quality.key_lights {
        let key = DirectionalLight { color: KEY_COLOR, illuminance: KEY_ILLUMINANCE / quality.key_lights as f32, ..light };
        commands.spawn((KeyLight, key, key_from(index, quality.key_lights)));
    }
    if quality.exposures > 1 {
        let sky = environment::sky() * shadowed(quality);
        let radiance = sky.max_element();
        let sky = DirectionalLight {
            color: Color::LinearRgba(LinearRgba::from_vec3(sky / radiance)),
            illuminance: TAU * radiance * brightness,
            ..light
        };
        commands.spawn((SkyLight, sky, sky_from(0, quality.exposures)));
    }
}

/// The light from one of `count` points of the key light.
pub fn key_from(index: u32, count: u32) -> Transform {
    let (radius, angle) = sunflower(index, count);
    let (across, along) = KEY.normalize().any_orthonormal_pair();
    let point = (across * angle.cos() + along * angle.sin()) * radius * KEY_RADIUS;
    Transform::from_translation(KEY.normalize() + point).looking_at(Vec3::ZERO, Vec3::Y)
}

/// The light from one of `count` points of the sky, all of the same solid angle.
pub fn sky_from(index: u32, count: u32) -> Transform {
    let (radius, angle) = sunflower(index, count);
    let height = (1.0 - radius * radius).max(0.06);
    let around = (1.0 - height * height).sqrt();
    let point = Vec3::new(around * angle.cos(), height, around * angle.sin());
    Transform::from_translation(point).looking_at(Vec3::ZERO, Vec3::X)
}

/// Point `index` of `count` that cover the unit disc evenly, as radius and angle.
fn sunflower(index: u32, count: u32) -> (f32, f32) {
    const GOLDEN_ANGLE: f32 = 2.399_963;
    (((index as f32 + 0.5) / count as f32).sqrt(), index as f32 * GOLDEN_ANGLE)
}

/// Shadows and fog reach a little beyond what the camera looks at.
pub fn follow(
    cameras: Query<(&OrbitCamera, &mut DistanceFog), Changed<OrbitCamera>>,
    mut shadows: Query<&mut CascadeShadowConfig>,
) {
    for (camera, mut fog) in cameras {
        let reach = camera.distance;
        fog.falloff = FogFalloff::Linear { start: reach, end: 2.0 * reach + 7.0 };
        for mut cascades in &mut shadows {
            *cascades = CascadeShadowConfigBuilder {
                num_cascades: 1,
                minimum_distance: 0.05,
                maximum_distance: 1.6 * reach + 1.5,
                ..default()
            }
            .build();
        }
    }
}
