//! Manifold exploration as a perturbation of a path (Jakob and Marschner 2012, "Manifold Exploration").
//!
//! Between three vertices that are not specular, in the direction of the sensor or of the light,
//!
//! ```text
//!   x_a ~~~~ (specular) ~~~~ x_b ==== (specular) ==== x_c
//!   turns                    moves                    stays
//! ```
//!
//! the direction at x_a turns a little, the path goes on from there through the specular vertices to a new x_b, and a walk on the
//! manifold of the specular vertices behind it closes the path to x_c. From the lens the film position moves instead. A path that
//! specular vertices lead from x_a to the light has no x_c.
//!
//! Glossy vertices may pass for specular ones that keep their half vector. The cone in which a Beckmann lobe scatters 90 % has the
//! slope alpha sqrt(ln 10); below [`super::plan::SPECULAR_ANGLE`] the vertex is specular, above [`super::plan::ROUGH_ANGLE`] it is not, between the two it
//! is one or the other at random, with probabilities that belong to the density of the proposal.
//!
//! Directions turn by a lobe of von Mises and Fisher's whose peak is lambda^2 times the density with which the direction would be
//! sampled; film positions by a Gaussian with the peak lambda^2 over the film's area.

use super::super::algorithm::WalkCounts;
use super::super::veach::{ChainPath, MAX_VERTICES};
use super::closing::{Closing, ClosingEnd, WayBack, held, with_capacity};
use super::direction_lobe::{DirectionLobe, gaussian};
use super::measure::{segment_factor, towards_light, vertex_factor};
use super::path_chain::{ChainPair, PathChain, Scattering};
use super::plan::{Plan, choose, p_rough, plans};
use super::reconnection::{Method, Segment};
use super::settings::{HalfVectorSettings, roughness_kind};
use super::tracing::{trace_from_light, trace_from_sensor, walked};
use super::verdict::Verdict;
use crate::bsdf::Bsdf;
use crate::manifold::half_vector_form;
use crate::manifold::walk::walk_start;
use crate::math::float::{exp, ln, sqrt};
use crate::math::scaled::Scaled;
use crate::math::{Ray, warp};
use crate::path::tracer::Tracer;
use crate::sampler::Sampler;
use crate::scene::emitter::emission::{self, is_delta};
use crate::scene::{Traverse, camera, emitter_kind};
use core::f32::consts::PI;
use glam::{Vec2, Vec3};

const FORM: u32 = half_vector_form::SLOPE;

const ROUGHNESS: u32 = roughness_kind::LOCAL;

/// Density with which a walk would sample the direction of a path at `a`.
fn direction_pdf<T: Traverse>(tracer: &Tracer<'_, T>, path: &ChainPath, plan: &Plan) -> f32 {
    let vertex = &path.vertices[plan.a];
    if plan.is_from_sensor() {
        vertex.pdf_to_light
    } else if plan.a > 0 {
        vertex.pdf_to_sensor
    } else {
        let tables = &tracer.view.tables;
        let outgoing = path.next_direction(0);
        emission::density(tables, path.emitter, &vertex.point, outgoing).direction
    }
}

/// Logarithm of the probability of taking the inner vertices of a path as rough or not.
fn ln_p_classes(chain: &PathChain, rough: &[bool]) -> f32 {
    (1..chain.len - 1)
        .map(|i| {
            let p = p_rough(chain.vertices[i].alpha.x);
            ln(if rough[i] { p } else { 1.0 - p }.max(1e-30))
        })
        .sum()
}

