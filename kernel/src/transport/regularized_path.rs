//! Path tracing whose next event estimation is regularised, so that it finds light behind specular surfaces.
//!
//! The walk is that of [`super::path`], and so are the stages of a bounce ([`super::bounce`]); what differs happens at the
//! connection to an emitter:
//!
//! - microfacet models (Jendersie and Grosch 2019): the BSDF is evaluated below tau, also where it is specular. The weights of
//!   the two techniques are those of equation 13, where the walk's density is p_hat = (f_hat / f) p,
//!
//! ```text
//! w_e = p_e^2 / (p_e^2 + p_hat^2),   w_b = p_hat^2 / (p_e^2 + p_hat^2);
//! ```
//!
//! - path space (Kaplanyan 2017, section 6.2.4 and algorithm 2): light that no ray meets, arriving at a discrete event, cannot
//!   be sampled; it is connected with the event blurred. Everything else stays unbiased.
//!
//! Heuristics of section 3.5 of Jendersie and Grosch say where: tau of a vertex grows where the walk is still sharp, and paths
//! whose connection to the emitter is a good sampler keep their own BSDF and weights, or a share of them
//! ([`crate::regularize::heuristic::quality_share`]).
//!
//! Virtual merges (section 3.6) replace the rougher model for comparison: the BSDF is sampled once more, and the
//! light counts if the sample lies in the cone of value tau around it.
//!
//! With all lights, every emitter is sampled, not one of them.
//!
//! Invariants (tests): with neither, or at surfaces of which none is shiny, the radiance is that of path tracing to the bit;
//! the mean goes to the truth as tau grows and r shrinks.

use super::bounce::{Rays, Shading, bounce, shade};
use super::connection::ShadowRay;
use super::path::{Path, SinglePath, step};
use super::regularized_share::RegularizedShare;
use super::settings::IntegratorSettings;
use crate::bsdf::{Bsdf, event};
use crate::math::{Ray, Rgb};
use crate::path::spread::{Spread, emitter_quality};
use crate::regularize::bandwidth::TAU_MAX;
#[cfg(not(target_arch = "spirv"))]
use crate::regularize::near_specular::is_near_specular;
use crate::regularize::settings::{Regularization, flag};
use crate::sampler::Sampler;
use crate::scene::emitter::emission::is_infinite;
use crate::scene::emitter::{self};
use crate::scene::surface::{detail, surface_with};
use crate::scene::{NONE, SceneView, Traverse, emitter_kind};
use glam::Vec2;

/// What a path keeps from bounce to bounce beside [`Path`].
#[derive(Clone, Copy, Debug)]
pub struct Adaptive {
    /// What the heuristics know of it.
    pub spread: Spread,
    /// [`Path::last_pdf`] without regularisation.
    plain_pdf: f32,
    /// [`Path::light_samples`] without regularisation.
    plain_samples: f32,
}

impl Adaptive {
    /// Of a path that has not left the sensor.
    pub const START: Adaptive = Adaptive {
        spread: Spread::START,
        plain_pdf: 0.0,
        plain_samples: 0.0,
    };
}

/// One path whose connections are regularised; `shadows` takes their light, which counts where nothing stands in its way, and
/// how much of it is regularised.
pub struct RegularizedPath<'a, T: Traverse, S, F> {
    /// The walk.
    pub single: SinglePath<'a, T, S>,
    /// Of its sample.
    pub regularization: Regularization,
    /// What else it keeps.
    pub adaptive: Adaptive,
    /// Where shadow rays go.
    pub shadows: F,
    /// tau of the surface, see [`Interaction::tau`].
    pub(super) tau: f32,
    /// Where the walk has arrived.
    pub(super) arrived: Spread,
}

