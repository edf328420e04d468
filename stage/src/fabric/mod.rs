//! What cloth is made of, to the eye: woven textures and the materials that go with them.
//!
//! Meshes need UVs, and tangents for the relief of the weave to show.

mod hide;
mod relief;
mod weave;

use super::texture::{self, Meaning};
use bevy::{math::Affine2, prelude::*};
use hide::Hide;
use relief::Relief;
use weave::{Pattern, Weave, Yarns};

/// What a cloth looks like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FabricLook {
    /// Plain weave, matt.
    Cotton,
    /// Coarse plain weave of uneven yarns.
    Linen,
    /// Satin: smooth, with a sheen along one of its yarns.
    Silk,
    /// Twill of uneven yarns, fuzzy.
    Wool,
    /// Steep twill of coloured yarns over white ones.
    Denim,
    /// Plain weave with stripes of a second colour.
    Stripes(Color),
    /// Plain weave with checks of a second colour.
    Gingham(Color),
    /// Grained skin.
    Leather,
    /// Smooth and dull.
    Rubber,
}

/// Makes the material of a fabric; its texture is `repeats` times along each unit of UV.
///
/// One repeat is 32 yarns of a weave wide, or a pair of checks or stripes.
pub fn fabric(
    images: &mut Assets<Image>,
    materials: &mut Assets<StandardMaterial>,
    look: FabricLook,
    color: Color,
    repeats: f32,
) -> Handle<StandardMaterial> {
    let relief = relief(look, linear(color));
    let normal = texture::tile(Relief::TEXELS, relief.normals(), Meaning::Normal);
    let color = texture::tile(Relief::TEXELS, relief.colors, Meaning::Color);
    materials.add(StandardMaterial {
        base_color_texture: Some(images.add(color)),
        normal_map_texture: Some(images.add(normal)),
        uv_transform: Affine2::from_scale(Vec2::splat(repeats)),
        double_sided: true,
        cull_mode: None,
        ..shine(look)
    })
}

/// How a fabric throws light back.
fn shine(look: FabricLook) -> StandardMaterial {
    let (perceptual_roughness, reflectance, diffuse_transmission) = match look {
        FabricLook::Cotton | FabricLook::Stripes(_) | FabricLook::Gingham(_) => (0.85, 0.30, 0.12),
        FabricLook::Linen => (0.88, 0.28, 0.15),
        FabricLook::Silk => (0.42, 0.55, 0.10),
        FabricLook::Wool => (0.95, 0.20, 0.0),
        FabricLook::Denim => (0.85, 0.25, 0.0),
        FabricLook::Leather => (0.48, 0.50, 0.0),
        FabricLook::Rubber => (0.55, 0.45, 0.0),
    };
    StandardMaterial { perceptual_roughness, reflectance, diffuse_transmission, ..default() }
}

/// A colour as linear light.
fn linear(color: Color) -> Vec3 {
    LinearRgba::from(color).to_vec3()
}

/// The surface of a fabric.
fn relief(look: FabricLook, color: Vec3) -> Relief {
    let plain = Weave { pattern: Pattern::Plain, yarns: Yarns::Plain(color), lift: 0.5, depth: 0.22, uneven: 0.12, fuzz: 0.10 };
    match look {
        FabricLook::Cotton => plain.relief(),
        FabricLook::Linen => Weave { uneven: 0.30, fuzz: 0.16, depth: 0.28, ..plain }.relief(),
        FabricLook::Silk => {
            Weave { pattern: Pattern::Satin, lift: 0.2, depth: 0.06, uneven: 0.05, fuzz: 0.02, ..plain }.relief()
        }
        FabricLook::Wool => Weave { pattern: Pattern::Twill, depth: 0.25, uneven: 0.30, fuzz: 0.45, ..plain }.relief(),
        FabricLook::Denim => {
            Weave { pattern: Pattern::Denim, yarns: Yarns::Denim(color), depth: 0.24, uneven: 0.35, fuzz: 0.20, ..plain }
                .relief()
        }
        FabricLook::Stripes(second) => Weave { yarns: Yarns::Stripes([color, linear(second)]), ..plain }.relief(),
        FabricLook::Gingham(second) => Weave { yarns: Yarns::Gingham([color, linear(second)]), ..plain }.relief(),
        FabricLook::Leather => Hide { color, grains: 26, depth: 2.2 }.relief(),
        FabricLook::Rubber => Hide { color, grains: 90, depth: 0.25 }.relief(),
    }
}
