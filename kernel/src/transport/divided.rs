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
use crate::path::expression::{DEAD, START};
use crate::path::expression_shares::EmitterMatches;
use crate::path::{PathExpressions, PathStates, Scattered};
use crate::sampler::Sampler;
use crate::scene::{NONE, SceneView, Traverse};
use glam::Vec3;

/// The state of a walk that is in several, or in one with a share of the light.
const SEVERAL: u32 = u32::MAX;

/// What accompanies a path, to divide its light: little, because most walks are in one state with all of their light, and because
/// there are many. The rest is a [`Mixture`]. Parts of the path's light are valid once they have been touched.
#[derive(Clone, Copy, Debug)]
pub struct DividedPath {
    /// Light of all paths.
    pub whole: Rgb,
    /// Of the automaton behind the walk, or [`SEVERAL`].
    state: u32,
    /// The expressions that match the emitter sample under way, as bits; none if the mixture knows.
    lit_bits: u32,
    /// Whether it does.
    is_lit_mixed: bool,
    /// Parts that have some light, as bits.
    touched: u32,
}

/// What accompanies a path that is in several states.
#[derive(Clone, Copy, Debug)]
pub struct Mixture {
    /// The expressions that match the emitter sample under way.
    matched_at_emitter: EmitterMatches,
    /// Its emitter, if that depends on more states than one: then they are in `lit`.
    lit_emitter: u32,
    /// Of the vertices behind the walk.
    states: PathStates,
    lit: PathStates,
}

impl Mixture {
    /// Of no path.
    pub const NONE: Mixture = Mixture {
        matched_at_emitter: EmitterMatches::NONE,
        lit_emitter: NONE,
        states: PathStates::DEAD,
        lit: PathStates::DEAD,
    };

    /// [`DividedPath::sampled`] of a mixture whose walk is in `state`, if that is not [`SEVERAL`].
    #[inline(never)]
    fn sampled(
        &mut self,
        expressions: &PathExpressions<'_>,
        state: u32,
        first_letter: u32,
        scattered: &Scattered,
        emitter: u32,
    ) -> bool {
        let is_only = expressions.only != 0;
        self.matched_at_emitter = if state == SEVERAL {
            self.states
                .matched_at_emitter(expressions, first_letter, scattered, emitter)
        } else {
            EmitterMatches::of(
                expressions,
                (state, Vec3::ONE),
                first_letter,
                scattered,
                emitter,
            )
        };
        self.lit_emitter = NONE;
        if self.matched_at_emitter.is_known {
            let bits = self.matched_at_emitter.bits | self.matched_at_emitter.glossy_bits;
            return !is_only || bits != 0;
        }
        self.lit_emitter = emitter;
        let automaton = &expressions.from_sensor;
        self.lit = self.states;
        self.lit
            .advance_at(expressions, automaton, first_letter, scattered);
        !is_only || !self.lit.reach_emitter(expressions, emitter).is_none()
    }
}

impl DividedPath {
    /// Of no path.
    pub const NONE: DividedPath = DividedPath {
        whole: Vec3::ZERO,
        state: DEAD,
        lit_bits: 0,
        is_lit_mixed: false,
        touched: 0,
    };

    /// At the sensor.
    #[inline]
    pub fn begin(&mut self, expressions: &PathExpressions<'_>) {
        *self = DividedPath {
            state: expressions.from_sensor.after(START, expressions.sensor),
            ..DividedPath::NONE
        };
    }

    /// Parts that have some light, as bits.
    #[inline]
    pub fn touched(&self) -> u32 {
        self.touched
    }

    #[inline]
    fn add(&mut self, bits: u32, light: Rgb, parts: &mut [Rgb]) {
        let mut left = bits;
        while left != 0 {
            let part = left.trailing_zeros() as usize;
            left &= left - 1;
            if self.touched >> part & 1 != 0 {
                parts[part] += light;
            } else {
                parts[part] = light;
            }
        }
        self.touched |= bits;
    }

    /// The path has met light of an emitter.
    #[inline]
    pub fn emitter_hit(
        &mut self,
        expressions: &PathExpressions<'_>,
        mixture: &Mixture,
        found: Rgb,
        emitter: u32,
        parts: &mut [Rgb],
    ) {
        if !(found.max_element() > 0.0) {
            return;
        }
        self.whole += found;
        if self.state == SEVERAL {
            let states = &mixture.states;
            states.for_shares(expressions, emitter, |bits, weight| {
                self.add(bits, found * weight, parts);
            });
        } else if emitter != NONE {
            let letter = expressions.emitters[emitter as usize];
            let bits = expressions.from_sensor.matched_with(self.state, letter);
            self.add(bits, found, parts);
        }
    }

