//! The floor: large tiles, a shade apart, with the grain of polished concrete.

use super::{
    noise,
    texture::{self, Meaning},
};
use bevy::{math::Affine2, prelude::*};

/// Side of the floor [m].
const SIDE: f32 = 80.0;
/// Side of one of the squares [m].
const SQUARE: f32 = 0.5;
/// Squares along the texture.
const SQUARES: usize = 4;
/// Texels along the texture.
const TEXELS: usize = 512;
/// Reflectance of the concrete (linear).
const ALBEDO: Vec3 = Vec3::new(0.38, 0.37, 0.355);
/// How far the two kinds of squares are apart.
const CONTRAST: f32 = 0.045;

/// Lays the floor at height 0.
pub fn spawn(
    commands: &mut Commands,
    meshes: &mut Assets<Mesh>,
    materials: &mut Assets<StandardMaterial>,
    images: &mut Assets<Image>,
) {
    let repeats = SIDE / (SQUARE * SQUARES as f32);
    let material = StandardMaterial {
        base_color_texture: Some(images.add(texture::tile(TEXELS, concrete(), Meaning::Color))),
        perceptual_roughness: 0.62,
        reflectance: 0.35,
        uv_transform: Affine2::from_scale(Vec2::splat(repeats)),
        ..default()
    };
    commands.spawn((
        Name::new("floor"),
        Mesh3d(meshes.add(Plane3d::default().mesh().size(SIDE, SIDE))),
        MeshMaterial3d(materials.add(material)),
    ));
}

/// One repeat of the floor.
fn concrete() -> Vec<Vec3> {
    let texel = |index: usize| {
        let (x, y) = (index % TEXELS, index / TEXELS);
        let square = TEXELS / SQUARES;
        let light = if (x / square + y / square).is_multiple_of(2) { 1.0 } else { -1.0 };
        let at = Vec2::new(x as f32, y as f32) / TEXELS as f32;
        let cloud = noise::cloud(at, 6, 4) - 0.5;
        let grain = noise::at(x as u32, y as u32, 7) - 0.5;
        ALBEDO * (1.0 + CONTRAST * light + 0.10 * cloud + 0.035 * grain)
    };
    (0..TEXELS * TEXELS).map(texel).collect()
}
