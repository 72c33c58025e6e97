//! The radiance that arrives at a point from all around, as a surface whose distance from the point is the radiance
//! (Kaplanyan 2017, section 9.1.2): a free probe sees the whole sphere, one on a surface the half above it.
//!
//! Directions are cells of latitude and longitude of equal solid angle around an axis, z or the surface's normal; each holds the
//! mean of samples over its solid angle. The picture is an orthographic view of the surface, coloured by radiance.

use super::false_color::numbers;
use super::legend::{ColorScale, WIDTH};
use crate::film::luminance;
use crate::plot::canvas::{Canvas, DrawError, text_style};
use glam::{DMat3, DVec3, Vec3};
use halflight_kernel::math::{Frame, Ray};
use halflight_kernel::path::PathExpressions;
use halflight_kernel::sampler::{IndependentSampler, Sampler};
use halflight_kernel::scene::surface::{detail, surface_with};
use halflight_kernel::scene::{SceneView, Traverse};
use halflight_kernel::transport::divided::divided_radiance;
use halflight_kernel::transport::{IntegratorSettings, camera_ray, path};
use plotters::prelude::{PathElement, Text};
use plotters::style::{Color, RGBColor};
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use std::f64::consts::PI;

/// Where the radiance is measured.
#[derive(Clone, Copy, Debug)]
pub struct Probe {
    /// Rays begin here.
    pub position: Vec3,
    /// The axis of its directions is `n`.
    pub frame: Frame,
    /// Whether it lies on a surface and sees the side of `n` alone.
    pub is_on_surface: bool,
}

impl Probe {
    /// In free space.
    pub fn free(position: Vec3) -> Probe {
        Probe {
            position,
            frame: Frame::LOCAL,
            is_on_surface: false,
        }
    }

    /// On the surface that the middle of a pixel of the whole film sees; none if it sees none.
    pub fn of_pixel<T: Traverse>(view: &SceneView<'_, T>, pixel: [u32; 2]) -> Option<Probe> {
        let seen = camera_ray(&view.tables, &mut CenterSampler, pixel);
        let hit = view.traverse.closest_hit(&seen.ray);
        if !hit.is_hit() {
            return None;
        }
        let point = surface_with::<{ detail::TANGENTS }>(&view.tables, &seen.ray, &hit);
        let towards = -seen.ray.direction;
        let normal = point.geometric_normal;
        let normal = if normal.dot(towards) < 0.0 {
            -normal
        } else {
            normal
        };
        Some(Probe {
            position: point.offset_position(normal),
            frame: Frame::from_normal(normal),
            is_on_surface: true,
        })
    }
}

/// Numbers that choose the middle of everything.
struct CenterSampler;

impl Sampler for CenterSampler {
    fn next_1d(&mut self) -> f32 {
        0.5
    }
}

/// The radiance around a probe.
#[derive(Clone, Debug)]
pub struct SphericalPlot {
    /// Cells from the axis down, and around it.
    pub size: [usize; 2],
    /// Their radiance, by rows.
    pub radiance: Vec<[f64; 3]>,
    /// Cosine with the axis where the last row ends.
    end: f64,
}