impl<'a, T: Traverse, S, F> RegularizedPath<'a, T, S, F> {
    /// A walk before its next ray is traced.
    #[inline]
    pub fn new(
        single: SinglePath<'a, T, S>,
        regularization: Regularization,
        adaptive: Adaptive,
        shadows: F,
    ) -> RegularizedPath<'a, T, S, F> {
        RegularizedPath {
            single,
            regularization,
            adaptive,
            shadows,
            tau: TAU_MAX,
            arrived: Spread::START,
        }
    }

    #[inline]
    pub(super) fn has(&self, flags: u32) -> bool {
        self.regularization.flags & flags != 0
    }
}

impl<T: Traverse, S: Sampler, F: FnMut(&ShadowRay, RegularizedShare)> RegularizedPath<'_, T, S, F> {
    /// Adds the emission that the walk has met at `end`, an emitter's index and the distance to it, as a mixture of the
    /// regularised and of the plain weights.
    fn arrive_at_emitter(&mut self, emitter: u32, distance: f32) {
        let tables = self.single.view.tables;
        let samples = if self.has(flag::ALL_LIGHTS) {
            // Of this emitter, over the density that holds its choice.
            1.0 / tables.emitters[emitter as usize].selection_pdf
        } else {
            1.0
        };
        let path = &mut self.single.path;
        let hat = (path.last_pdf, path.light_samples * samples);
        let plain = (
            self.adaptive.plain_pdf,
            self.adaptive.plain_samples * samples,
        );
        let spread = &self.adaptive.spread;
        let is_adaptive = self.regularization.flags & flag::QUALITY != 0 && hat != plain;
        let share = if is_adaptive {
            let q = emitter_quality(&tables, emitter, spread.rho, spread.length, distance);
            self.regularization.share(q)
        } else {
            1.0
        };
        let before = path.radiance;
        let mut sum = before;
        let start = *path;
        for (of, (pdf, count)) in [(share, hat), (1.0 - share, plain)] {
            if of > 0.0 {
                let next = self.single.next;
                self.single.path = Path {
                    last_pdf: pdf,
                    light_samples: count,
                    radiance: if of < 1.0 { Rgb::ZERO } else { before },
                    ..start
                };
                self.single.next = next;
                self.single.arrive();
                if of < 1.0 {
                    sum += self.single.path.radiance * of;
                } else {
                    sum = self.single.path.radiance;
                }
            }
        }
        self.single.path.radiance = sum;
    }
}