/// f times what the measure of the proposal is of the camera walk's, over the probabilities of what was met.
fn target<T: Traverse, const N: usize>(
    tracer: &Tracer<'_, T>,
    path: &ChainPath,
    chain: &PathChain,
    plan: &Plan,
    segment: Option<&Segment<N>>,
) -> Scaled {
    let tables = &tracer.view.tables;
    let mut f = Scaled::ONE.times(path.luminance());
    let (low, high) = (plan.a.min(plan.b), plan.a.max(plan.b));
    for j in low + 1..high {
        f = f.times(if plan.is_from_sensor() {
            towards_light(path, chain, j, FORM)
        } else {
            vertex_factor(path, chain, j, FORM)
        });
    }
    if !plan.is_from_sensor() {
        let start = &chain.vertices[low];
        let end = &chain.vertices[high];
        f = f.times(
            start.cosine(path.next_direction(low)) / end.cosine(path.previous_direction(high)),
        );
    }
    f = f.times(1.0 / walked(path, low, high, plan.is_from_sensor()));
    match (segment, plan.c) {
        (Some(segment), Some(c)) => {
            let low = plan.b.min(c);
            let (vertices, jacobian) = (&segment.vertices, &segment.jacobian);
            let m = segment_factor(tables, path, chain, vertices, jacobian, low, FORM);
            f.product(m)
        }
        _ => f,
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
    let (u_plan, u_turn) = (sampler.next_1d(), sampler.next_2d());
    if k < 2 {
        return Verdict::DARK;
    }
    let (chain, of_y) = chains.begin(tables, x, reference, ROUGHNESS, bsdf);
    let mut rough = [false; MAX_VERTICES];
    for (i, rough) in rough.iter_mut().enumerate().take(k).skip(1) {
        *rough = sampler.next_1d() < p_rough(chain.vertices[i].alpha.x);
    }
    let kind = tables.emitters[x.emitter as usize].kind;
    let mut plans = plans(k, &rough, !is_delta(kind), x.is_infinite(tables));
    if settings.start != walk_start::CHOSEN {
        let from_sensor = settings.start == walk_start::SENSOR;
        plans.retain(|plan| plan.is_from_sensor() == from_sensor);
    }
    if plans.is_empty() {
        return Verdict::DARK;
    }
    let plan = choose(&plans, k, u_plan);
    let len = plan.c.map_or(0, |c| plan.b.abs_diff(c) + 1);
    let go = Perturbation {
        tracer,
        x,
        chain,
        rough: &rough,
        plan,
        lambda: settings.lambda,
        reference,
    };
    let verdict = with_capacity!(len, N => {
        go.propose::<S, N>((y, of_y), u_turn, bsdf, sampler, counts, accepts)
    });
    if verdict.is_accepted {
        chains.proposed(ROUGHNESS);
    }
    verdict
}

struct Perturbation<'a, T: Traverse> {
    tracer: &'a Tracer<'a, T>,
    x: &'a ChainPath,
    chain: &'a PathChain,
    rough: &'a [bool],
    plan: Plan,
    lambda: f32,
    reference: Vec3,
}

