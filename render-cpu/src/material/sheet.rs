//! The sheet of one material: the ball, lobes in polar coordinates, albedo over the angle, local roughness along the lobes.

use super::curves::{INCIDENCES, Probe, Slice};
use super::preview::{AnyError, Preview};
use crate::plot::canvas::{Area, Canvas, FONT, text_style};
use plotters::prelude::{
    BLACK, ChartBuilder, Color, IntoFont, LineSeries, PathElement, RGBColor, Text, WHITE,
};

/// Size of the sheet.
const WIDTH: u32 = 1240;
const HEIGHT: u32 = 900;
/// Side of the picture.
pub const PICTURE: u32 = 400;
/// Space around the picture, and above it for the title.
const MARGIN: u32 = 20;
const TITLE: u32 = 50;

/// Colours of the angles of incidence.
const COLOURS: [RGBColor; 4] = [
    RGBColor(0x1f, 0x5f, 0xa8),
    RGBColor(0x2b, 0x91, 0x5a),
    RGBColor(0xd9, 0x85, 0x12),
    RGBColor(0xb8, 0x2c, 0x3e),
];
/// Colours of the channels.
const CHANNELS: [RGBColor; 3] = [
    RGBColor(0xc0, 0x20, 0x20),
    RGBColor(0x20, 0x90, 0x20),
    RGBColor(0x20, 0x40, 0xc0),
];
const GREY: RGBColor = RGBColor(0xb4, 0xb4, 0xb4);

/// Largest local roughness that is drawn: a lobe this wide is flat.
const ROUGHEST: f32 = 1.5;

/// Draws the sheet of a material, its ball rendered with `spp` samples per pixel.
///
/// # Errors
/// When the film cannot be allocated or the drawing library fails.
pub fn draw(name: &str, preview: &Preview, spp: u32) -> Result<Canvas, AnyError> {
    let picture = preview.render(spp)?;
    let size = preview.scene.tables.camera.crop_size[0];
    let probe = Probe::new(preview.scene.tables.view(), preview.material);
    let slices: Vec<Slice> = INCIDENCES.iter().map(|&angle| probe.slice(angle)).collect();
    let mut canvas = Canvas::new(WIDTH, HEIGHT);
    canvas.draw(|area| {
        area.draw(&Text::new(
            name.to_owned(),
            (MARGIN as i32, 14),
            text_style(24),
        ))?;
        let (top, bottom) = area.split_vertically(TITLE + PICTURE + MARGIN);
        let (_, right) = top.split_horizontally(PICTURE + 2 * MARGIN);
        let (albedo, roughness) = bottom.split_horizontally(WIDTH / 2);
        draw_lobes(&right, &slices)?;
        draw_albedo(&albedo, &probe)?;
        draw_roughness(&roughness, &slices)
    })?;
    canvas.paste(&picture, [size; 2], MARGIN, TITLE);
    Ok(canvas)
}

/// The point of a polar diagram.
fn polar(degrees: f32, radius: f32) -> (f32, f32) {
    let (sin, cos) = degrees.to_radians().sin_cos();
    (radius * sin, radius * cos)
}

