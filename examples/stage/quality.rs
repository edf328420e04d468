//! How much work a picture is worth, which depends on who draws it and for whom.

use super::{driver::Driver, picture::PictureKind};
use bevy::{light::ShadowFilteringMethod, prelude::*};

/// What the lights, the camera and the shutter are set up for.
#[derive(Resource, Clone, Copy, Debug)]
pub struct Quality {
    /// Samples per pixel of one drawing.
    pub msaa: Msaa,
    /// Side of the shadow map, in texels.
    pub shadow_map: usize,
    /// How shadows are smoothed; the mean of many exposures is smooth by itself.
    pub shadow_filter: ShadowFilteringMethod,
    /// Directional lights that the key light is split into: its penumbra has as many steps.
    pub key_lights: u32,
    /// Drawings that one picture is the mean of, each with another point of every light.
    pub exposures: u32,
    /// Size of a picture in pixels.
    pub size: UVec2,
}

impl Quality {
    /// Fluent in a window.
    pub fn window(driver: &Driver) -> Self {
        Self {
            msaa: if driver.software { Msaa::Off } else { Msaa::Sample4 },
            shadow_map: if driver.software { 1024 } else { 4096 },
            shadow_filter: ShadowFilteringMethod::Gaussian,
            key_lights: if driver.software { 1 } else { 6 },
            exposures: 1,
            size: UVec2::new(1280, 720),
        }
    }

    /// As good as a picture may take time for.
    pub fn picture(kind: PictureKind, driver: &Driver) -> Self {
        let (exposures, size) = match kind {
            PictureKind::Png => (if driver.software { 32 } else { 128 }, UVec2::new(960, 540)),
            PictureKind::Gif => (if driver.software { 6 } else { 32 }, UVec2::new(480, 270)),
        };
        Self {
            msaa: Msaa::Off,
            shadow_map: std::env::var("T_SM").map_or(2048, |v| v.parse().unwrap()),
            shadow_filter: ShadowFilteringMethod::Hardware2x2,
            key_lights: 1,
            exposures: std::env::var("T_EX").map_or(exposures, |v| v.parse().unwrap()),
            size,
        }
    }
}
