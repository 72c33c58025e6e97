//! The partial sums of the weights where a walk meets a surface ([`super::weight`]), and how they start at the sensor and at an emitter.

use super::rules::PathRules;
use super::specular_chain::{SpecularChain, state};
use super::strategies::Strategies;
use super::walk::Walk;
use super::weight::{Heuristic, PartialWeights};
use crate::bsdf::mode;
use crate::math::float;
use crate::scene::emitter::emission::{self, is_delta, is_infinite, light_cosine};
use crate::scene::{SurfacePoint, Tables, camera};
#[cfg(not(target_arch = "spirv"))]
use crate::scene::{camera_kind, irradiance_meter};

impl Walk {
    /// Updates the partial sums for the edge to the surface that the ray has hit. They are kept apart from those of the last
    /// vertex, so that null scattering at this surface leaves the walk as it was.
    pub fn update_weights(
        &mut self,
        tables: &Tables<'_>,
        rules: &PathRules,
        strategies: &Strategies,
        point: &SurfacePoint,
    ) {
        let h = strategies.heuristic;
        let cosine = float::abs(point.geometric_normal.dot(self.subpath.ray.direction));
        let distance2 = (point.position - self.subpath.position).length_squared();
        self.arrived_chain = if self.subpath.depth > 0 {
            SpecularChain {
                edge: distance2,
                ..self.chain
            }
        } else {
            self.first_chain(tables, rules, strategies, distance2)
        };
        if self.subpath.depth > 0 {
            self.arrived = self.weights.arrive(h, distance2, cosine);
        } else if self.mode == mode::RADIANCE {
            if strategies.light_image {
                let lens = strategies.pdf_lens(tables, rules);
                self.arrived = self.first_from_sensor(tables, h, lens, point, cosine, distance2);
            }
        } else {
            self.arrived = self.first_from_emitter(tables, strategies, point, cosine, distance2);
        }
    }

    /// The start of [`Walk::arrived_chain`], where the first edge has the squared length `distance2`.
    fn first_chain(
        &self,
        tables: &Tables<'_>,
        rules: &PathRules,
        strategies: &Strategies,
        distance2: f32,
    ) -> SpecularChain {
        let mut start = if strategies.heuristic.merging > 0.0 {
            state::MERGES
        } else {
            0
        };
        let mut edge = distance2;
        if self.mode == mode::RADIANCE {
            if strategies.light_image {
                start |= state::IS_ROUGH;
            }
            if strategies.pdf_lens(tables, rules) > 0.0 {
                start |= state::SAMPLED;
            }
        } else {
            let kind = tables.emitters[self.emitter as usize].kind;
            start |= if is_delta(kind) {
                state::IS_ROUGH
            } else {
                state::SAMPLED
            };
            if is_infinite(kind) {
                edge = float::sqr(tables.info.radius);
            }
        }
        SpecularChain::start(start, edge)
    }

    fn first_from_sensor(
        &self,
        tables: &Tables<'_>,
        h: Heuristic,
        lens: f32,
        point: &SurfacePoint,
        cosine: f32,
        distance2: f32,
    ) -> PartialWeights {
        let distance = float::sqrt(distance2);
        let pdf = self.pdf_first(tables, point, distance) * cosine;
        if !(pdf > 0.0) {
            return PartialWeights::NONE;
        }
        let cos_lens =
            float::abs(camera::optical_axis(&tables.camera).dot(self.subpath.ray.direction));
        PartialWeights {
            d_vcm: h.of(1.0 / pdf),
            d_vc: if lens > 0.0 {
                h.of(cos_lens / (distance2 * lens * pdf))
            } else {
                0.0
            },
        }
    }

    /// Density per perpendicular area of the first surface point of a camera walk.
    #[inline]
    pub(crate) fn pdf_first(
        &self,
        tables: &Tables<'_>,
        point: &SurfacePoint,
        distance: f32,
    ) -> f32 {
        #[cfg(not(target_arch = "spirv"))]
        if tables.camera.kind == camera_kind::IRRADIANCE_METER {
            return irradiance_meter::pdf_perpendicular_area(self.initial, distance)
                * camera::pixels_per_window_pixel(&tables.camera);
        }
        camera::pdf_perpendicular_area(tables, point.position, distance)
    }

    fn first_from_emitter(
        &self,
        tables: &Tables<'_>,
        strategies: &Strategies,
        point: &SurfacePoint,
        cosine: f32,
        distance2: f32,
    ) -> PartialWeights {
        let h = strategies.heuristic;
        let kind = tables.emitters[self.emitter as usize].kind;
        let start = self.start_point(tables);
        let direction = self.subpath.ray.direction;
        let emitted = emission::density(tables, self.emitter, &start, direction).product();
        let light = light_cosine(tables, self.emitter, &start, direction, distance2);
        let pdf = emitted * cosine;
        if !(pdf > 0.0) {
            return PartialWeights::NONE;
        }
        let direct = strategies.pdf_direct(tables, self.emitter, point.position, &start, direction);
        PartialWeights {
            d_vcm: h.of_connection(direct * (light / pdf)),
            d_vc: if is_delta(kind) {
                0.0
            } else {
                h.of(light / pdf)
            },
        }
    }
}
