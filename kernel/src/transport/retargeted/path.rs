//! Path tracing with edits.
//!
//! Edits of importance turn the directions that a walk samples. For those of light it guesses whether the direction back to where
//! it came from had been turned ([`IncomingDirection::guess`]), and counts what it finds by the share of its path that is selected so. The two
//! techniques for light, BSDF samples and emitter samples, are weighted by their densities of the same labelled path.

use crate::bsdf::{Bsdf, BsdfSample, event, mode};
use crate::math::{Ray, Rgb};
use crate::path::retarget::MAX_EDITS;
use crate::path::retarget_states::{EditStates, Edits};
use crate::path::retargeted::{IncomingDirection, Retargeted};
use crate::path::rules::step;
use crate::path::{Interaction, PathExpressions, PathRules, PathStates, Scattered};
use crate::sampler::Sampler;
use crate::scene::emitter::DirectSample;
use crate::scene::surface::{detail, surface_with};
use crate::scene::{SceneView, SurfacePoint, Tables, Traverse};
use crate::transport::connection::{SampleCounts, ShadowRay, sample_light, weighted_contribution};
use crate::transport::path::Path;
use crate::transport::pixel::camera_ray;
use crate::transport::settings::IntegratorSettings;
use glam::Vec3;

/// Radiance along `ray`, one sample. `add` takes each part of it with the number of vertices from the light of the strategy that
/// found it (0 for what the walk met, 1 for emitter samples), the number from the sensor, and the states of `expressions` behind
/// all but the emitter with that emitter.
pub fn radiance<T: Traverse, S: Sampler>(
    view: &SceneView<'_, T>,
    rules: PathRules,
    edits: &Edits<'_>,
    expressions: Option<&PathExpressions<'_>>,
    sampler: &mut S,
    ray: &Ray,
    mut add: impl FnMut(Found, &PathStates),
) {
    let tables = &view.tables;
    let mut bsdf = Bsdf::BLACK;
    let mut path = Path::new(ray);
    let mut states = EditStates::at_sensor(edits);
    let mut read = expressions.map_or(PathStates::DEAD, PathStates::at_sensor);
    let mut next = if path.subpath.may_continue(&rules) {
        step::TRACE
    } else {
        step::END
    };
    while next == step::TRACE {
        let subpath = path.subpath;
        let t = subpath.depth + 2;
        sampler.start_bounce(subpath.depth.saturating_add(subpath.crossings));
        let hit = view.traverse.closest_hit(&subpath.ray);
        let mut point = SurfacePoint::ZERO;
        let mut emitter = tables.info.environment;
        if hit.is_hit() {
            point = surface_with::<{ detail::TANGENTS }>(tables, &subpath.ray, &hit);
            emitter = point.emitter;
            next = path.arrive(tables, &rules, &point);
        } else {
            path.escape(tables, &rules);
            next = step::END;
        }
        let met = core::mem::take(&mut path.radiance);
        if met.max_element() > 0.0 {
            let value = met * states.reach_emitter(edits, emitter);
            add(
                Found {
                    value,
                    s: 0,
                    t,
                    emitter,
                },
                &read,
            );
        }
        if next != step::SCATTER {
            continue;
        }
        let back = -subpath.ray.direction;
        bsdf.look_up(tables, &point, point.frame.to_local(back), mode::RADIANCE);
        let incoming = if subpath.depth == 0 {
            IncomingDirection::unedited(back)
        } else {
            IncomingDirection::guess(edits, &states, &point, &bsdf, back, || sampler.next_1d())
        };
        if incoming.choice.label != 0 {
            let wi = point.frame.to_local(incoming.back);
            bsdf.look_up(tables, &point, wi, mode::RADIANCE);
        }
        let retargeted = Retargeted::new(edits, &states, incoming);
        if bsdf.has_smooth() {
            let light = sample_light(tables, sampler, &point);
            for label in 0..=MAX_EDITS as u32 {
                if light.is_some() && retargeted.labels(&point, light.direction) >> label & 1 == 0 {
                    continue;
                }
                let retargeted = retargeted.labelled(label);
                let at = Interaction::new(&point, &bsdf, -back).retargeted(&retargeted);
                let shadow_ray = evaluate_light(tables, &rules, &light, &at);
                if !shadow_ray.is_some() {
                    continue;
                }
                let scattered = Scattered::towards(&at, tables.data, light.direction);
                let before = world(&at, light.direction);
                let share = retargeted
                    .after(&point, scattered, before)
                    .reach_emitter(edits, light.emitter);
                if !(share.max_element() > 0.0) {
                    continue;
                }
                let lit = shadow_ray.unshadowed(view) * path.subpath.throughput;
                let found = Found {
                    value: lit * share,
                    s: 1,
                    t,
                    emitter: light.emitter,
                };
                if found.value.max_element() > 0.0 {
                    let read = expressions.map(|e| {
                        let automaton = &e.from_sensor;
                        read.after(e, automaton, &point, &scattered)
                    });
                    add(found, &read.unwrap_or(PathStates::DEAD));
                }
            }
        }
        let (u1, u2) = (sampler.next_1d(), sampler.next_2d());
        let at = Interaction::new(&point, &bsdf, -back).retargeted(&retargeted);
        let (sample, lobe) = bsdf.sample_lobe(tables.data, at.wi, u1, u2);
        let sample = bsdf.mix(tables.data, at.wi, sample, lobe);
        let mut turned = sample;
        let mut label = 0;
        if sample.pdf > 0.0 && sample.event & event::NULL == 0 {
            let sampled = point.frame.to_world(sample.wo).normalize();
            let departure = at.outgoing(tables, &sample, sampled, sampler);
            label = departure.label;
            turned = BsdfSample {
                weight: sample.weight * (departure.value / departure.pdf),
                pdf: sample.pdf * departure.pdf,
                ..sample
            };
            if label != 0 {
                turned.wo = point.frame.to_local(departure.direction);
            }
        }
        next = path.scatter(&rules, sampler, &point, &turned);
        if next == step::TRACE && path.subpath.depth > subpath.depth {
            let scattered = Scattered::sampled(&bsdf, tables.data, at.wi, sample.wo, sample.event);
            let before = point.frame.to_world(sample.wo).normalize();
            let retargeted = retargeted.labelled(label);
            let after = retargeted.after(&point, scattered, before);
            if after.is_none() {
                return;
            }
            states = after;
            if let Some(expressions) = expressions {
                let automaton = &expressions.from_sensor;
                read.advance(expressions, automaton, &point, &scattered);
                if expressions.only != 0 && read.is_dead() {
                    return;
                }
            }
        }
    }
}

