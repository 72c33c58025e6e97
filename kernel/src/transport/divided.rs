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
use crate::path::expression::{DEAD, START, scattering};
use crate::path::expression_shares::EmitterMatches;
use crate::path::{PathExpressions, PathStates, Scattered};
use crate::sampler::Sampler;
use crate::scene::{NONE, SceneView, Traverse};
use glam::Vec3;

/// The state of a walk that is in several, or in one with a share of the light.
const SEVERAL: u32 = u32::MAX;

/// What accompanies a path, to divide its light: little, because most walks are in one state with all of their light, and because
/// there are many. The rest is a [`Mixture`]. Parts of the path's light begin as zeros.
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
}

/// What accompanies a path that is in several states.
#[derive(Clone, Copy, Debug)]
pub struct Mixture {
    /// Of the vertices behind the walk.
    states: PathStates,
    /// What matches with the emitter sample under way.
    lit: EmitterMatches,
}

impl Mixture {
    /// Of no path.
    pub const NONE: Mixture = Mixture {
        states: PathStates::DEAD,
        lit: EmitterMatches::NONE,
    };
}

/// How a vertex scatters, as the automata read it: in one way, or diffusely and glossily at once.
#[derive(Clone, Copy, Debug)]
pub struct Letters {
    first: u32,
    /// The same if there is one way, or if no expression distinguishes both.
    second: u32,
    /// Share of the first.
    share: Rgb,
}

impl Letters {
    /// In one way.
    #[inline(always)]
    pub fn one(letter: u32) -> Letters {
        Letters {
            first: letter,
            second: letter,
            share: Vec3::ONE,
        }
    }

    /// In two ways, to the same side, at a [`PathExpressions::first_letter`].
    #[inline(always)]
    pub fn two(
        expressions: &PathExpressions<'_>,
        first_letter: u32,
        side: u32,
        diffuse: Rgb,
    ) -> Letters {
        Letters {
            first: expressions.letter(first_letter, scattering::DIFFUSE_REFLECTION + side),
            second: expressions.letter(first_letter, scattering::GLOSSY_REFLECTION + side),
            share: diffuse,
        }
    }

    /// At a [`PathExpressions::first_letter`].
    #[inline]
    pub fn of(
        expressions: &PathExpressions<'_>,
        first_letter: u32,
        scattered: &Scattered,
    ) -> Letters {
        let kind = scattered.kind();
        if kind != NONE {
            return Letters::one(expressions.letter(first_letter, kind));
        }
        let side = scattered.is_transmitted as u32;
        Letters::two(expressions, first_letter, side, scattered.diffuse)
    }

    #[inline(always)]
    fn is_one(&self) -> bool {
        self.first == self.second
    }
}

impl DividedPath {
    /// Of no path.
    pub const NONE: DividedPath = DividedPath {
        whole: Vec3::ZERO,
        state: DEAD,
        lit_bits: 0,
        is_lit_mixed: false,
    };

    /// At the sensor.
    #[inline]
    pub fn begin(&mut self, expressions: &PathExpressions<'_>) {
        *self = DividedPath {
            state: expressions.from_sensor.after(START, expressions.sensor),
            ..DividedPath::NONE
        };
    }