impl<T: Traverse> Perturbation<'_, T> {
    fn propose<S: Sampler, const N: usize>(
        &self,
        (y, of_y): (&mut ChainPath, &mut PathChain),
        u: Vec2,
        bsdf: &mut Bsdf,
        sampler: &mut S,
        counts: &mut WalkCounts,
        accepts: impl Fn(&ChainPath, f32) -> bool,
    ) -> Verdict {
        let (tracer, x, chain, plan) = (self.tracer, self.x, self.chain, &self.plan);
        let tables = &tracer.view.tables;
        let k = x.edges();
        let Some(h) = held(x, chain, 0, FORM) else {
            return Verdict::DARK;
        };
        let ends = plan.c.map(|c| [plan.b.min(c), plan.b.max(c)]);
        let segment = match ends {
            Some([low, high]) => match Segment::<N>::new(chain, low, high, FORM) {
                Some(segment) => Some(segment),
                None => return Verdict::DARK,
            },
            None => None,
        };
        y.clone_from(x);
        let Some((ray, ln_there)) = self.perturb_direction(y, u) else {
            return Verdict::DARK;
        };
        let is_traced = if plan.is_from_sensor() {
            let keep = |j: usize, _: &mut S| Some(h[j]);
            let span = [plan.a, plan.b];
            trace_from_sensor(tracer, x, chain, y, ray, span, FORM, bsdf, sampler, keep)
        } else {
            let span = [plan.a, plan.b];
            trace_from_light(tracer, x, chain, y, ray, span, FORM, bsdf, sampler)
        };
        if !is_traced {
            return Verdict::DARK;
        }
        let [low, high] = ends.unwrap_or([0, 0]);
        let closing = Closing {
            low,
            high,
            target: &h,
            back: &h,
            method: Method::Exploration,
            start: walk_start::CHOSEN,
        };
        let mut way_back = WayBack::<N>::Edge;
        if let Some(segment) = &segment {
            let end = if plan.is_from_sensor() {
                ClosingEnd::High
            } else {
                ClosingEnd::Low
            };
            let pair = (&mut *y, &mut *of_y);
            let moved = Some(end);
            match closing.close(tracer, x, chain, Some(segment), pair, moved, FORM, counts) {
                Some(found) => way_back = found,
                None => return Verdict::DARK,
            }
        }
        let mut scattering = [Scattering::NONE; MAX_VERTICES];
        let is_lit = tracer.evaluate_and(y, 1, bsdf, |path, i, directions, bsdf| {
            let vertex = &path.vertices[i];
            scattering[i] = Scattering::new(tables, vertex, directions, ROUGHNESS, bsdf);
        });
        if !is_lit {
            return Verdict::DARK;
        }
        // What the walk has found, and the end where it began; what was traced before.
        let (from, to) = (plan.a.min(plan.b), plan.a.max(plan.b));
        let known = match plan.c {
            Some(c) if c < plan.b => c + 1..plan.b + 1,
            Some(c) => plan.b..c,
            None => 0..0,
        };
        let moved = [0..1, known, from + 1..to];
        of_y.follow(tables, y, chain, self.reference, &scattering, moved);
        let of_y = &*of_y;
        let has_other_plans = y.is_infinite(tables) != x.is_infinite(tables);
        if has_other_plans || !of_y.has_kinds_of(chain, 1, k - 1) || !self.is_repeatable(y) {
            return Verdict::DARK;
        }
        let segment_of_y = match ends {
            Some([low, high]) => match Segment::<N>::new(of_y, low, high, FORM) {
                Some(segment) => Some(segment),
                None => return Verdict::DARK,
            },
            None => None,
        };
        let there = target(tracer, y, of_y, plan, segment_of_y.as_ref());
        let here = target(tracer, x, chain, plan, segment.as_ref());
        let ln_back = self.ln_back(y);
        let classes = ln_p_classes(of_y, self.rough) - ln_p_classes(chain, self.rough);
        let ratio = there.over(here).value() * exp(classes + ln_back - ln_there);
        Verdict::of(ratio, y, accepts, || match (&segment, &segment_of_y) {
            (Some(of_x), Some(of_y)) => {
                closing.leads_back(tracer, [of_x, of_y], &mut way_back, counts)
            }
            _ => true,
        })
    }

    /// The first ray of the new path, and the logarithm of its density.
    fn perturb_direction(&self, y: &mut ChainPath, u: Vec2) -> Option<(Ray, f32)> {
        let (x, plan) = (self.x, &self.plan);
        let tables = &self.tracer.view.tables;
        let window = &tables.camera;
        if plan.a == x.edges() {
            let film = moved_film(window, x.film, film_deviation(window, self.lambda), u)?;
            y.film = film;
            let ray = camera::ray_through(window, film, x.u_lens);
            y.vertices[plan.a].point.position = ray.origin;
            return Some((ray, 0.0));
        }
        let old = self.direction(x);
        let lobe = DirectionLobe::new(direction_pdf(self.tracer, x, plan), self.lambda);
        let new = lobe.sample(old, u);
        let start = &x.vertices[plan.a].point;
        let is_bare = plan.a == 0 && tables.emitters[x.emitter as usize].kind != emitter_kind::AREA;
        let ray = if is_bare {
            Ray::new(start.position, new)
        } else {
            start.spawn(new)
        };
        Some((ray, lobe.ln_pdf(old, new)))
    }

    /// Logarithm of the density with which the first ray of the old path would be proposed from the new one.
    fn ln_back(&self, y: &ChainPath) -> f32 {
        if self.plan.a == self.x.edges() {
            return 0.0;
        }
        let lobe = DirectionLobe::new(direction_pdf(self.tracer, y, &self.plan), self.lambda);
        lobe.ln_pdf(self.direction(y), self.direction(self.x))
    }

    fn direction(&self, path: &ChainPath) -> Vec3 {
        if self.plan.is_from_sensor() {
            path.previous_direction(self.plan.a)
        } else {
            path.next_direction(self.plan.a)
        }
    }

    /// Whether discrete events that were taken again are the only ones of their kind, on both paths.
    fn is_repeatable(&self, y: &ChainPath) -> bool {
        let (low, high) = (self.plan.a.min(self.plan.b), self.plan.a.max(self.plan.b));
        [self.x, y].iter().all(|path| {
            let between = &path.vertices[low + 1..high];
            between.iter().all(|v| v.is_smooth() || v.is_unique)
        })
    }
}

/// Deviation of film positions in pixels.
fn film_deviation(window: &crate::scene::Camera, lambda: f32) -> f32 {
    let area = window.crop_size[0] as f32 * window.crop_size[1] as f32;
    sqrt(area / (2.0 * PI)) / lambda
}

/// A film position moved by a Gaussian; none outside of the window.
pub fn moved_film(
    window: &crate::scene::Camera,
    film: Vec2,
    deviation: f32,
    u: Vec2,
) -> Option<Vec2> {
    let film = film + gaussian(u) * deviation;
    let start = Vec2::new(window.crop_offset[0] as f32, window.crop_offset[1] as f32);
    let size = Vec2::new(window.crop_size[0] as f32, window.crop_size[1] as f32);
    let inside = film.cmpge(start).all() && film.cmplt(start + size).all();
    inside.then_some(film)
}