/// Lobes, each scaled to its largest value; discrete directions as straight lines by their share of the light.
fn draw_lobes(area: &Area<'_>, slices: &[Slice]) -> Result<(), AnyError> {
    let transmits = slices.iter().any(|slice| {
        let below = |entry: &[f32; 2]| entry[0].abs() > 90.0 && entry[1] > 0.0;
        slice.values.iter().any(below) || slice.discrete.iter().any(below)
    });
    let (width, height) = area.dim_in_pixel();
    let bottom = if transmits { -1.1_f32 } else { -0.08 };
    // The same scale along both axes.
    let half = (1.12 - bottom) * width as f32 / (height - 60) as f32 * 0.5;
    let mut chart = ChartBuilder::on(area)
        .caption(
            "f cos in the plane of incidence, lobes to their largest value, discrete directions as bars of their share",
            (FONT, 14),
        )
        .margin(10)
        .build_cartesian_2d(-half..half, bottom..1.12_f32)?;
    for radius in [0.25_f32, 0.5, 0.75, 1.0] {
        let reach = if transmits { 180 } else { 90 };
        let arc = (-reach..=reach).map(|a| polar(a as f32, radius));
        chart.draw_series(LineSeries::new(arc, GREY.mix(0.5)))?;
    }
    chart.draw_series(LineSeries::new([(-half, 0.0), (half, 0.0)], BLACK))?;
    for ((slice, &incidence), colour) in slices.iter().zip(&INCIDENCES).zip(COLOURS) {
        let largest = slice.values.iter().map(|v| v[1]).fold(0.0_f32, f32::max);
        if largest > 0.0 {
            let lobe = slice.values.iter().map(|v| polar(v[0], v[1] / largest));
            chart.draw_series(LineSeries::new(lobe, colour.stroke_width(2)))?;
        }
        for &[angle, share] in &slice.discrete {
            let line = vec![(0.0, 0.0), polar(angle, share.min(1.0))];
            chart.draw_series([PathElement::new(line, colour.stroke_width(4))])?;
        }
        // Where the light is seen from.
        let seen = vec![polar(-incidence, 1.02), polar(-incidence, 1.09)];
        chart.draw_series([PathElement::new(seen, colour.stroke_width(3))])?;
    }
    for (i, (incidence, colour)) in INCIDENCES.iter().zip(COLOURS).enumerate() {
        let style = (FONT, 15).into_font().color(&colour);
        let corner = (12, 34 + 20 * i as i32);
        area.draw(&Text::new(
            format!("seen at {incidence:.0}°"),
            corner,
            style,
        ))?;
    }
    Ok(())
}

fn draw_albedo(area: &Area<'_>, probe: &Probe<'_>) -> Result<(), AnyError> {
    let angles: Vec<f32> = (0..45).map(|i| i as f32 * 2.0).collect();
    let albedos: Vec<_> = angles.iter().map(|&angle| probe.albedo(angle)).collect();
    let highest = albedos
        .iter()
        .map(|a| a.max_element())
        .fold(1.0_f32, f32::max);
    let mut chart = ChartBuilder::on(area)
        .caption("share of the light that is scattered", (FONT, 16))
        .margin(14)
        .x_label_area_size(38)
        .y_label_area_size(48)
        .build_cartesian_2d(0.0_f32..90.0, 0.0_f32..1.05 * highest)?;
    chart
        .configure_mesh()
        .x_desc("angle from the normal in degrees")
        .label_style((FONT, 13))
        .light_line_style(WHITE)
        .draw()?;
    for (channel, colour) in CHANNELS.into_iter().enumerate() {
        let curve = angles.iter().zip(&albedos).map(|(&x, a)| (x, a[channel]));
        chart.draw_series(LineSeries::new(curve, colour.stroke_width(2)))?;
    }
    Ok(())
}

fn draw_roughness(area: &Area<'_>, slices: &[Slice]) -> Result<(), AnyError> {
    let largest = slices
        .iter()
        .flat_map(|slice| &slice.roughness)
        .map(|r| r[1])
        .filter(|&r| r <= ROUGHEST)
        .fold(0.1_f32, f32::max);
    let mut chart = ChartBuilder::on(area)
        .caption("local Beckmann roughness along the lobe", (FONT, 16))
        .margin(14)
        .x_label_area_size(38)
        .y_label_area_size(48)
        .build_cartesian_2d(-90.0_f32..90.0, 0.0_f32..1.1 * largest)?;
    chart
        .configure_mesh()
        .x_desc("scattered angle in degrees; what is flat is left out")
        .label_style((FONT, 13))
        .light_line_style(WHITE)
        .draw()?;
    for (slice, colour) in slices.iter().zip(COLOURS) {
        // Flat stretches interrupt the curve.
        for run in slice.roughness.split(|r| r[1] > 1.1 * largest) {
            let curve = run.iter().map(|r| (r[0], r[1]));
            chart.draw_series(LineSeries::new(curve, colour.stroke_width(2)))?;
        }
    }
    Ok(())
}
