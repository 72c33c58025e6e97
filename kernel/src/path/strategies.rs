//! Which strategies make paths, how they are weighted, and which are shown.
//!
//! A strategy counts in the sum of weights exactly when it can make the path, so the settings that switch one off are asked
//! here by all who gather weights.

use super::rules::PathRules;
use super::weight::{Heuristic, weight};
use crate::scene::emitter;
use crate::scene::emitter::emission::{self, light_cosine};
use crate::scene::{NONE, SurfacePoint, Tables, camera, emitter_kind};
use glam::Vec3;

/// Which strategies there are, how they are weighted, and which are shown.
#[derive(Clone, Copy, Debug)]
pub struct Strategies {
    /// The heuristic.
    pub heuristic: Heuristic,
    /// Whether light walks are connected to the lens.
    pub light_image: bool,
    /// Whether emitters are sampled for the point that they light, rather than taken from the light walk's start.
    pub sample_direct: bool,
    /// Vertices of the light subpath in the one strategy that is shown, [`NONE`] for all.
    pub only_s: u32,
    /// Vertices of the camera subpath in the one strategy that is shown, [`NONE`] for all.
    pub only_t: u32,
    /// Whether weights are one.
    pub unweighted: bool,
}

impl Strategies {
    /// Whether the strategy is shown.
    #[inline]
    pub fn shows(&self, s: u32, t: u32) -> bool {
        (self.only_s == NONE || self.only_s == s) && (self.only_t == NONE || self.only_t == t)
    }

    /// The weight of a strategy that is shown, given the sums over shorter light and shorter camera subpaths.
    #[inline]
    pub fn weight(&self, light: f32, camera: f32) -> f32 {
        if self.unweighted {
            1.0
        } else {
            weight(light, camera)
        }
    }

    /// Density per area of lens points that light walks may meet; zero where that is no strategy.
    #[inline]
    pub fn pdf_lens(&self, tables: &Tables<'_>, rules: &PathRules) -> f32 {
        // Light for a sensor that does not see emitters would have to pass them on its way.
        if self.light_image && rules.hide_emitters == 0 {
            camera::pdf_lens_area(&tables.camera)
        } else {
            0.0
        }
    }

    /// The density of the point or direction of an emitter in the strategy with one light vertex, as
    /// [`crate::scene::emitter::DirectSample::pdf`] states it for a surface at `reference`.
    pub fn pdf_direct(
        &self,
        tables: &Tables<'_>,
        emitter: u32,
        reference: Vec3,
        point: &SurfacePoint,
        direction: Vec3,
    ) -> f32 {
        let is_area = tables.emitters[emitter as usize].kind == emitter_kind::AREA;
        if self.sample_direct || !is_area {
            return emitter::pdf_direct_of(tables, emitter, reference, point, direction);
        }
        let distance2 = (point.position - reference).length_squared();
        let cosine = light_cosine(tables, emitter, point, direction, distance2);
        if !(cosine > 0.0) {
            return 0.0;
        }
        emission::density(tables, emitter, point, direction).position * distance2 / cosine
    }
}
