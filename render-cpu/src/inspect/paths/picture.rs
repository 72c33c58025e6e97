//! Path bundles as arrows over the image of a scene (Kaplanyan 2017, section 9.1.2, figure 9.2).
//!
//! An arrow goes along the path that stands for a bundle, from the light to the last surface before the sensor. Its area of
//! cross section grows with the bundle's weight, its colour tells the cluster; what surfaces hide from the sensor is faint.

use super::super::record_file::PathRecord;
use super::Places;
use super::bundle::Bundle;
use super::stroke::Sheet;
use crate::image::png_output::{Exposure, tone_map};
use crate::plot::canvas::{Canvas, DrawError, text_style};
use glam::{Vec2, Vec3};
use halflight_kernel::math::Ray;
use halflight_kernel::scene::camera::film_position;
use halflight_kernel::scene::{SceneView, Traverse};
use plotters::prelude::{Rectangle, Text};
use plotters::style::{Color, RGBColor};

/// Width of the legend in pixels.
const LEGEND: u32 = 300;
/// Pieces into which a segment is divided, each seen or hidden as its middle is.
const PIECES: usize = 64;
/// Colours of clusters, the heaviest first, that red-green blindness leaves apart (Okabe and Ito 2008, on a dark ground); one for
/// all others.
pub const COLORS: [[u8; 3]; 8] = [
    [255, 176, 32],
    [86, 180, 233],
    [64, 200, 150],
    [240, 228, 90],
    [226, 106, 60],
    [214, 135, 190],
    [120, 140, 255],
    [190, 190, 190],
];

/// Bundles of one cluster, and what it is called.
#[derive(Clone, Debug)]
pub struct Group {
    /// Its vertices, from the light.
    pub label: String,
    /// Weight of all its paths.
    pub weight: f64,
    /// Its bundles.
    pub bundles: Vec<Bundle>,
}

/// Draws the bundles of groups, the heaviest group first, over the image of the sensor's window.
///
/// # Errors
/// If the drawing library fails.
pub fn draw<T: Traverse>(
    view: &SceneView<'_, T>,
    mean: &[[f64; 3]],
    record: &PathRecord,
    places: &Places,
    groups: &[Group],
) -> Result<Canvas, DrawError> {
    let camera = &view.tables.camera;
    let [width, height] = camera.crop_size;
    let zoom = (480 / width.max(1)).clamp(1, 16);
    let size = [width * zoom, height * zoom];
    let pixels = darkened(&tone_map(mean, Exposure::Stops(0.0)));
    let mut rgb = Vec::with_capacity(3 * (size[0] * size[1]) as usize);
    for y in 0..size[1] {
        for x in 0..size[0] {
            let at = 3 * ((y / zoom) * width + x / zoom) as usize;
            rgb.extend(&pixels[at..at + 3]);
        }
    }
    let mut sheet = Sheet {
        size,
        rgb: &mut rgb,
    };
    let heaviest = groups
        .iter()
        .flat_map(|g| &g.bundles)
        .map(|b| b.weight)
        .fold(0.0, f64::max);
    let mut all: Vec<(usize, &Bundle)> = (groups.iter().enumerate())
        .flat_map(|(i, g)| g.bundles.iter().map(move |b| (i, b)))
        .collect();
    // The heaviest on top.
    all.sort_by(|a, b| a.1.weight.total_cmp(&b.1.weight));
    for (group, bundle) in all {
        let share = if heaviest > 0.0 {
            bundle.weight / heaviest
        } else {
            0.0
        };
        let thickness = 1.2 + 5.0 * share.sqrt() as f32;
        let mut points = places.paths[bundle.representative as usize].clone();
        points.remove(0);
        points.reverse();
        arrow(
            view,
            &mut sheet,
            &points,
            zoom as f32,
            thickness,
            color(group),
        );
    }
    let total: f64 = record.paths.iter().map(|p| f64::from(p.weight)).sum();
    let mut canvas = Canvas::new(size[0] + LEGEND, size[1].max(160));
    canvas.paste(&rgb, size, 0, 0);
    legend(&mut canvas, size[0], groups, total)?;
    Ok(canvas)
}

