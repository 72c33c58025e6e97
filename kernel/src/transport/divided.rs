//! Path tracing whose light is divided by path expressions ([`crate::path::expression`]).
//!
//! A walk from the sensor reads the automata from that end: what it finds of an emitter, and what an emitter sample gives,
//! belongs to the expressions that match once the emitter is read. A [`DividedPath`] accompanies a path, whose driver informs it
//! of each bounce; the path's own numbers and sums are those of [`super::path`], to the bit. Where nothing but the paths of one
//! expression counts, a walk ends as soon as they cannot be reached any more, and emitter samples of other paths are not
//! traced.
//! Invariants (tests): parts that partition all paths add up to the whole, to rounding; the wavefront gives the parts of single
//! paths.

use super::bounce::{bounce, shade};
use super::connection::ShadowRay;
use super::path::{Path, SinglePath, step};
use super::pixel::camera_ray;
use super::settings::IntegratorSettings;
use crate::bsdf::Bsdf;
use crate::math::{Ray, Rgb};
use crate::path::path_states::{EmitterMatches, add_to_parts};
use crate::path::{PathExpressions, PathStates, Scattered};
use crate::sampler::Sampler;
use crate::scene::{NONE, SceneView, SurfacePoint, Traverse};
use glam::Vec3;

/// What accompanies a path, to divide its light.
#[derive(Clone, Copy, Debug)]
pub struct DividedPath {
    /// Light of all paths.
    pub whole: Rgb,
    /// The expressions that match the emitter sample under way.
    matched_at_emitter: EmitterMatches,
    /// Its emitter, if that depends on more states than one: then they are in `lit`.
    lit_emitter: u32,
    /// Of the vertices behind the walk.
    states: PathStates,
    lit: PathStates,
}

impl DividedPath {
    /// Of no path.
    pub const NONE: DividedPath = DividedPath {
        whole: Vec3::ZERO,
        matched_at_emitter: EmitterMatches::NONE,
        lit_emitter: NONE,
        states: PathStates::DEAD,
        lit: PathStates::DEAD,
    };

    /// At the sensor.
    #[inline]
    pub fn begin(&mut self, expressions: &PathExpressions<'_>) {
        self.whole = Vec3::ZERO;
        self.states.restart_at_sensor(expressions);
    }

    /// The path has met light of an emitter.
    #[inline]
    pub fn emitter_hit(
        &mut self,
        expressions: &PathExpressions<'_>,
        found: Rgb,
        emitter: u32,
        parts: &mut [Rgb],
    ) {
        if found.max_element() > 0.0 {
            self.whole += found;
            self.states.divide(expressions, emitter, found, parts);
        }
    }

    /// An emitter sample is scattered at a point; whether it counts.
    #[inline]
    pub fn sampled(
        &mut self,
        expressions: &PathExpressions<'_>,
        point: &SurfacePoint,
        scattered: &Scattered,
        emitter: u32,
    ) -> bool {
        self.matched_at_emitter =
            self.states
                .matched_at_emitter(expressions, point, scattered, emitter);
        self.lit_emitter = NONE;
        if self.matched_at_emitter.is_known {
            let bits = self.matched_at_emitter.bits | self.matched_at_emitter.glossy_bits;
            return expressions.only == 0 || bits != 0;
        }
        self.lit_emitter = emitter;
        let automaton = &expressions.from_sensor;
        self.lit = self.states.after(expressions, automaton, point, scattered);
        expressions.only == 0 || !self.lit.reach_emitter(expressions, emitter).is_none()
    }

    /// The emitter sample has turned out to give so much.
    #[inline]
    pub fn add_direct(&mut self, expressions: &PathExpressions<'_>, found: Rgb, parts: &mut [Rgb]) {
        self.whole += found;
        if self.lit_emitter == NONE {
            let by = &self.matched_at_emitter;
            add_to_parts(by.bits, found * by.weight, parts);
            add_to_parts(by.glossy_bits, found * by.glossy_weight, parts);
        } else {
            self.lit.divide(expressions, self.lit_emitter, found, parts);
        }
    }

