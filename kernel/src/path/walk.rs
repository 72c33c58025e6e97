//! Random walks from the sensor and from emitters.
//!
//! A walk is followed ray by ray: [`Walk::arrive`] where a surface is met, then [`Walk::scatter`], which samples the
//! material as it is and updates what the weights of strategies need ([`super::weight`]). Camera walks carry radiance
//! (refraction divides it by eta^2), light walks flux; a smooth light walk's throughput is found by evaluating the function
//! that a camera walk would have evaluated (see [`super::evaluation`]), a discrete one's by the sampled weight, times eta^2,
//! which undoes the scaling of radiance, and the cosine ratio |wi.n| |wo.n_g| / (|wi.n_g| |wo.n|) with n the lobe's own
//! normal (Veach 1997, section 5.3.2). A normal or bump map's frame that is mirrored towards the known direction may be
//! another seen from the other side of a discrete event: then walks pass it one way only, camera walks without competitors.
//!
//! Densities at the ends: the first surface point of a camera walk has the density of one ray per pixel of the window, evenly
//! over its area, whatever the filter; that of a light walk comes from [`crate::scene::emitter::emission`], and the strategy
//! with one light vertex competes with the density of next event estimation, which is another.

use super::evaluation::Interaction;
use super::rules::{MAX_SURVIVAL, PathRules, step};
use super::strategies::Strategies;
use super::visibility::{MAX_NULL_CROSSINGS, has_masks, pass_through};
use super::weight::{Heuristic, PartialWeights};
use crate::bsdf::{BsdfSample, event, lobe, mode, null_transmittance};
use crate::math::{Ray, Rgb, float, vec3};
use crate::sampler::Sampler;
use crate::scene::emitter::emission;
use crate::scene::emitter::emission::{EmissionSample, is_delta, is_infinite, light_cosine};
use crate::scene::surface::{detail, surface_with};
use crate::scene::{Hit, NONE, SurfacePoint, Tables, camera};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// The moving end of a subpath.
#[derive(Clone, Copy, Debug)]
pub struct Walk {
    /// The ray that is followed next.
    pub ray: Ray,
    /// From the sensor: radiance along the first ray per radiance along this one. From an emitter: what the ray carries.
    pub throughput: Rgb,
    /// Product of relative indices along the walk.
    pub eta: f32,
    /// Largest channel of the throughput at the start.
    pub initial: f32,
    /// Where it scattered last, or its start.
    pub position: Vec3,
    /// Edges so far.
    pub depth: u32,
    /// Surfaces passed straight through.
    pub crossings: u32,
    /// One of [`mode`]: radiance from the sensor, importance from an emitter.
    pub mode: u32,
    /// What the weights need of it, up to where it scattered last and the direction that it took.
    pub weights: PartialWeights,
    /// The same up to the surface where it has arrived.
    pub arrived: PartialWeights,
    /// Emitter on which it started, [`NONE`] at the sensor.
    pub emitter: u32,
    /// The point of an area light on which it started.
    pub start: Hit,
}

/// Where a walk stands after it arrived: what connections look up again.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct PathVertex {
    /// Start of the ray that reached it.
    pub origin: [f32; 3],
    /// Direction of that ray.
    pub direction: [f32; 3],
    /// What it met.
    pub hit: Hit,
    /// The walk's throughput on arrival.
    pub throughput: [f32; 3],
    /// See [`PartialWeights::d_vcm`].
    pub d_vcm: f32,
    /// See [`PartialWeights::d_vc`].
    pub d_vc: f32,
    /// Edges from the subpath's start.
    pub depth: u32,
    /// The connectable vertex before it on the same subpath, as the owner of the vertices counts them; [`NONE`] for none.
    pub previous: u32,
    /// The surface point's position.
    pub position: [f32; 3],
    /// Its shading normal, on the side from which the walk came, where no light passes the surface; zero where some may.
    pub facing: [f32; 3],
}

impl PathVertex {
    /// The surface point.
    #[inline]
    pub fn point(&self, tables: &Tables<'_>) -> SurfacePoint {
        let ray = Ray::new(vec3(self.origin), vec3(self.direction));
        surface_with::<{ detail::TANGENTS }>(tables, &ray, &self.hit)
    }

    /// The gathered sums.
    #[inline]
    pub fn weights(&self) -> PartialWeights {
        PartialWeights {
            d_vcm: self.d_vcm,
            d_vc: self.d_vc,
        }
    }
}

