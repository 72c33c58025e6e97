//! Which sampling strategies (s, t) exist, how they are weighted, and which of them an image shows.
//!
//! A strategy enters the sum of the weights exactly when it can sample the path. The settings that switch strategies off
//! therefore stand here, where every computation of a weight looks them up.

use super::rules::PathRules;
use super::weight::{Heuristic, weight};
use crate::scene::emitter;
use crate::scene::emitter::emission::{self, light_cosine};
use crate::scene::{NONE, SurfacePoint, Tables, camera, emitter_kind};
use glam::Vec3;

/// The set of strategies, their heuristic, and the selection that an image shows.
#[derive(Clone, Copy, Debug)]
pub struct Strategies {
    /// The heuristic.
    pub heuristic: Heuristic,
    /// Whether the strategies with t < 2 exist, which splat light walks onto the film.
    pub light_image: bool,
    /// Whether s = 1 samples an emitter for the illuminated point; otherwise it takes the start of the light walk.
    pub sample_direct: bool,
    /// The only number s of light vertices that is shown, [`NONE`] for all.
    pub only_s: u32,
    /// The only number t of camera vertices that is shown, [`NONE`] for all.
    pub only_t: u32,
    /// Whether all weights are one, to show a strategy as it is.
    pub unweighted: bool,
    /// Whether light walks meet a lens of finite aperture (t = 0), if there is a light image.
    pub meets_lens: bool,
}

impl Strategies {
    /// Whether the strategy (s, t) is shown.
    #[inline]
    pub fn shows(&self, s: u32, t: u32) -> bool {
        (self.only_s == NONE || self.only_s == s) && (self.only_t == NONE || self.only_t == t)
    }

    /// Whether no single strategy is shown.
    #[inline]
    pub fn shows_all(&self) -> bool {
        self.only_s == NONE && self.only_t == NONE
    }

    /// The weight of a strategy, given the sums over strategies with a shorter light and with a shorter camera subpath.
    #[inline]
    pub fn weight(&self, light: f32, camera: f32) -> f32 {
        if self.unweighted {
            1.0
        } else {
            weight(light, camera)
        }
    }

    /// Density per area of sampled lens points; zero if hitting the lens (t = 0) is no strategy.
    #[inline]
    pub fn pdf_lens(&self, tables: &Tables<'_>, rules: &PathRules) -> f32 {
        // With hidden emitters the edge to the lens would have to pass through emitters, which the walk's ray does not.
        if self.light_image && self.meets_lens && rules.hide_emitters == 0 {
            camera::pdf_lens_area(&tables.camera)
        } else {
            0.0
        }
    }

    /// The density with which the strategy s = 1 samples a point or direction of an emitter, in the measure of
    /// [`crate::scene::emitter::DirectSample::pdf`] for a surface at `reference`.
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