fn color(group: usize) -> [u8; 3] {
    COLORS[group.min(COLORS.len() - 1)]
}

/// Half grey and half as light, so that arrows stand out.
fn darkened(rgb: &[u8]) -> Vec<u8> {
    let of_pixel = |p: &[u8; 3]| {
        let [r, g, b] = p.map(f32::from);
        let grey = 0.2126 * r + 0.7152 * g + 0.0722 * b;
        [r, g, b].map(|v| (0.55 * (0.5 * v + 0.5 * grey)).round() as u8)
    };
    rgb.as_chunks::<3>().0.iter().flat_map(of_pixel).collect()
}

/// Draws along `points`, with a head at each.
fn arrow<T: Traverse>(
    view: &SceneView<'_, T>,
    sheet: &mut Sheet<'_>,
    points: &[Vec3],
    zoom: f32,
    thickness: f32,
    color: [u8; 3],
) {
    let offset = Vec2::from_array(view.tables.camera.crop_offset.map(|v| v as f32));
    let project = |p: Vec3| {
        let seen = film_position(&view.tables, p, Vec2::splat(0.5));
        (seen.distance > 0.0).then(|| (seen.film - offset) * zoom)
    };
    let wide = sheet.size[0] as f32;
    for pair in points.windows(2) {
        let position_at = |t: f32| pair[0].lerp(pair[1], t);
        let mut last: Option<(Vec2, Vec2, f32)> = None;
        for i in 0..PIECES {
            let [t0, t1] = [i, i + 1].map(|i| i as f32 / PIECES as f32);
            let (Some(a), Some(b)) = (project(position_at(t0)), project(position_at(t1))) else {
                continue;
            };
            // A panorama's seam is no line.
            if !(a - b).is_finite() || (a - b).length() > 0.5 * wide {
                continue;
            }
            let opacity = if is_hidden(view, position_at(0.5 * (t0 + t1))) {
                0.25
            } else {
                0.9
            };
            sheet.line(a, b, thickness, color, opacity);
            last = Some((a, b, opacity));
        }
        if let (Some((a, b, opacity)), Some(tip)) = (last, project(pair[1])) {
            let direction = if (b - a).length() > 1e-3 {
                b - a
            } else {
                tip - a
            };
            sheet.head(tip, direction, 7.0 + 2.0 * thickness, color, opacity);
        }
    }
}

/// Whether a surface lies between a point and the middle of the lens.
fn is_hidden<T: Traverse>(view: &SceneView<'_, T>, point: Vec3) -> bool {
    let seen = film_position(&view.tables, point, Vec2::splat(0.5));
    let distance = seen.unclipped;
    let ray = Ray {
        t_min: 1e-3 * distance,
        t_max: distance,
        ..Ray::new(point, seen.direction)
    };
    view.traverse.is_occluded(&ray)
}

/// The clusters with their shares of the light.
fn legend(canvas: &mut Canvas, x: u32, groups: &[Group], total: f64) -> Result<(), DrawError> {
    let height = canvas.size()[1] as i32;
    let left = x as i32 + 14;
    canvas.draw(|area| {
        let title = "share of the recorded light";
        area.draw(&Text::new(title, (left, 8), text_style(14)))?;
        for (i, group) in groups.iter().enumerate() {
            let y = 36 + 22 * i as i32;
            if y + 44 > height && i + 1 < groups.len() {
                let rest: f64 = groups[i..].iter().map(|g| g.weight).sum();
                let text = format!("{} more, {:.1} %", groups.len() - i, 100.0 * rest / total);
                area.draw(&Text::new(text, (left + 22, y - 2), text_style(13)))?;
                break;
            }
            let [r, g, b] = color(i);
            let swatch =
                Rectangle::new([(left, y), (left + 14, y + 10)], RGBColor(r, g, b).filled());
            area.draw(&swatch)?;
            let share = 100.0 * group.weight / total;
            let mut label: String = group.label.chars().take(32).collect();
            if label.len() < group.label.len() {
                label.push('…');
            }
            let text = format!("{share:.1} %  {label}");
            area.draw(&Text::new(text, (left + 22, y - 2), text_style(13)))?;
        }
        Ok(())
    })
}