    /// An emitter sample is scattered at a [`PathExpressions::first_letter`]; whether it counts.
    #[inline]
    pub fn sampled(
        &mut self,
        expressions: &PathExpressions<'_>,
        mixture: &mut Mixture,
        first_letter: u32,
        scattered: &Scattered,
        emitter: u32,
    ) -> bool {
        let kind = scattered.kind();
        self.is_lit_mixed = self.state == SEVERAL || kind == NONE && emitter != NONE;
        self.lit_bits = 0;
        if self.is_lit_mixed {
            return mixture.sampled(expressions, self.state, first_letter, scattered, emitter);
        }
        if emitter != NONE {
            let automaton = &expressions.from_sensor;
            let state = automaton.after(self.state, expressions.letter(first_letter, kind));
            let last = expressions.emitters[emitter as usize];
            self.lit_bits = automaton.matched_with(state, last);
        }
        expressions.only == 0 || self.lit_bits != 0
    }

    /// The emitter sample has turned out to give so much.
    #[inline]
    pub fn add_direct(
        &mut self,
        expressions: &PathExpressions<'_>,
        mixture: &Mixture,
        found: Rgb,
        parts: &mut [Rgb],
    ) {
        self.whole += found;
        if !self.is_lit_mixed {
            self.add(self.lit_bits, found, parts);
        } else if mixture.lit_emitter == NONE {
            let by = &mixture.matched_at_emitter;
            self.add(by.bits, found * by.weight, parts);
            self.add(by.glossy_bits, found * by.glossy_weight, parts);
        } else {
            let lit = &mixture.lit;
            lit.for_shares(expressions, mixture.lit_emitter, |bits, weight| {
                self.add(bits, found * weight, parts);
            });
        }
    }

    /// The path has scattered at a [`PathExpressions::first_letter`]; whether it shall go on.
    #[inline]
    pub fn scattered(
        &mut self,
        expressions: &PathExpressions<'_>,
        mixture: &mut Mixture,
        first_letter: u32,
        scattered: &Scattered,
    ) -> bool {
        let automaton = &expressions.from_sensor;
        let kind = scattered.kind();
        if self.state != SEVERAL && kind != NONE {
            self.state = automaton.after(self.state, expressions.letter(first_letter, kind));
            return expressions.only == 0 || self.state != DEAD;
        }
        if self.state != SEVERAL {
            mixture.states.restart(self.state);
            self.state = SEVERAL;
        }
        mixture
            .states
            .advance_at(expressions, automaton, first_letter, scattered);
        expressions.only == 0 || !mixture.states.is_dead()
    }

    /// A single path has been shaded where it came along `direction`, behind `depth` edges.
    #[inline]
    pub fn shaded<T: Traverse, S>(
        &mut self,
        expressions: &PathExpressions<'_>,
        mixture: &mut Mixture,
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
        self.emitter_hit(expressions, mixture, found, emitter, parts);
        let (point, data) = (&driver.point, tables.data);
        let is_lit = driver.shadow_ray.is_some();
        // Passing through a mask reads nothing, and a path that ends need not.
        let goes_on = driver.next == step::TRACE && driver.path.subpath.depth > depth;
        if !is_lit && !goes_on {
            return;
        }
        let wi = point.frame.to_local(-direction);
        let first_letter = expressions.first_letter(point);
        if is_lit {
            let wo = point.frame.to_local(driver.light.direction);
            let scattered = Scattered::smooth(driver.bsdf, data, wi, wo);
            if !self.sampled(
                expressions,
                mixture,
                first_letter,
                &scattered,
                driver.light.emitter,
            ) {
                driver.shadow_ray = ShadowRay::NONE;
            }
        }
        if goes_on {
            let sample = &driver.sample;
            let scattered = Scattered::sampled(driver.bsdf, data, wi, sample.wo, sample.event);
            if !self.scattered(expressions, mixture, first_letter, &scattered) {
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
    let mut mixture = Mixture::NONE;
    divided.begin(expressions);
    let mut driver = SinglePath::new(view, settings.rules, sampler, &mut bsdf, Path::new(ray));
    while driver.next != step::END {
        let (direction, depth) = (driver.path.subpath.ray.direction, driver.path.subpath.depth);
        bounce(&mut driver, |driver| {
            shade(driver);
            divided.shaded(expressions, &mut mixture, driver, direction, depth, parts);
        });
        let found = driver.path.radiance;
        driver.path.radiance = Vec3::ZERO;
        if found.max_element() > 0.0 {
            divided.add_direct(expressions, &mixture, found, parts);
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
