//! Charts of lines over one axis, side by side in one picture.

use std::error::Error;
use std::path::Path;

use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};

/// Lines over one axis.
pub struct Chart<'a> {
    /// What stands above it.
    pub title: String,
    /// What the axes say.
    pub axes: [&'a str; 2],
    /// End of the vertical axis, which begins with 0.
    pub top: f64,
    /// Names and points.
    pub lines: Vec<(&'a str, Vec<(f64, f64)>)>,
}

/// Size of a chart [px].
const SIZE: (u32, u32) = (520, 380);
/// Colours of the lines.
const COLORS: [RGBColor; 4] = [RGBColor(178, 60, 50), RGBColor(40, 84, 160), RGBColor(60, 130, 80), RGBColor(120, 90, 150)];

/// Draws the charts beside each other into a PNG file.
///
/// # Errors
/// When the file cannot be written.
pub fn draw(charts: &[Chart<'_>], path: &Path) -> Result<(), Box<dyn Error>> {
    register_font("sans-serif", FontStyle::Normal, bevy::text::DEFAULT_FONT_DATA).map_err(|_| "the font cannot be read")?;
    let (width, height) = (SIZE.0 * charts.len().max(1) as u32, SIZE.1);
    let mut pixels = vec![u8::MAX; (3 * width * height) as usize];
    {
        let sheet = BitMapBackend::with_buffer(&mut pixels, (width, height)).into_drawing_area();
        sheet.fill(&WHITE)?;
        for (area, chart) in sheet.split_evenly((1, charts.len().max(1))).iter().zip(charts) {
            one(chart, area)?;
        }
        sheet.present()?;
    }
    let picture = image::RgbImage::from_raw(width, height, pixels).ok_or("the picture has another size")?;
    picture.save(path).map_err(|error| format!("{} cannot be written: {error}", path.display()))?;
    Ok(())
}

fn one(chart: &Chart<'_>, area: &DrawingArea<BitMapBackend<'_>, plotters::coord::Shift>) -> Result<(), Box<dyn Error>> {
    let points = || chart.lines.iter().flat_map(|(_, points)| points);
    let (left, right) = points().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| (a.min(p.0), b.max(p.0)));
    let margin = 0.05 * (right - left);
    let mut axes = ChartBuilder::on(area)
        .caption(&chart.title, ("sans-serif", 15))
        .margin(14)
        .x_label_area_size(40)
        .y_label_area_size(56)
        .build_cartesian_2d(left - margin..right + margin, 0.0..chart.top)?;
    axes.configure_mesh()
        .x_desc(chart.axes[0])
        .y_desc(chart.axes[1])
        .x_label_formatter(&|x| format!("{x:.0}"))
        .y_label_formatter(&|y| format!("{y}"))
        .label_style(("sans-serif", 12))
        .axis_desc_style(("sans-serif", 13))
        .light_line_style(TRANSPARENT)
        .bold_line_style(RGBColor(225, 225, 225))
        .draw()?;
    for ((name, points), color) in chart.lines.iter().zip(COLORS) {
        let line = LineSeries::new(points.iter().copied(), color.stroke_width(2)).point_size(4);
        axes.draw_series(line)?
            .label(*name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], color.stroke_width(2)));
    }
    axes.configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .background_style(WHITE.mix(0.9))
        .label_font(("sans-serif", 13))
        .draw()?;
    Ok(())
}