impl SphericalPlot {
    /// Measures it with `samples` for each of `rows` times twice as many cells; of the paths alone that the first of
    /// `expressions` matches, if there are any.
    pub fn measure<T: Traverse + Sync>(
        view: &SceneView<'_, T>,
        settings: &IntegratorSettings,
        expressions: Option<&PathExpressions<'_>>,
        probe: &Probe,
        rows: usize,
        samples: u32,
        seed: u32,
    ) -> SphericalPlot {
        let mut plot = SphericalPlot {
            size: [rows, 2 * rows],
            radiance: Vec::new(),
            end: if probe.is_on_surface { 0.0 } else { -1.0 },
        };
        let cells = rows * 2 * rows;
        plot.radiance = (0..cells)
            .into_par_iter()
            .map(|cell| {
                let mut sum = [0.0; 3];
                for sample in 0..samples {
                    let mut sampler = IndependentSampler::new(seed, cell as u32, sample);
                    let u = [f64::from(sampler.next_1d()), f64::from(sampler.next_1d())];
                    let direction = plot.direction(cell, u).as_vec3();
                    let direction = probe.frame.to_world(direction).normalize();
                    let ray = Ray::new(probe.position, direction);
                    let found = match expressions {
                        None => path::radiance(view, settings, &mut sampler, &ray),
                        Some(expressions) => {
                            let mut parts = vec![Vec3::ZERO; expressions.count as usize];
                            divided_radiance(
                                view,
                                settings,
                                expressions,
                                &mut sampler,
                                &ray,
                                &mut parts,
                            );
                            parts[0]
                        }
                    };
                    let found = numbers(found);
                    (0..3).for_each(|c| sum[c] += found[c] / f64::from(samples));
                }
                sum
            })
            .collect();
        plot
    }

    /// The direction at a position in a cell, in the probe's frame.
    pub fn direction(&self, cell: usize, [u, v]: [f64; 2]) -> DVec3 {
        let [rows, columns] = self.size;
        let row = (cell / columns) as f64 + u;
        let cosine = 1.0 + (self.end - 1.0) * row / rows as f64;
        let angle = 2.0 * PI * ((cell % columns) as f64 + v) / columns as f64;
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        DVec3::new(sine * angle.cos(), sine * angle.sin(), cosine)
    }

    /// Irradiance, or for a free probe the integral of radiance over all directions, of luminance.
    pub fn integral(&self) -> f64 {
        let cell = 2.0 * PI * (1.0 - self.end) / self.radiance.len() as f64;
        let weight = |i: usize| {
            if self.end == 0.0 {
                self.direction(i, [0.5, 0.5]).z
            } else {
                1.0
            }
        };
        let all = self.radiance.iter().enumerate();
        all.map(|(i, v)| luminance(*v) * weight(i) * cell).sum()
    }

    /// Draws it, `size` pixels high, seen from a direction in the probe's frame. Radiance `scale.most` is at the rim.
    ///
    /// # Errors
    /// If the drawing library fails.
    pub fn draw(
        &self,
        scale: ColorScale,
        size: u32,
        from: DVec3,
        title: &str,
    ) -> Result<Canvas, DrawError> {
        let mut canvas = Canvas::new(size + WIDTH, size);
        let forward = from.normalize();
        let up = if forward.z.abs() > 0.99 {
            DVec3::Y
        } else {
            DVec3::Z
        };
        let right = up.cross(forward).normalize();
        let to_view = DMat3::from_cols(right, forward.cross(right), forward).transpose();
        let middle = f64::from(size) / 2.0;
        let reach = middle - 46.0;
        let position = |p: DVec3| {
            let q = to_view * p;
            DVec3::new(middle + reach * q.x, middle - reach * q.y, q.z)
        };
        let mut raster = Raster::new(size);
        for cell in 0..self.radiance.len() {
            let corners = [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]];
            let corners = corners.map(|at| {
                let value = self.smooth(cell, at);
                position(self.direction(cell, at) * scale.position(value))
            });
            let color = scale.color(luminance(self.radiance[cell]));
            raster.fill([corners[0], corners[1], corners[2]], color);
            raster.fill([corners[0], corners[2], corners[3]], color);
        }
        canvas.paste(&raster.rgb, [size, size], 0, 0);
        canvas.draw(|area| {
            area.draw(&Text::new(title.to_owned(), (10, 8), text_style(14)))?;
            let axes = [
                (DVec3::X, "x", RGBColor(200, 40, 40)),
                (DVec3::Y, "y", RGBColor(40, 140, 40)),
                (DVec3::Z, "z", RGBColor(40, 60, 200)),
            ];
            let named_normal = self.end == 0.0;
            for (axis, name, color) in axes {
                let name = if named_normal && name == "z" {
                    "n"
                } else {
                    name
                };
                let at = |p: DVec3| (p.x.round() as i32, p.y.round() as i32);
                let ends = vec![at(position(DVec3::ZERO)), at(position(axis * 1.08))];
                area.draw(&PathElement::new(ends, color.mix(0.8).stroke_width(1)))?;
                let label = at(position(axis * 1.14));
                area.draw(&Text::new(name, (label.0 - 4, label.1 - 7), text_style(13)))?;
            }
            Ok(())
        })?;
        scale.draw(&mut canvas, size, "radiance, W/(m² sr)")?;
        Ok(canvas)
    }

    /// Luminance at a corner of a cell: the mean of the cells around.
    fn smooth(&self, cell: usize, [u, v]: [f64; 2]) -> f64 {
        let [rows, columns] = self.size;
        let (row, column) = (cell / columns + u as usize, cell % columns + v as usize);
        let (mut sum, mut count) = (0.0, 0.0);
        for (r, is_there) in [(row.wrapping_sub(1), row > 0), (row, row < rows)] {
            if !is_there {
                continue;
            }
            // Around a pole all cells of the row meet.
            let at_pole = row == 0 || (row == rows && self.end < 0.0);
            let columns_there = if at_pole {
                0..columns
            } else {
                column + columns - 1..column + columns + 1
            };
            for c in columns_there {
                sum += luminance(self.radiance[r * columns + c % columns]);
                count += 1.0;
            }
        }
        if count > 0.0 { sum / count } else { 0.0 }
    }
}