impl Walk {
    /// A walk that has not left the sensor.
    #[inline]
    pub fn from_sensor(ray: &Ray) -> Walk {
        Walk {
            ray: *ray,
            throughput: Vec3::ONE,
            eta: 1.0,
            initial: 1.0,
            position: ray.origin,
            depth: 0,
            crossings: 0,
            mode: mode::RADIANCE,
            weights: PartialWeights::NONE,
            arrived: PartialWeights::NONE,
            emitter: NONE,
            start: Hit::MISS,
        }
    }

    /// A walk along a ray that leaves an emitter.
    #[inline]
    pub fn from_emitter(sample: &EmissionSample) -> Walk {
        let point = &sample.point;
        Walk {
            ray: sample.ray,
            throughput: sample.weight,
            eta: 1.0,
            initial: sample.weight.max_element(),
            position: point.position,
            depth: 0,
            crossings: 0,
            mode: mode::IMPORTANCE,
            weights: PartialWeights::NONE,
            arrived: PartialWeights::NONE,
            emitter: sample.emitter,
            start: start_hit(point),
        }
    }

    /// Moves on to a surface that its ray met: the weights' share of the edge. Where the walk then passes
    /// straight through, nothing has changed.
    pub fn arrive(
        &mut self,
        tables: &Tables<'_>,
        rules: &PathRules,
        strategies: &Strategies,
        point: &SurfacePoint,
    ) {
        let h = strategies.heuristic;
        let cosine = float::abs(point.geometric_normal.dot(self.ray.direction));
        let distance2 = (point.position - self.position).length_squared();
        if self.depth > 0 {
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
        let pdf = camera::pdf_perpendicular_area(tables, point.position, distance) * cosine;
        if !(pdf > 0.0) {
            return PartialWeights::NONE;
        }
        let cos_lens = float::abs(camera::optical_axis(&tables.camera).dot(self.ray.direction));
        PartialWeights {
            d_vcm: h.of(1.0 / pdf),
            d_vc: if lens > 0.0 {
                h.of(cos_lens / (distance2 * lens * pdf))
            } else {
                0.0
            },
        }
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
        let direction = self.ray.direction;
        let emitted = emission::density(tables, self.emitter, &start, direction).product();
        let light = light_cosine(tables, self.emitter, &start, direction, distance2);
        let pdf = emitted * cosine;
        if !(pdf > 0.0) {
            return PartialWeights::NONE;
        }
        let direct = strategies.pdf_direct(tables, self.emitter, point.position, &start, direction);
        PartialWeights {
            d_vcm: h.of(direct * (light / pdf)),
            d_vc: if is_delta(kind) {
                0.0
            } else {
                h.of(light / pdf)
            },
        }
    }

    /// The point of the emitter on which a light walk started.
    #[inline]
    pub fn start_point(&self, tables: &Tables<'_>) -> SurfacePoint {
        if self.start.is_hit() {
            let ray = Ray::new(self.position, self.ray.direction);
            return surface_with::<{ detail::NORMALS }>(tables, &ray, &self.start);
        }
        SurfacePoint {
            position: self.position,
            ..SurfacePoint::ZERO
        }
    }

    /// Whether the walk stands on its first edge from an emitter at infinity.
    #[inline]
    pub fn comes_from_infinity(&self, tables: &Tables<'_>) -> bool {
        self.mode == mode::IMPORTANCE
            && self.depth == 0
            && is_infinite(tables.emitters[self.emitter as usize].kind)
    }

    /// The vertex at which it has arrived.
    #[inline]
    pub fn vertex(&self, hit: &Hit, at: &Interaction<'_>, previous: u32) -> PathVertex {
        PathVertex {
            position: at.point.position.to_array(),
            facing: at.facing().to_array(),
            origin: self.ray.origin.to_array(),
            direction: self.ray.direction.to_array(),
            hit: *hit,
            throughput: self.throughput.to_array(),
            d_vcm: self.arrived.d_vcm,
            d_vc: self.arrived.d_vc,
            depth: self.depth + 1,
            previous,
        }
    }

    /// Goes straight on through the surface; says what is next, one of [`step`].
    #[inline]
    pub fn pass(&mut self, point: &SurfacePoint) -> u32 {
        self.crossings += 1;
        if self.crossings > MAX_NULL_CROSSINGS {
            return step::END;
        }
        pass_through(&mut self.ray, point);
        step::TRACE
    }

    /// On the last edge: goes straight on with what the surface's masks let pass, because they do not count as vertices. Says
    /// what is next, one of [`step`].
    #[inline]
    pub fn pass_masks(&mut self, tables: &Tables<'_>, point: &SurfacePoint) -> u32 {
        if !has_masks(tables, point) {
            return step::END;
        }
        self.throughput *= null_transmittance(tables, point);
        if self.throughput.max_element() > 0.0 {
            self.pass(point)
        } else {
            step::END
        }
    }

    /// Leaves the surface along a direction that its material samples; says whether the walk goes on, one of [`step`].
    pub fn scatter<S: Sampler>(
        &mut self,
        tables: &Tables<'_>,
        rules: &PathRules,
        h: Heuristic,
        sampler: &mut S,
        at: &Interaction<'_>,
    ) -> u32 {
        let u1 = sampler.next_1d();
        let u2 = sampler.next_2d();
        let (sample, chosen) = at.bsdf.sample_lobe(tables.data, at.wi, u1, u2);
        let sample = at.bsdf.mix(tables.data, at.wi, sample, chosen);
        if sample.pdf <= 0.0 {
            return step::END;
        }
        let point = at.point;
        if sample.event & event::NULL != 0 {
            self.throughput *= sample.weight;
            return if self.throughput.max_element() > 0.0 {
                self.pass(point)
            } else {
                step::END
            };
        }
        let direction = point.frame.to_world(sample.wo).normalize();
        if !rules.allows(point, direction, sample.wo.z) {
            return step::END;
        }
        let cosine = float::abs(point.geometric_normal.dot(direction));
        let factor = if sample.event & event::DELTA != 0 {
            let is_reversible = at.bsdf.has_same_frame(tables, point, chosen, sample.wo);
            self.weights = if is_reversible {
                self.arrived.scatter_delta(h, cosine)
            } else {
                // No walk comes the other way.
                PartialWeights::NONE
            };
            if self.mode == mode::IMPORTANCE && !is_reversible {
                return step::END;
            }
            sample.weight * self.delta_factor(tables, at, &sample, chosen, direction)
        } else {
            let is_light_walk = self.mode == mode::IMPORTANCE;
            let both = at
                .bsdf
                .eval_cosine_pdf_both(tables, point, at.wi, sample.wo, is_light_walk);
            self.weights = self
                .arrived
                .scatter(h, sample.pdf, both.pdf_reverse, cosine);
            if is_light_walk {
                both.value * (at.adjoint_ratio(direction) / sample.pdf)
            } else {
                sample.weight
            }
        };
        self.throughput *= factor;
        if !(self.throughput.max_element() > 0.0) || !self.throughput.is_finite() {
            return step::END;
        }
        self.eta *= sample.eta;
        self.position = point.position;
        self.depth += 1;
        if self.depth >= rules.rr_depth {
            let survival = self.survival();
            if sampler.next_1d() >= survival {
                return step::END;
            }
            self.throughput /= survival;
        }
        self.ray = point.spawn(direction);
        if self.depth < rules.max_depth {
            step::TRACE
        } else {
            step::END
        }
    }

    /// Probability of going on.
    #[inline]
    fn survival(&self) -> f32 {
        let strength = self.throughput.max_element();
        if self.mode == mode::RADIANCE {
            (strength * self.eta * self.eta).min(MAX_SURVIVAL)
        } else {
            (strength / self.initial).min(MAX_SURVIVAL)
        }
    }

    /// What the weight of a discrete sample is multiplied by: one for radiance.
    #[inline]
    fn delta_factor(
        &self,
        tables: &Tables<'_>,
        at: &Interaction<'_>,
        sample: &BsdfSample,
        chosen: u32,
        direction: Vec3,
    ) -> f32 {
        if self.mode == mode::RADIANCE {
            return 1.0;
        }
        let lobe = at.bsdf.lobe(chosen);
        let ratio = lobe::exchange_ratio(&lobe, tables.data, at.wi, sample.wo);
        ratio * at.adjoint_ratio(direction) * sample.eta * sample.eta
    }
}

/// The hit that finds a point of an area light again.
#[inline]
fn start_hit(point: &SurfacePoint) -> Hit {
    if point.emitter == NONE {
        return Hit::MISS;
    }
    Hit {
        t: 0.0,
        b1: point.barycentric.x,
        b2: point.barycentric.y,
        primitive: point.primitive,
        instance: point.instance,
    }
}
