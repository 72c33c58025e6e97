//! Diagrams: lines and points over linear or logarithmic axes, written as PNG.
//!
//! A [`Plot`] is data; [`write_png`] lays plots out side by side. They are drawn on the canvas of the material
//! diagrams, with its embedded font, so that a diagram is the same everywhere. Points that an axis cannot show (not
//! finite, or not positive on a logarithmic axis) are left out.

pub mod canvas;
pub mod picture;
pub mod strategy_sheet;

use canvas::{Area, Canvas, FONT};
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use plotters::prelude::*;
use std::path::Path;

/// How an axis maps values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// As they are.
    Linear,
    /// By their logarithm.
    Logarithmic,
}

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// A line.
    Line,
    /// A dashed line, for theory.
    Dashed,
    /// Points.
    Points,
}

/// One curve.
#[derive(Clone, Debug)]
pub struct Series {
    /// What the legend calls it; no entry when empty.
    pub label: String,
    /// How it is drawn.
    pub mark: Mark,
    /// Colour out of the palette; series that belong together share it.
    pub colour: usize,
    /// The data.
    pub points: Vec<(f64, f64)>,
}

/// A diagram.
#[derive(Clone, Debug)]
pub struct Plot {
    /// Above it.
    pub title: String,
    /// Below and to the left.
    pub axes: [String; 2],
    /// Of both axes.
    pub scales: [Scale; 2],
    /// Curves, drawn in order.
    pub series: Vec<Series>,
}

/// Why a diagram was not written.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    /// There is no point that could be drawn.
    #[error("the diagram '{0}' has no points")]
    Empty(String),
    /// Drawing failed.
    #[error("cannot draw the diagram: {0}")]
    Drawing(String),
    /// The file could not be written.
    #[error("cannot write {0}: {1}")]
    Write(String, String),
}

/// Width of one diagram in pixels.
const WIDTH: u32 = 760;
/// Height of one diagram in pixels.
const HEIGHT: u32 = 560;

/// Colours that stay apart for readers with deficient colour vision (after Okabe and Ito).
const PALETTE: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(90, 90, 90),
    RGBColor(150, 20, 20),
];

impl Plot {
    /// The points of a series in axis coordinates, without those that the axes cannot show.
    fn placed(&self, series: &Series) -> Vec<(f64, f64)> {
        let position = |scale: Scale, v: f64| match scale {
            Scale::Linear => v,
            Scale::Logarithmic if v > 0.0 => v.log10(),
            Scale::Logarithmic => f64::NAN,
        };
        series
            .points
            .iter()
            .map(|&(x, y)| (position(self.scales[0], x), position(self.scales[1], y)))
            .filter(|(x, y)| x.is_finite() && y.is_finite())
            .collect()
    }

    /// Ranges of both axes, a little wider than the data.
    fn ranges(&self) -> Option<[(f64, f64); 2]> {
        let points: Vec<(f64, f64)> = self.series.iter().flat_map(|s| self.placed(s)).collect();
        let range = |values: &mut dyn Iterator<Item = f64>| {
            let (low, high) = values.fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
            let margin = 0.04 * (high - low).max(1e-9 * low.abs()).max(1e-12);
            (low - margin, high + margin)
        };
        if points.is_empty() {
            return None;
        }
        Some([
            range(&mut points.iter().map(|p| p.0)),
            range(&mut points.iter().map(|p| p.1)),
        ])
    }
}

/// Label of a tick; on logarithmic axes only powers of ten have one, unless the axis is short.
fn tick(scale: Scale, v: f64, span: f64) -> String {
    if scale == Scale::Linear {
        let digits = (1.0 - span.max(1e-12).log10().floor()).clamp(0.0, 8.0);
        return format!("{v:.*}", digits as usize);
    }
    let power = v.round();
    if (v - power).abs() > 1e-6 {
        if span > 1.2 {
            return String::new();
        }
        return format!("{:.2e}", 10_f64.powf(v));
    }
    if (0.0..4.0).contains(&power) {
        format!("{}", 10_f64.powf(power))
    } else {
        format!("1e{power}")
    }
}