/// Triangles with a depth for each pixel, white where there are none.
struct Raster {
    size: u32,
    rgb: Vec<u8>,
    depth: Vec<f64>,
}

impl Raster {
    fn new(size: u32) -> Raster {
        let pixels = size as usize * size as usize;
        Raster {
            size,
            rgb: vec![255; 3 * pixels],
            depth: vec![f64::MIN; pixels],
        }
    }

    /// Fills a triangle, shaded by how it faces the viewer.
    fn fill(&mut self, [a, b, c]: [DVec3; 3], color: [u8; 3]) {
        let normal = (b - a).cross(c - a);
        let length = normal.length();
        if !(length > 0.0) {
            return;
        }
        let area = normal.z;
        // Depth counts in pixels as well, to tell a face that is seen from the side.
        let facing = (area / length).abs().clamp(0.0, 1.0);
        let shade = 0.72 + 0.28 * facing;
        let last = f64::from(self.size) - 1.0;
        let range = |v: [f64; 3]| {
            let low = v.into_iter().fold(f64::MAX, f64::min).max(0.0).floor();
            let high = v.into_iter().fold(f64::MIN, f64::max).min(last).ceil();
            (low as u32, high as u32)
        };
        let ((x0, x1), (y0, y1)) = (range([a.x, b.x, c.x]), range([a.y, b.y, c.y]));
        if area == 0.0 || x1 < x0 || y1 < y0 {
            return;
        }
        for y in y0..=y1.min(self.size - 1) {
            for x in x0..=x1.min(self.size - 1) {
                let (px, py) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
                let edge = |p: DVec3, q: DVec3| (q.x - p.x) * (py - p.y) - (q.y - p.y) * (px - p.x);
                let weights = [edge(b, c) / area, edge(c, a) / area, edge(a, b) / area];
                // A little beyond the edges, so that no gap is left between neighbours.
                if weights.iter().any(|w| *w < -1e-6) {
                    continue;
                }
                let depth = weights[0] * a.z + weights[1] * b.z + weights[2] * c.z;
                let at = (y * self.size + x) as usize;
                if depth > self.depth[at] {
                    self.depth[at] = depth;
                    let shaded = color.map(|v| (f64::from(v) * shade).round() as u8);
                    self.rgb[3 * at..3 * at + 3].copy_from_slice(&shaded);
                }
            }
        }
    }
}
