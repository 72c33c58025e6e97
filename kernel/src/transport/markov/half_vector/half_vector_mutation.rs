//! The half-vector mutation of a path (Kaplanyan 2017, chapter 8; Hanika, Kaplanyan, Dachsbacher 2015, "Improved Half Vector Space
//! Light Transport").
//!
//! ```text
//!   x_k ---- ... ---- x_b ==== ... ==== x_c ---- ... ---- x_0
//!   (sensor) multi-chain   half-vector chain   untouched (light)
//! ```
//!
//! The improved method breaks the path up ([`crate::manifold::breakup`]). From the sensor to x_b film position, lens point and half
//! vectors take steps, and the vertices follow one after the other; between x_b and x_c half vectors take steps, and a walk finds the
//! vertices between the two ends; from x_c on the path stays. The original method has b = k and c = 0.
//!
//! A half vector takes a step of the smaller of gamma times the width of its lobe and, where the segment ends at the sensor, its
//! share of a step over the image ([`crate::manifold::step_size`]). Widths belong to a pair of directions, so the density
//! of the reverse mutation takes those of the new path. With all densities per half vectors
//!
//! ```text
//! a = f(y) M(y) P(b, c | y) p(h_x | y) / (f(x) M(x) P(b, c | x) p(h_y | x)),
//! ```
//!
//! M of [`super::measure`].

use super::super::algorithm::WalkCounts;
use super::super::veach::{ChainPath, MAX_VERTICES};
use super::closing::{Closing, ClosingEnd, HalfVectors, WayBack, held, with_capacity};
use super::manifold_perturbation::moved_film;
use super::measure::{segment_factor, towards_light};
use super::path_chain::{ChainPair, PathChain, Scattering};
use super::reconnection::{Method, Segment};
use super::settings::HalfVectorSettings;
use super::steps::{Steps, free_step, segment_steps};
use super::tracing::{trace_from_sensor, walked};
use super::verdict::Verdict;
use crate::bsdf::Bsdf;
use crate::manifold::breakup::{choose, probabilities_b, probabilities_c};
use crate::manifold::step_size::IMAGE_FRACTION;
use crate::math::float::exp;
use crate::math::scaled::Scaled;
use crate::math::warp;
use crate::path::tracer::Tracer;
use crate::sampler::Sampler;
use crate::scene::emitter::emission::is_delta;
use crate::scene::{Traverse, camera, camera_kind};
use glam::{Vec2, Vec3};

/// Largest move of the numbers that choose the lens point.
const LENS_STEP: f32 = 0.05;

/// Where a path is broken up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Breakup {
    /// The vertex up to which the path follows from the sensor.
    b: usize,
    /// The vertex from which it stays.
    c: usize,
}

impl Breakup {
    fn sample(chain: &PathChain, [u_b, u_c]: [f32; 2]) -> Breakup {
        let mut p = [0.0; MAX_VERTICES];
        probabilities_b(&chain.vertices, chain.len, &mut p);
        let b = choose(&p, u_b);
        probabilities_c(&chain.vertices, chain.len, b, &mut p);
        Breakup {
            b,
            c: choose(&p, u_c),
        }
    }

    fn probability(&self, chain: &PathChain) -> f32 {
        let mut p = [0.0; MAX_VERTICES];
        probabilities_b(&chain.vertices, chain.len, &mut p);
        let of_b = p[self.b];
        if self.b == 0 {
            return of_b;
        }
        probabilities_c(&chain.vertices, chain.len, self.b, &mut p);
        of_b * p[self.c]
    }
}

/// Makes `y` of `x`, which `accepts` tells whether to accept with the ratio f(y) T(y -> x) / (f(x) T(x -> y)).
#[allow(clippy::too_many_arguments)]
pub fn propose<T: Traverse, S: Sampler>(
    tracer: &Tracer<'_, T>,
    x: &ChainPath,
    y: &mut ChainPath,
    settings: &HalfVectorSettings,
    chains: &mut ChainPair,
    bsdf: &mut Bsdf,
    sampler: &mut S,
    counts: &mut WalkCounts,
    accepts: impl Fn(&ChainPath, f32) -> bool,
) -> Verdict {
    let tables = &tracer.view.tables;
    let k = x.edges();
    let reference = warp::square_to_uniform_sphere(sampler.next_2d());
    let u = [sampler.next_1d(), sampler.next_1d()];
    if k < 2 {
        return Verdict::DARK;
    }
    let (chain, of_y) = chains.begin(tables, x, reference, settings.roughness, bsdf);
    let parts = if settings.is_original {
        Breakup { b: k, c: 0 }
    } else {
        Breakup::sample(chain, u)
    };
    let Some(h) = held(x, chain, parts.c, settings.form) else {
        return Verdict::DARK;
    };
    let go = Mutation {
        tracer,
        x,
        chain,
        h: &h,
        parts,
        settings,
        reference,
    };
    let verdict = with_capacity!(parts.b - parts.c + 1, N => {
        go.propose::<S, N>((y, of_y), bsdf, sampler, counts, accepts)
    });
    if verdict.is_accepted {
        chains.proposed(settings.roughness);
    }
    verdict
}