fn failed(error: impl std::fmt::Display) -> PlotError {
    PlotError::Drawing(error.to_string())
}

fn draw(area: &Area<'_>, plot: &Plot) -> Result<(), PlotError> {
    let Some([(x0, x1), (y0, y1)]) = plot.ranges() else {
        return Err(PlotError::Empty(plot.title.clone()));
    };
    let mut chart = ChartBuilder::on(area)
        .caption(&plot.title, (FONT, 19))
        .margin(14)
        .x_label_area_size(46)
        .y_label_area_size(78)
        .build_cartesian_2d(x0..x1, y0..y1)
        .map_err(failed)?;
    chart
        .configure_mesh()
        .x_desc(&plot.axes[0])
        .y_desc(&plot.axes[1])
        .x_label_formatter(&|v| tick(plot.scales[0], *v, x1 - x0))
        .y_label_formatter(&|v| tick(plot.scales[1], *v, y1 - y0))
        .label_style((FONT, 14))
        .axis_desc_style((FONT, 16))
        .light_line_style(RGBColor(244, 244, 244))
        .bold_line_style(RGBColor(224, 224, 224))
        .draw()
        .map_err(failed)?;
    for series in &plot.series {
        let colour = PALETTE[series.colour % PALETTE.len()];
        let points = plot.placed(series);
        let drawn = match series.mark {
            Mark::Line => chart.draw_series(LineSeries::new(points, colour.stroke_width(2))),
            Mark::Dashed => chart.draw_series(DashedLineSeries::new(
                points,
                7,
                5,
                colour.mix(0.8).stroke_width(2),
            )),
            Mark::Points => chart.draw_series(
                points
                    .into_iter()
                    .map(|p| Circle::new(p, 4, colour.filled())),
            ),
        }
        .map_err(failed)?;
        if !series.label.is_empty() {
            let mark = series.mark;
            drawn.label(&series.label).legend(move |(x, y)| {
                let ends = match mark {
                    Mark::Line => vec![(x, y), (x + 20, y)],
                    Mark::Dashed => vec![(x, y), (x + 8, y)],
                    Mark::Points => vec![(x + 8, y), (x + 12, y)],
                };
                let width = if mark == Mark::Points { 6 } else { 2 };
                PathElement::new(ends, colour.stroke_width(width))
            });
        }
    }
    if plot.series.iter().any(|s| !s.label.is_empty()) {
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::LowerLeft)
            .label_font((FONT, 13))
            .background_style(WHITE.mix(0.85))
            .border_style(RGBColor(200, 200, 200))
            .draw()
            .map_err(failed)?;
    }
    Ok(())
}

/// Writes diagrams side by side, two in a row.
///
/// # Errors
/// If a diagram has no points or the file cannot be written.
pub fn write_png(path: &Path, plots: &[Plot]) -> Result<(), PlotError> {
    if let Some(plot) = plots.iter().find(|p| p.ranges().is_none()) {
        return Err(PlotError::Empty(plot.title.clone()));
    }
    let columns = (plots.len() as u32).clamp(1, 2);
    let rows = (plots.len() as u32).div_ceil(columns).max(1);
    let (width, height) = (WIDTH * columns, HEIGHT * rows);
    let mut canvas = Canvas::new(width, height);
    canvas
        .draw(|root| {
            let areas = root.split_evenly((rows as usize, columns as usize));
            for (area, plot) in areas.iter().zip(plots) {
                draw(area, plot)?;
            }
            Ok(())
        })
        .map_err(failed)?;
    let mut bytes = vec![];
    PngEncoder::new(&mut bytes)
        .write_image(canvas.rgb(), width, height, ExtendedColorType::Rgb8)
        .map_err(failed)?;
    std::fs::write(path, bytes)
        .map_err(|e| PlotError::Write(path.display().to_string(), e.to_string()))
}