    #[inline(always)]
    fn add(&mut self, bits: u32, light: Rgb, parts: &mut [Rgb]) {
        let mut left = bits;
        while left != 0 {
            parts[left.trailing_zeros() as usize] += light;
            left &= left - 1;
        }
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

    /// Whether the path is in several states.
    #[inline(always)]
    pub fn is_mixed(&self) -> bool {
        self.state == SEVERAL
    }

    /// An emitter sample is scattered by a letter where the path is in one state; whether it counts.
    #[inline(always)]
    pub fn lit_by(&mut self, expressions: &PathExpressions<'_>, letter: u32, emitter: u32) -> bool {
        let automaton = &expressions.from_sensor;
        let next = automaton.after(self.state, letter);
        self.is_lit_mixed = false;
        // None of a sample that nobody has asked for.
        self.lit_bits = match expressions.emitters.get(emitter as usize) {
            Some(last) => automaton.matched_with(next, *last),
            None => 0,
        };
        expressions.only == 0 || self.lit_bits != 0
    }

    /// The path has scattered by a letter where it is in one state; whether it shall go on.
    #[inline(always)]
    pub fn scattered_by(&mut self, expressions: &PathExpressions<'_>, letter: u32) -> bool {
        self.state = expressions.from_sensor.after(self.state, letter);
        expressions.only == 0 || self.state != DEAD
    }

    /// An emitter sample is scattered; whether it counts.
    #[inline]
    pub fn lit(
        &mut self,
        expressions: &PathExpressions<'_>,
        mixture: &mut Mixture,
        letters: Letters,
        emitter: u32,
    ) -> bool {
        if self.state != SEVERAL && letters.is_one() {
            self.lit_by(expressions, letters.first, emitter)
        } else {
            self.lit_mixed(expressions, mixture, letters, emitter)
        }
    }

    #[inline(never)]
    fn lit_mixed(
        &mut self,
        expressions: &PathExpressions<'_>,
        mixture: &mut Mixture,
        letters: Letters,
        emitter: u32,
    ) -> bool {
        self.is_lit_mixed = true;
        self.lit_bits = 0;
        let Mixture { states, lit } = mixture;
        lit.clear();
        if emitter == NONE {
            return expressions.only == 0;
        }
        if self.state != SEVERAL {
            // Its states are of no account as long as it is in one.
            states.restart(self.state);
        }
        let automaton = &expressions.from_sensor;
        let last = expressions.emitters[emitter as usize];
        let share = letters.share;
        if letters.is_one() {
            states.match_emitter(automaton, letters.first, Vec3::ONE, last, lit);
        } else {
            states.match_emitter(automaton, letters.first, share, last, lit);
            states.match_emitter(automaton, letters.second, Vec3::ONE - share, last, lit);
        }
        expressions.only == 0 || !lit.is_empty()
    }

    /// The emitter sample has turned out to give so much.
    #[inline(always)]
    pub fn add_direct(&mut self, mixture: &Mixture, found: Rgb, parts: &mut [Rgb]) {
        self.whole += found;
        if !self.is_lit_mixed {
            self.add(self.lit_bits, found, parts);
            return;
        }
        for i in 0..mixture.lit.len() {
            let (bits, weight) = mixture.lit.get(i);
            self.add(bits, found * weight, parts);
        }
    }

    /// The path has scattered; whether it shall go on.
    #[inline]
    pub fn scattered(
        &mut self,
        expressions: &PathExpressions<'_>,
        mixture: &mut Mixture,
        letters: Letters,
    ) -> bool {
        if self.state != SEVERAL && letters.is_one() {
            self.scattered_by(expressions, letters.first)
        } else {
            self.scattered_mixed(expressions, mixture, letters)
        }
    }

    #[inline(never)]
    fn scattered_mixed(
        &mut self,
        expressions: &PathExpressions<'_>,
        mixture: &mut Mixture,
        letters: Letters,
    ) -> bool {
        let states = &mut mixture.states;
        if self.state != SEVERAL {
            states.restart(self.state);
            self.state = SEVERAL;
        }
        let automaton = &expressions.from_sensor;
        if letters.is_one() {
            states.advance_by(automaton, letters.first);
        } else {
            states.advance_by_two(automaton, [letters.first, letters.second], letters.share);
        }
        expressions.only == 0 || !states.is_dead()
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
            let letters = Letters::of(expressions, first_letter, &scattered);
            if !self.lit(expressions, mixture, letters, driver.light.emitter) {
                driver.shadow_ray = ShadowRay::NONE;
            }
        }
        if goes_on {
            let sample = &driver.sample;
            let scattered = Scattered::sampled(driver.bsdf, data, wi, sample.wo, sample.event);
            let letters = Letters::of(expressions, first_letter, &scattered);
            if !self.scattered(expressions, mixture, letters) {
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
            divided.add_direct(&mixture, found, parts);
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