struct Mutation<'a, T: Traverse> {
    tracer: &'a Tracer<'a, T>,
    x: &'a ChainPath,
    chain: &'a PathChain,
    /// Half vectors of x behind c.
    h: &'a HalfVectors,
    parts: Breakup,
    settings: &'a HalfVectorSettings,
    reference: Vec3,
}

impl<T: Traverse> Mutation<'_, T> {
    fn propose<S: Sampler, const N: usize>(
        &self,
        (y, of_y): (&mut ChainPath, &mut PathChain),
        bsdf: &mut Bsdf,
        sampler: &mut S,
        counts: &mut WalkCounts,
        accepts: impl Fn(&ChainPath, f32) -> bool,
    ) -> Verdict {
        let (tracer, x, chain) = (self.tracer, self.x, self.chain);
        let tables = &tracer.view.tables;
        let (k, form) = (x.edges(), self.settings.form);
        let Breakup { b, c } = self.parts;
        let segment = if b > 0 {
            match Segment::<N>::new(chain, c, b, form) {
                Some(segment) => Some(segment),
                None => return Verdict::DARK,
            }
        } else {
            None
        };
        let mut steps = Steps::new();
        if !self.steps(x, chain, self.h, segment.as_ref(), &mut steps) {
            return Verdict::DARK;
        }
        // The new half vectors of all vertices that take steps.
        let mut target = self.h.clone();
        for (i, step) in steps.iter().enumerate() {
            if let Some(step) = step {
                target[i] = step.sample(sampler.next_2d());
            }
        }
        // Half vectors that lead back, and what a jump adds to the ratio.
        let (mut back, mut jump) = (self.h.clone(), Scaled::ONE);
        let mut way_back = WayBack::<N>::Edge;
        y.clone_from(x);
        if b < k && !self.move_sensor_part(y, &target, bsdf, sampler) {
            return Verdict::DARK;
        }
        let closing = Closing {
            low: c,
            high: b,
            target: &target,
            back: self.h,
            method: Method::HalfVectors,
            start: self.settings.start,
        };
        match segment.as_ref() {
            Some(segment) if b == k && b > c + 1 => {
                let pair = (&mut *y, &mut *of_y);
                let moved = closing.move_or_jump(tracer, x, chain, segment, pair, form, counts);
                let Some(moved) = moved else {
                    return Verdict::DARK;
                };
                way_back = moved.way_back;
                if let Some(found) = moved.jump {
                    (back, jump) = (found.back, found.factor);
                }
            }
            Some(segment) => {
                let end = (b < k).then_some(ClosingEnd::High);
                let pair = (&mut *y, &mut *of_y);
                match closing.close(tracer, x, chain, Some(segment), pair, end, form, counts) {
                    Some(found) => way_back = found,
                    None => return Verdict::DARK,
                }
            }
            None => {}
        }
        let mut scattering = [Scattering::NONE; MAX_VERTICES];
        let roughness = self.settings.roughness;
        // Vertices before c are those of x with their directions.
        let first = c.max(1);
        let is_lit = tracer.evaluate_and(y, first, bsdf, |path, i, directions, bsdf| {
            let vertex = &path.vertices[i];
            scattering[i] = Scattering::new(tables, vertex, directions, roughness, bsdf);
        });
        if !is_lit {
            return Verdict::DARK;
        }
        let is_delta_changed = b == 0 && y.is_infinite(tables) != x.is_infinite(tables);
        if is_delta_changed || !self.is_repeatable(y) {
            return Verdict::DARK;
        }
        // What the walk has found, and the end where it began; what was traced before.
        let known = c + 1..if b < k { b + 1 } else { b };
        let traced = b + 1..k;
        let moved = [0..first, known, traced];
        of_y.follow(tables, y, chain, self.reference, &scattering, moved);
        let of_y = &*of_y;
        if !of_y.has_kinds_of(chain, 1, k - 1) {
            return Verdict::DARK;
        }
        let segment_of_y = if b > 0 {
            match Segment::<N>::new(of_y, c, b, form) {
                Some(segment) => Some(segment),
                None => return Verdict::DARK,
            }
        } else {
            None
        };
        let Some(h_of_y) = held(y, of_y, c, form) else {
            return Verdict::DARK;
        };
        let mut steps_of_y = Steps::new();
        if !self.steps(y, of_y, &h_of_y, segment_of_y.as_ref(), &mut steps_of_y) {
            return Verdict::DARK;
        }
        let mut ln_densities = 0.0;
        for (i, (of_x, of_y)) in steps.iter().zip(&steps_of_y).enumerate() {
            if let (Some(of_x), Some(of_y)) = (of_x, of_y) {
                ln_densities += of_y.ln_pdf(back[i]) - of_x.ln_pdf(target[i]);
            }
        }
        let choice = if self.settings.is_original {
            1.0
        } else {
            self.parts.probability(of_y) / self.parts.probability(chain)
        };

        let there = self.target(y, of_y, segment_of_y.as_ref());
        let here = self.target(x, chain, segment.as_ref());
        let ratio = there.over(here).product(jump).value() * exp(ln_densities) * choice;
        Verdict::of(ratio, y, accepts, || match (&segment, &segment_of_y) {
            (Some(of_x), Some(of_y)) => {
                closing.leads_back(tracer, [of_x, of_y], &mut way_back, counts)
            }
            _ => true,
        })
    }

    /// The steps of all vertices between the sensor and b, and between b and c; returns whether all are finite.
    fn steps<const N: usize>(
        &self,
        path: &ChainPath,
        chain: &PathChain,
        h: &HalfVectors,
        segment: Option<&Segment<N>>,
        steps: &mut Steps,
    ) -> bool {
        let k = path.edges();
        let Breakup { b, c } = self.parts;
        for i in 0..=k {
            let follows = i > b && i < k && path.vertices[i].is_smooth();
            steps.push(follows.then(|| free_step(&chain.vertices[i], h[i], self.settings)));
        }
        let Some(segment) = segment else {
            return true;
        };
        let is_limited = b == k && self.settings.is_stratified;
        let tables = &self.tracer.view.tables;
        segment_steps(
            tables,
            path,
            chain,
            segment,
            c,
            is_limited,
            self.settings,
            steps,
        )
    }

    /// Moves the film position, the lens point and all vertices down to b.
    fn move_sensor_part<S: Sampler>(
        &self,
        y: &mut ChainPath,
        target: &HalfVectors,
        bsdf: &mut Bsdf,
        sampler: &mut S,
    ) -> bool {
        let tables = &self.tracer.view.tables;
        let (x, b, k) = (self.x, self.parts.b, self.x.edges());
        let kind = tables.emitters[x.emitter as usize].kind;
        let (u, u_lens) = (sampler.next_2d(), sampler.next_2d());
        if b == 0 && is_delta(kind) {
            return false;
        }
        let window = &tables.camera;
        let size = window.crop_size[0].min(window.crop_size[1]) as f32;
        let Some(film) = moved_film(window, x.film, IMAGE_FRACTION * size, u) else {
            return false;
        };
        y.film = film;
        if window.kind == camera_kind::THIN_LENS {
            let moved = x.u_lens + (u_lens - 0.5) * (2.0 * LENS_STEP);
            y.u_lens = Vec2::new(wrapped(moved.x), wrapped(moved.y));
        }
        let ray = camera::ray_through(window, film, y.u_lens);
        y.vertices[k].point.position = ray.origin;
        let form = self.settings.form;
        let give = |j: usize, _: &mut S| Some(target[j]);
        trace_from_sensor(
            self.tracer,
            x,
            self.chain,
            y,
            ray,
            [k, b],
            form,
            bsdf,
            sampler,
            give,
        )
    }

    /// Whether discrete events that were taken again are the only ones of their kind, on both paths.
    fn is_repeatable(&self, y: &ChainPath) -> bool {
        let (b, k) = (self.parts.b, self.x.edges());
        b >= k
            || [self.x, y].iter().all(|path| {
                let between = &path.vertices[b + 1..k];
                between.iter().all(|v| v.is_smooth() || v.is_unique)
            })
    }

    /// f M, over the probabilities of what was met on the way to b.
    fn target<const N: usize>(
        &self,
        path: &ChainPath,
        chain: &PathChain,
        segment: Option<&Segment<N>>,
    ) -> Scaled {
        let (tables, form) = (&self.tracer.view.tables, self.settings.form);
        let Breakup { b, c } = self.parts;
        let k = path.edges();
        let mut f = Scaled::ONE.times(path.luminance());
        for j in b + 1..k {
            f = f.times(towards_light(path, chain, j, form));
        }
        f = f.times(1.0 / walked(path, b, k, true));
        match segment {
            Some(s) => f.product(segment_factor(
                tables,
                path,
                chain,
                &s.vertices,
                &s.jacobian,
                c,
                form,
            )),
            None => f,
        }
    }
}

/// A number modulo one.
fn wrapped(u: f32) -> f32 {
    let u = u - crate::math::float::floor(u);
    // Small negative numbers round to one.
    if u < 1.0 { u } else { 0.0 }
}
