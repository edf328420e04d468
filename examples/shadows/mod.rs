//! Draped specimens from above, side by side in one picture: each with its shadow, the disk below and the specimen as it was
//! flat.

use std::error::Error;
use std::path::Path;

use bevy::math::Vec3;
use bevy_drape::lab::drape::{self, DISK, SPECIMEN};
use bevy_drape::lab::{Sample, drape::Drape};
use drape_scenes::Scene;
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};

/// A specimen as it is drawn.
pub struct Shadow {
    caption: [String; 2],
    /// Corners of its triangles [m], the lowest first, and how light each is.
    triangles: Vec<([(f32, f32); 3], f32)>,
}

/// Size of one [px], and how many stand in a row.
const SIZE: u32 = 260;
const COLUMNS: usize = 4;
/// Towards the light.
const LIGHT: Vec3 = Vec3::new(-0.5, 0.8, -0.3);

impl Shadow {
    /// A draped specimen of a preset.
    pub fn of(sample: &Sample, scene: &Scene) -> Self {
        let Drape { coefficient, nodes } = drape::judge(scene);
        let cloth = &scene.cloths[0];
        let mut faces: Vec<[Vec3; 3]> = cloth
            .rest
            .topology
            .faces
            .iter()
            .map(|face| face.map(|p| cloth.sim.state.positions[p as usize].truncate()))
            .collect();
        let height = |face: &[Vec3; 3]| face.iter().map(|x| x.y).sum::<f32>();
        faces.sort_by(|a, b| height(a).total_cmp(&height(b)));
        let light = |[a, b, c]: [Vec3; 3]| (b - a).cross(c - a).normalize_or_zero().dot(LIGHT.normalize()).abs();
        Self {
            caption: [
                sample.name.replace('_', " "),
                format!("{coefficient:.0} %, {nodes} nodes; asked {} within {}", sample.drape, sample.within),
            ],
            triangles: faces.iter().map(|face| (face.map(|x| (x.x, x.z)), light(*face))).collect(),
        }
    }
}

/// Draws specimens into a PNG file.
///
/// # Errors
/// When the file cannot be written.
pub fn draw(path: &Path, shadows: &[Shadow]) -> Result<(), Box<dyn Error>> {
    register_font("sans-serif", FontStyle::Normal, bevy::text::DEFAULT_FONT_DATA).map_err(|_| "the font cannot be read")?;
    let columns = shadows.len().clamp(1, COLUMNS);
    let rows = shadows.len().div_ceil(columns).max(1);
    let (width, height) = (SIZE * columns as u32, SIZE * rows as u32);
    let mut pixels = vec![u8::MAX; (3 * width * height) as usize];
    {
        let sheet = BitMapBackend::with_buffer(&mut pixels, (width, height)).into_drawing_area();
        sheet.fill(&WHITE)?;
        for (area, shadow) in sheet.split_evenly((rows, columns)).iter().zip(shadows) {
            one(shadow, area)?;
        }
        sheet.present()?;
    }
    let picture = image::RgbImage::from_raw(width, height, pixels).ok_or("the picture has another size")?;
    picture.save(path).map_err(|error| format!("{} cannot be written: {error}", path.display()))?;
    Ok(())
}

fn one(shadow: &Shadow, area: &DrawingArea<BitMapBackend<'_>, plotters::coord::Shift>) -> Result<(), Box<dyn Error>> {
    let (middle, scale) = ((SIZE as f32 / 2.0, SIZE as f32 / 2.0 + 16.0), 0.5 * (SIZE as f32 - 44.0) / SPECIMEN);
    let at = |(x, z): (f32, f32)| ((middle.0 + scale * x).round() as i32, (middle.1 + scale * z).round() as i32);
    let radius = |r: f32| (scale * r) as i32;
    area.draw(&Circle::new(at((0.0, 0.0)), radius(SPECIMEN), RGBColor(215, 215, 215).stroke_width(1)))?;
    area.draw(&Circle::new(at((0.0, 0.0)), radius(DISK), RGBColor(120, 120, 120).filled()))?;
    for (corners, light) in &shadow.triangles {
        let shade = |full: f32| (full * (0.3 + 0.7 * light)) as u8;
        area.draw(&Polygon::new(corners.map(at).to_vec(), RGBColor(shade(190.0), shade(196.0), shade(210.0)).filled()))?;
    }
    area.draw(&Circle::new(at((0.0, 0.0)), radius(DISK), RGBColor(90, 90, 90).stroke_width(1)))?;
    area.draw(&Text::new(shadow.caption[0].as_str(), (10, 6), ("sans-serif", 15)))?;
    area.draw(&Text::new(shadow.caption[1].as_str(), (10, 23), ("sans-serif", 12)))?;
    Ok(())
}