/// A part of what a path finds.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// The light that it adds.
    pub value: Rgb,
    /// Vertices from the light.
    pub s: u32,
    /// Vertices from the sensor.
    pub t: u32,
    /// The emitter.
    pub emitter: u32,
}

/// The world direction that the BSDF knows for a true one.
pub(super) fn world(at: &Interaction<'_>, direction: Vec3) -> Vec3 {
    match at
        .retargeted
        .and_then(|retargeted| retargeted.origin(at.point, direction))
    {
        Some(origin) => origin.direction,
        None => direction,
    }
}

/// What an emitter sample adds to the radiance from the surface, before it is known whether it lies in shadow.
fn evaluate_light(
    tables: &Tables<'_>,
    rules: &PathRules,
    light: &DirectSample,
    at: &Interaction<'_>,
) -> ShadowRay {
    if !light.is_some() {
        return ShadowRay::NONE;
    }
    let point = at.point;
    let cosine = point.frame.to_local(light.direction).z;
    if !rules.allows(point, light.direction, cosine) {
        return ShadowRay::NONE;
    }
    let origin = at.retargeted.and_then(|retargeted| {
        let origin = retargeted.origin(point, light.direction)?;
        Some((origin, retargeted.value(point, &origin, light.direction)))
    });
    let Some((origin, factor)) = origin else {
        return ShadowRay::NONE;
    };
    let wo = point.frame.to_local(origin.direction);
    let (value, pdf) = at.bsdf.eval_cosine_pdf(tables.data, at.wi, wo);
    if value.max_element() <= 0.0 {
        return ShadowRay::NONE;
    }
    let pdf = pdf * origin.jacobian;
    weighted_contribution(light, point, SampleCounts::ONE, value * factor, pdf)
}

/// One sample of the pixel at absolute film coordinates, times its reconstruction weight; adds the part of each expression to
/// `parts`. Where nothing counts but the paths of the first expression, the sample is that part.
pub fn sample_pixel<T: Traverse, S: Sampler>(
    view: &SceneView<'_, T>,
    settings: &IntegratorSettings,
    edits: &Edits<'_>,
    expressions: Option<&PathExpressions<'_>>,
    sampler: &mut S,
    pixel: [u32; 2],
    parts: &mut [Rgb],
) -> Rgb {
    let seen = camera_ray(&view.tables, sampler, pixel);
    let mut whole = Vec3::ZERO;
    parts.fill(Vec3::ZERO);
    radiance(
        view,
        settings.rules,
        edits,
        expressions,
        sampler,
        &seen.ray,
        |found, read| {
            whole += found.value;
            if let Some(expressions) = expressions {
                read.divide(expressions, found.emitter, found.value * seen.weight, parts);
            }
        },
    );
    match expressions {
        Some(expressions) if expressions.only != 0 => parts[0],
        _ => whole * seen.weight,
    }
}
