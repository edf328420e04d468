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
    /// Taps along a texture on a slant. Mesa's software driver gets these wrong.
    pub anisotropy: u16,
    /// Added to the level of mip maps; the mean of many exposures can do with finer ones.
    pub mip_bias: f32,
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
            anisotropy: if driver.software { 1 } else { 8 },
            mip_bias: 0.0,
            key_lights: if driver.software { 1 } else { 6 },
            exposures: 1,
            size: UVec2::new(1280, 720),
        }
    }

    /// As good as a picture may take time for.
    ///
    /// `width` [px] in place of the usual one.
    pub fn picture(kind: PictureKind, driver: &Driver, width: Option<u32>) -> Self {
        let (exposures, size, shadow_map) = match kind {
            PictureKind::Png => (if driver.software { 24 } else { 128 }, UVec2::new(960, 540), 2048),
            PictureKind::Gif => (if driver.software { 4 } else { 32 }, UVec2::new(480, 270), 1024),
        };
        Self {
            msaa: Msaa::Off,
            shadow_map,
            shadow_filter: match kind {
                PictureKind::Png => ShadowFilteringMethod::Hardware2x2,
                PictureKind::Gif => ShadowFilteringMethod::Gaussian,
            },
            anisotropy: if driver.software { 1 } else { 8 },
            mip_bias: -0.5,
            key_lights: 1,
            exposures,
            size: width.map_or(size, |width| UVec2::new(width, width * 9 / 16)),
        }
    }

    /// Words are as large in relation to a picture as in one of the usual width.
    pub fn words(&self) -> UiScale {
        UiScale(self.size.x as f32 / 960.0)
    }
}