impl<T: Traverse, S: Sampler, F: FnMut(&ShadowRay, RegularizedShare)> Shading
    for RegularizedPath<'_, T, S, F>
{
    fn arrive(&mut self) {
        let last_pdf = self.single.path.last_pdf;
        let samples = self.single.path.light_samples;
        let may_differ = self.has(flag::ALL_LIGHTS | flag::QUALITY) && samples > 0.0;
        let (mut emitter, mut distance) = (NONE, f32::MAX);
        if may_differ {
            let tables = &self.single.view.tables;
            let subpath = &self.single.path.subpath;
            emitter = tables.info.environment;
            if self.single.hit.is_hit() {
                let hit = &self.single.hit;
                let point = surface_with::<{ detail::NORMALS }>(tables, &subpath.ray, hit);
                emitter = point.emitter;
                distance = (point.position - subpath.position).length();
            }
        }
        if emitter == NONE {
            self.single.arrive();
        } else {
            self.arrive_at_emitter(emitter, distance);
            // As they were, for what lies behind a mask.
            self.single.path.light_samples = samples;
            self.single.path.last_pdf = last_pdf;
        }
        if self.single.next == step::SCATTER {
            #[cfg(not(target_arch = "spirv"))]
            if self.regularization.half_tangent > 0.0 {
                let wi = self.single.path.subpath.local_direction(&self.single.point);
                let data = self.single.view.tables.data;
                let regularization = &self.regularization;
                self.single.bsdf.sharpen(data, wi, |lobe| {
                    is_near_specular(lobe, regularization.quantile, regularization.half_tangent)
                });
            }
            let path = &self.single.path;
            let at = self.single.interaction();
            self.arrived = self.adaptive.spread.arrive(&path.subpath, at.point);
            let tau = self.regularization.threshold(&self.arrived.diffusion);
            self.tau = at.regularized(tau, 0).tau;
        }
    }

    fn sample_emitter(&mut self) {
        if self.is_lit() && !self.has(flag::ALL_LIGHTS) {
            self.single.choose_light();
        }
    }

    fn evaluate_emitter(&mut self) {
        if !self.is_lit() {
            return;
        }
        if !self.has(flag::ALL_LIGHTS) {
            let light = self.single.light;
            self.connect(&light);
            return;
        }
        let tables = self.single.view.tables;
        for i in 0..tables.emitters.len() as u32 {
            let record = &tables.emitters[i as usize];
            if !(record.selection_pdf > 0.0) {
                continue;
            }
            let is_spread = record.kind == emitter_kind::AREA
                || is_infinite(record.kind) && record.kind != emitter_kind::DIRECTIONAL;
            let u = if is_spread {
                self.single.sampler.next_2d()
            } else {
                Vec2::ZERO
            };
            let light = emitter::sample_emitter(&tables, i, self.single.point.position, u);
            self.connect(&light);
        }
    }

    fn sample_bsdf(&mut self) {
        self.single.sample_bsdf();
    }

    fn mix_lobes(&mut self) {
        self.single.mix_lobes();
    }

    fn scatter(&mut self) {
        if self.single.next != step::SCATTER {
            return;
        }
        let mut p_hat = 0.0;
        let sample = self.single.sample;
        let at = self.interaction();
        let is_event = sample.pdf > 0.0 && sample.event & event::NULL == 0;
        if at.is_regularized() && is_event {
            p_hat = if self.has(flag::VIRTUAL_MERGE) {
                // What the paper takes instead, for every direction.
                at.tau
            } else {
                at.eval_cosine_pdf(&self.single.view.tables, sample.wo).1
            };
        }
        let spread = if is_event && self.has(flag::QUALITY | flag::DIFFUSION) {
            self.arrived.scatter(&at, sample.wo)
        } else {
            self.arrived
        };
        let depth = self.single.path.subpath.depth;
        self.single.scatter();
        let path = &mut self.single.path;
        if path.subpath.depth > depth {
            self.adaptive = Adaptive {
                spread,
                plain_pdf: path.last_pdf,
                plain_samples: path.light_samples,
            };
            if p_hat > 0.0 {
                path.last_pdf = p_hat;
                path.light_samples = 1.0;
            }
        }
    }
}

impl<T: Traverse, S, F> Rays for RegularizedPath<'_, T, S, F> {
    fn trace(&mut self) {
        self.single.trace();
    }

    fn trace_shadow_rays(&mut self) {}
}

/// Radiance along `ray`, one sample with its regularisation.
pub fn radiance<T: Traverse, S: Sampler>(
    view: &SceneView<'_, T>,
    settings: &IntegratorSettings,
    regularization: Regularization,
    sampler: &mut S,
    ray: &Ray,
) -> Rgb {
    let mut bsdf = Bsdf::BLACK;
    let mut path = Path::new(ray);
    let mut adaptive = Adaptive::START;
    let mut next = if path.subpath.may_continue(&settings.rules) {
        step::TRACE
    } else {
        step::END
    };
    while next != step::END {
        let mut light = Rgb::ZERO;
        let single = SinglePath::new(view, settings.rules, sampler, &mut bsdf, path);
        let add = |ray: &ShadowRay, _| light += ray.unshadowed(view);
        let mut driver = RegularizedPath::new(single, regularization, adaptive, add);
        bounce(&mut driver, shade);
        next = driver.single.next;
        path = driver.single.path;
        adaptive = driver.adaptive;
        path.radiance += light;
    }
    path.radiance
}