    /// The path has scattered at a point; whether it shall go on.
    #[inline]
    pub fn scattered(
        &mut self,
        expressions: &PathExpressions<'_>,
        point: &SurfacePoint,
        scattered: &Scattered,
    ) -> bool {
        let automaton = &expressions.from_sensor;
        self.states
            .advance(expressions, automaton, point, scattered);
        expressions.only == 0 || !self.states.is_dead()
    }

    /// A single path has been shaded where it came along `direction`, behind `depth` edges.
    #[inline]
    pub fn shaded<T: Traverse, S>(
        &mut self,
        expressions: &PathExpressions<'_>,
        driver: &mut SinglePath<'_, T, S>,
        direction: Vec3,
        depth: u32,
        parts: &mut [Rgb],
    ) {
        let found = driver.path.radiance;
        driver.path.radiance = Vec3::ZERO;
        let tables = &driver.view.tables;
        let emitter = if driver.hit.is_hit() {
            driver.point.emitter
        } else {
            tables.info.environment
        };
        self.emitter_hit(expressions, found, emitter, parts);
        let (point, data) = (&driver.point, tables.data);
        let wi = point.frame.to_local(-direction);
        if driver.shadow_ray.is_some() {
            let wo = point.frame.to_local(driver.light.direction);
            let scattered = Scattered::smooth(driver.bsdf, data, wi, wo);
            if !self.sampled(expressions, point, &scattered, driver.light.emitter) {
                driver.shadow_ray = ShadowRay::NONE;
            }
        }
        // Passing through a mask reads nothing, and a path that ends need not.
        if driver.next == step::TRACE && driver.path.subpath.depth > depth {
            let sample = &driver.sample;
            let scattered = Scattered::sampled(driver.bsdf, data, wi, sample.wo, sample.event);
            if !self.scattered(expressions, point, &scattered) {
                driver.next = step::END;
            }
        }
    }
}

/// Radiance along `ray`, one sample; adds the part of each expression to `parts`.
pub fn divided_radiance<T: Traverse, S: Sampler>(
    view: &SceneView<'_, T>,
    settings: &IntegratorSettings,
    expressions: &PathExpressions<'_>,
    sampler: &mut S,
    ray: &Ray,
    parts: &mut [Rgb],
) -> Rgb {
    let mut bsdf = Bsdf::BLACK;
    let mut divided = DividedPath::NONE;
    divided.begin(expressions);
    let mut driver = SinglePath::new(view, settings.rules, sampler, &mut bsdf, Path::new(ray));
    while driver.next != step::END {
        let (direction, depth) = (driver.path.subpath.ray.direction, driver.path.subpath.depth);
        bounce(&mut driver, |driver| {
            shade(driver);
            divided.shaded(expressions, driver, direction, depth, parts);
        });
        let found = driver.path.radiance;
        driver.path.radiance = Vec3::ZERO;
        if found.max_element() > 0.0 {
            divided.add_direct(expressions, found, parts);
        }
    }
    divided.whole
}

/// One sample of the pixel at absolute film coordinates, times its reconstruction weight, and the part of each expression in
/// it. Where nothing counts but the paths of the first expression, the sample is that part.
pub fn sample_divided_pixel<T: Traverse, S: Sampler>(
    view: &SceneView<'_, T>,
    settings: &IntegratorSettings,
    expressions: &PathExpressions<'_>,
    sampler: &mut S,
    pixel: [u32; 2],
    parts: &mut [Rgb],
) -> Rgb {
    let seen = camera_ray(&view.tables, sampler, pixel);
    parts.fill(Vec3::ZERO);
    let whole = divided_radiance(view, settings, expressions, sampler, &seen.ray, parts);
    for part in &mut *parts {
        *part *= seen.weight;
    }
    if expressions.only != 0 {
        parts[0]
    } else {
        whole * seen.weight
    }
}
