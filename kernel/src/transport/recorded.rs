//! Paths of path tracing, vertex by vertex, for inspection (Kaplanyan 2017, section 9.1.1.1: enriched vertices).
//!
//! A walk from the sensor notes where it scatters, how, and what it carries; whenever it meets light, or an emitter sample is
//! visible, the path is complete and is passed on with its light: that which it adds to its pixel, weighted against the other
//! technique that could have found it. So the light of all paths that are passed on adds up to the image. Where a vertex is
//! diffuse and glossy at once, it is noted as what has the larger share.

use super::bounce::{bounce, shade};
use super::path::{Path, SinglePath, step};
use super::settings::IntegratorSettings;
use crate::bsdf::Bsdf;
use crate::math::{Ray, Rgb, luminance};
use crate::path::expression::scattering;
use crate::path::{PathExpressions, PathStates, Scattered, Shares};
use crate::sampler::Sampler;
use crate::scene::{NONE, SceneView, Traverse};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// What a vertex is, beside the kinds of [`scattering`].
pub mod vertex_kind {
    use super::scattering;

    /// A point of an emitter.
    pub const LIGHT: u32 = scattering::COUNT;
    /// Light from infinity: the position is the direction towards it.
    pub const LIGHT_AT_INFINITY: u32 = scattering::COUNT + 1;
    /// The sensor.
    pub const SENSOR: u32 = scattering::COUNT + 2;
}

/// A vertex of a path that is noted.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct RecordedVertex {
    /// Where it is.
    pub position: [f32; 3],
    /// One of [`scattering`] or [`vertex_kind`].
    pub kind: u32,
    /// The shape, or the emitter of a light; [`NONE`] for the sensor.
    pub object: u32,
    /// Radiance at the sensor per radiance that arrives here; of a light, the light that the path adds.
    pub throughput: [f32; 3],
}

/// Follows one sample along `ray`, whose reconstruction weight is `weight`. `vertices` is storage for a path, from the sensor;
/// `take` gets each complete path of which the last of `expressions`, if there are any, has a share, with that share of its
/// light. Longer paths than fit end there.
pub fn record_paths<T: Traverse, S: Sampler>(
    view: &SceneView<'_, T>,
    settings: &IntegratorSettings,
    expressions: Option<&PathExpressions<'_>>,
    sampler: &mut S,
    ray: &Ray,
    weight: f32,
    vertices: &mut [RecordedVertex],
    mut take: impl FnMut(&[RecordedVertex], Rgb),
) {
    let tables = &view.tables;
    let mut bsdf = Bsdf::BLACK;
    let mut driver = SinglePath::new(view, settings.rules, sampler, &mut bsdf, Path::new(ray));
    if vertices.len() < 2 {
        return;
    }
    vertices[0] = RecordedVertex {
        position: ray.origin.to_array(),
        kind: vertex_kind::SENSOR,
        object: NONE,
        throughput: [weight; 3],
    };
    let mut count = 1;
    let mut states = expressions.map(PathStates::at_sensor);
    let last = expressions.map_or(0, |e| e.count.saturating_sub(1) as usize);
    let share = |shares: Option<Shares>| shares.map_or(Vec3::ONE, |shares| shares.of(last));
    // Storage for the vertex that is sampled and for the light.
    while driver.next != step::END && count + 2 <= vertices.len() {
        let subpath = driver.path.subpath;
        let direction = subpath.ray.direction;
        let mut behind = None;
        bounce(&mut driver, |driver| {
            shade(driver);
            let found = core::mem::take(&mut driver.path.radiance);
            if found.max_element() > 0.0 {
                let emitter = if driver.hit.is_hit() {
                    driver.point.emitter
                } else {
                    tables.info.environment
                };
                let of = expressions.zip(states.as_ref());
                let part = share(of.map(|(e, s)| s.reach_emitter(e, emitter)));
                let light = found * part * weight;
                let (position, kind) = if driver.hit.is_hit() {
                    (driver.point.position, vertex_kind::LIGHT)
                } else {
                    (direction, vertex_kind::LIGHT_AT_INFINITY)
                };
                vertices[count] = RecordedVertex {
                    position: position.to_array(),
                    kind,
                    object: emitter,
                    throughput: light.to_array(),
                };
                if light.max_element() > 0.0 {
                    take(&vertices[..count + 1], light);
                }
            }
            let point = &driver.point;
            let wi = point.frame.to_local(-direction);
            if driver.shadow_ray.is_some() {
                let wo = point.frame.to_local(driver.light.direction);
                let scattered = Scattered::smooth(driver.bsdf, tables.data, wi, wo);
                let light = &driver.light;
                let shares = expressions.zip(states.as_ref()).map(|(e, s)| {
                    let after = s.after(e, &e.from_sensor, point, &scattered);
                    after.reach_emitter(e, light.emitter)
                });
                behind = Some((scattered, share(shares)));
            }
        });
        let found = core::mem::take(&mut driver.path.radiance);
        let vertex = |scattered: &Scattered| RecordedVertex {
            position: driver.point.position.to_array(),
            kind: kind_of(scattered),
            object: driver.point.shape,
            throughput: (subpath.throughput * weight).to_array(),
        };
        if let Some((scattered, part)) = &behind {
            let light = found * *part * weight;
            if light.max_element() > 0.0 {
                let sampled = &driver.light;
                let is_infinite = sampled.distance == f32::MAX;
                vertices[count] = vertex(scattered);
                vertices[count + 1] = RecordedVertex {
                    position: if is_infinite {
                        sampled.direction.to_array()
                    } else {
                        sampled.target.to_array()
                    },
                    kind: if is_infinite {
                        vertex_kind::LIGHT_AT_INFINITY
                    } else {
                        vertex_kind::LIGHT
                    },
                    object: sampled.emitter,
                    throughput: light.to_array(),
                };
                take(&vertices[..count + 2], light);
            }
        }
        if driver.next == step::TRACE && driver.path.subpath.depth > subpath.depth {
            let wi = driver.point.frame.to_local(-direction);
            let sample = &driver.sample;
            let scattered =
                Scattered::sampled(driver.bsdf, tables.data, wi, sample.wo, sample.event);
            vertices[count] = vertex(&scattered);
            count += 1;
            if let (Some(expressions), Some(states)) = (expressions, &mut states) {
                let automaton = &expressions.from_sensor;
                states.advance(expressions, automaton, &driver.point, &scattered);
                if states.is_dead() {
                    return;
                }
            }
        }
    }
}

/// The kind that has the larger share.
fn kind_of(scattered: &Scattered) -> u32 {
    let side = u32::from(scattered.is_transmitted);
    side + if scattered.is_specular {
        scattering::SPECULAR_REFLECTION
    } else if luminance(scattered.diffuse) >= 0.5 {
        scattering::DIFFUSE_REFLECTION
    } else {
        scattering::GLOSSY_REFLECTION
    }
}
