//! Steps of half vectors: how far, and their densities.
//!
//! The lobes and their widths are those of [`crate::manifold::step_size`]. Where a vertex scatters at all, its step has two
//! dimensions: widths are at least `NARROWEST`, so that the forward and the reverse step have densities of the same kind.

use super::super::veach::{ChainPath, MAX_VERTICES};
use super::path_chain::PathChain;
use super::reconnection::Segment;
use super::settings::HalfVectorSettings;
use crate::manifold::chain::ChainJacobian;
use crate::manifold::constraint::half_vector_form;
use crate::manifold::disk_lobe::DiskLobe;
use crate::manifold::half_vector::slope_of_projected;
use crate::manifold::slope_gaussian::SlopeGaussian;
use crate::manifold::step_size::{
    IMAGE_FRACTION, StepEllipse, disk_proposal, image_step, slope_proposal, spectrum_weights,
    tangent_plane_offset,
};
use crate::manifold::vertex::{ChainVertex, vertex_kind};
use crate::math::float::ln;
use crate::math::scaled::is_finite2;
use crate::scene::{Tables, camera};
use arrayvec::ArrayVec;
use glam::{Mat2, Vec2};

/// Least deviation of a step.
const NARROWEST: f32 = 1e-6;

/// A step of a half vector, in the coordinates of a form.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    gaussian: SlopeGaussian,
    /// The same as a lobe on the disk, for projected half vectors.
    lobe: Option<DiskLobe>,
}

impl Step {
    fn new(x: &ChainVertex, gaussian: SlopeGaussian, form: u32) -> Step {
        let mut gaussian = gaussian;
        gaussian.deviation = gaussian.deviation.max(Vec2::splat(NARROWEST));
        let is_projected =
            form == half_vector_form::PROJECTED && x.kind != vertex_kind::INDEX_MATCHED;
        Step {
            gaussian,
            lobe: is_projected.then(|| disk_proposal(&gaussian)),
        }
    }

    /// A new half vector.
    pub fn sample(&self, u: Vec2) -> Vec2 {
        match &self.lobe {
            Some(lobe) => lobe.sample(u),
            None => self.gaussian.sample(u),
        }
    }

    /// Logarithm of the density of a new half vector.
    pub fn ln_pdf(&self, h: Vec2) -> f32 {
        match &self.lobe {
            Some(lobe) => ln(lobe.pdf_disk(h).max(1e-37)),
            None => {
                let d = h - self.gaussian.center;
                let axis = self.gaussian.axis;
                let d = Vec2::new(d.dot(axis), axis.perp().dot(d)) / self.gaussian.deviation;
                let s = self.gaussian.deviation;
                -0.5 * d.length_squared() - ln(s.x) - ln(s.y)
            }
        }
    }
}

/// The slope of a half vector in a form.
fn slope(x: &ChainVertex, h: Vec2, form: u32) -> Vec2 {
    if form == half_vector_form::PROJECTED && x.kind != vertex_kind::INDEX_MATCHED {
        slope_of_projected(h)
    } else {
        h
    }
}

/// A step by the width of the lobe alone.
pub fn free_step(x: &ChainVertex, h: Vec2, settings: &HalfVectorSettings) -> Step {
    let slope = slope(x, h, settings.form);
    let gaussian = slope_proposal(x, slope, StepEllipse::UNLIMITED, 1.0, settings.gamma);
    Step::new(x, gaussian, settings.form)
}

/// The steps of the vertices of a path, none at discrete events and where nothing moves.
pub type Steps = ArrayVec<Option<Step>, MAX_VERTICES>;

/// Sets the steps of the inner vertices of a segment that begins at vertex `low`, limited by a step over the image or not, but for
/// discrete events; returns whether all are finite.
pub fn segment_steps<const N: usize>(
    tables: &Tables<'_>,
    path: &ChainPath,
    chain: &PathChain,
    segment: &Segment<N>,
    low: usize,
    is_limited: bool,
    settings: &HalfVectorSettings,
    steps: &mut Steps,
) -> bool {
    let len = segment.count();
    if len < 3 {
        return true;
    }
    let mut weights = [0.0; N];
    spectrum_weights(&segment.vertices, len, &mut weights);
    let mut rows = [Mat2::ZERO; N];
    let mut offsets = [Vec2::ZERO; 2];
    if is_limited {
        // D_i in slopes, in which widths are.
        let is_regular = if settings.form == half_vector_form::SLOPE {
            segment.jacobian.lu.row_of_inverse(len - 2, &mut rows);
            true
        } else {
            let slopes = ChainJacobian::new(&segment.vertices, len, half_vector_form::SLOPE);
            slopes.lu.row_of_inverse(len - 2, &mut rows);
            slopes.is_regular()
        };
        if !is_regular {
            return false;
        }
        offsets = image_offsets(tables, path, &segment.vertices[len - 2]);
    }
    for i in 1..len - 1 {
        if !path.vertices[low + i].is_smooth() {
            continue;
        }
        let x = &chain.vertices[low + i];
        let h = segment.jacobian.h[i];
        let image = if is_limited {
            image_step(rows[i], offsets[0], offsets[1])
        } else {
            StepEllipse::UNLIMITED
        };
        let gaussian = slope_proposal(
            x,
            slope(x, h, settings.form),
            image,
            weights[i],
            settings.gamma,
        );
        if !is_finite2(gaussian.center) || !is_finite2(gaussian.deviation) {
            return false;
        }
        steps[low + i] = Some(Step::new(x, gaussian, settings.form));
    }
    true
}

/// How far the vertex before the sensor moves along both of its tangents with a step over the image to the right and down.
fn image_offsets(tables: &Tables<'_>, path: &ChainPath, seen: &ChainVertex) -> [Vec2; 2] {
    let window = &tables.camera;
    let pixel = [Vec2::ZERO, Vec2::X, Vec2::Y].map(|d| {
        let ray = camera::ray_through(window, path.film + d, path.u_lens);
        tangent_plane_offset(seen, ray.origin, ray.direction)
    });
    let scale = IMAGE_FRACTION * window.crop_size[0].min(window.crop_size[1]) as f32;
    [(pixel[1] - pixel[0]) * scale, (pixel[2] - pixel[0]) * scale]
}
