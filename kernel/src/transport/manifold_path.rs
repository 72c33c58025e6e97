//! Path tracing that also connects to lights through refracting interfaces (Hanika, Droske and Fascione 2015).
//!
//! The walk is that of [`super::path`]. At a vertex that is rough, an *anchor*, a point of a light is chosen once more, uniformly over
//! its surface, and connected through the interfaces that the straight line to it meets ([`crate::path::through_interfaces`]).
//! Paths that this finds are left to it: what the walk finds behind the interfaces, by hitting a light or by sampling one from the last
//! interface, counts where the connection from the anchor would not have found the same path. Which paths those are depends on
//! the paths alone, so the mean is that of path tracing wherever path tracing has one; of points that light through smooth glass it
//! has none, and the paths of unique walks are all there is.
//!
//! Hosts only, as the connections.

use super::bounce::{Rays, Shading};
use super::path::{Path, SinglePath, step};
use super::settings::IntegratorSettings;
use crate::bsdf::Bsdf;
use crate::manifold::ChainVertex;
use crate::math::{Ray, Rgb};
use crate::path::through_interfaces::{Interfaces, interface, interface_vertex};
use crate::sampler::Sampler;
use crate::scene::emitter::position::sample_position;
use crate::scene::emitter::{self, DirectSample, area_radiance, delta, select_emitter};
use crate::scene::surface::{detail, surface_with};
use crate::scene::{NONE, SceneView, SurfacePoint, Traverse, emitter_kind};
use glam::Vec3;

/// Roughness from which a vertex is connected: narrower lobes find their lights by themselves.
const ANCHOR_ROUGHNESS: f32 = 0.25;

/// The last anchor of a walk, and the interfaces that it has passed since.
#[derive(Clone, Copy)]
struct Anchor {
    point: SurfacePoint,
    /// From the anchor on; the place of the light is open.
    chain: Interfaces,
}

impl Anchor {
    /// Whether the connection from the anchor finds the path that ends at a point of a light.
    fn finds<T: Traverse>(
        mut self,
        view: &SceneView<'_, T>,
        light: ChainVertex,
        bsdf: &mut Bsdf,
    ) -> bool {
        self.chain.vertices[0] = light;
        self.chain.len > 2 && self.chain.finds(view, &self.point, bsdf)
    }
}

/// Whether two directions through a surface, one towards and one from it, pass to its other side.
#[inline]
fn passes(point: &SurfacePoint, before: Vec3, after: Vec3) -> bool {
    point.frame.n.dot(before) * point.frame.n.dot(after) > 0.0
}

/// Radiance along `ray`, one sample.
pub fn radiance<T: Traverse, S: Sampler>(
    view: &SceneView<'_, T>,
    settings: &IntegratorSettings,
    sampler: &mut S,
    ray: &Ray,
) -> Rgb {
    let (mut bsdf, mut scratch) = (Bsdf::BLACK, Bsdf::BLACK);
    let mut driver = SinglePath::new(view, settings.rules, sampler, &mut bsdf, Path::new(ray));
    let mut anchor: Option<Anchor> = None;
    let mut radiance = Rgb::ZERO;
    while driver.next != step::END {
        driver.path.radiance = Rgb::ZERO;
        driver.trace();
        driver.arrive();
        if driver.path.radiance.max_element() > 0.0 {
            let light = ChainVertex::from_surface(&driver.point);
            let is_surface = driver.hit.is_hit();
            let is_left = anchor.is_some_and(|a| is_surface && a.finds(view, light, &mut scratch));
            if !is_left {
                radiance += driver.path.radiance;
            }
        }
        let at = driver.point;
        let before = driver.path.subpath.ray.direction;
        let depth = driver.path.subpath.depth;
        let scatters = driver.next == step::SCATTER;
        let alpha = interface(driver.bsdf).filter(|_| scatters);
        let is_anchor = scatters && alpha.is_none() && driver.bsdf.roughness() > ANCHOR_ROUGHNESS;
        driver.sample_emitter();
        driver.evaluate_emitter();
        if driver.shadow_ray.is_some() {
            let found = driver.shadow_ray.unshadowed(view);
            let is_left = found.max_element() > 0.0
                && anchor.zip(alpha).is_some_and(|(mut anchor, alpha)| {
                    let to_light = driver.light.direction;
                    let vertex = interface_vertex(&at, driver.bsdf, alpha, to_light);
                    passes(&at, before, to_light)
                        && anchor.chain.push(vertex)
                        && sampled_light(view, &at, &driver.light)
                            .is_some_and(|light| anchor.finds(view, light, &mut scratch))
                });
            if !is_left {
                radiance += found;
            }
        }
        if is_anchor {
            let found = connect(&mut driver, &mut scratch);
            radiance += driver.path.subpath.throughput * found;
        }
        driver.sample_bsdf();
        driver.mix_lobes();
        driver.scatter();
        if driver.next == step::TRACE && driver.path.subpath.depth > depth {
            let after = driver.path.subpath.ray.direction;
            let is_discrete = driver.path.light_samples == 0.0;
            anchor = match (anchor, alpha) {
                _ if is_anchor && !is_discrete => Some(Anchor {
                    point: at,
                    chain: Interfaces::between(ChainVertex::NONE, &at),
                }),
                (Some(mut anchor), Some(alpha)) if passes(&at, before, after) => {
                    let vertex = interface_vertex(&at, driver.bsdf, alpha, after);
                    anchor.chain.push(vertex).then_some(anchor)
                }
                _ => None,
            };
        }
    }
    radiance
}

/// The point of a light at a finite distance that was sampled from a surface, which sees it.
fn sampled_light<T: Traverse>(
    view: &SceneView<'_, T>,
    at: &SurfacePoint,
    light: &DirectSample,
) -> Option<ChainVertex> {
    if !(light.distance < f32::MAX) {
        return None;
    }
    if light.is_delta != 0 {
        return Some(ChainVertex::point(light.target));
    }
    let ray = at.spawn(light.direction);
    let hit = view.traverse.closest_hit(&ray);
    if !hit.is_hit() {
        return None;
    }
    let point = surface_with::<{ detail::TANGENTS }>(&view.tables, &ray, &hit);
    (point.emitter == light.emitter).then(|| ChainVertex::from_surface(&point))
}

/// The light that an anchor, where the walk stands, scatters back from a point of a light behind interfaces.
fn connect<T: Traverse, S: Sampler>(driver: &mut SinglePath<'_, T, S>, scratch: &mut Bsdf) -> Rgb {
    let (view, rules) = (driver.view, driver.rules);
    let tables = &view.tables;
    let at = driver.point;
    let u_select = driver.sampler.next_1d();
    let u = driver.sampler.next_2d();
    let emitter = select_emitter(tables, u_select);
    if emitter == NONE {
        return Rgb::ZERO;
    }
    let record = &tables.emitters[emitter as usize];
    let mut pdf = record.selection_pdf;
    let mut point = SurfacePoint::ZERO;
    let light = if record.kind == emitter_kind::AREA {
        let (sampled, density) = sample_position(tables, emitter, u);
        point = sampled;
        pdf *= density;
        ChainVertex::from_surface(&sampled)
    } else {
        let sampled = emitter::sample_emitter(tables, emitter, at.position, u);
        if !(sampled.distance < f32::MAX) {
            return Rgb::ZERO;
        }
        ChainVertex::point(sampled.target)
    };
    let Some(line) = Interfaces::on_line(view, &light, &at, scratch) else {
        return Rgb::ZERO;
    };
    // Edges to the anchor, and those of the chain.
    let edges = driver.path.subpath.depth as usize + line.len;
    if edges > rules.max_depth as usize {
        return Rgb::ZERO;
    }
    let (target, density) = line.draw(driver.sampler);
    let carried = line
        .with(view, &target)
        .and_then(|found| found.carried(tables, &rules, scratch));
    let Some(carried) = carried else {
        return Rgb::ZERO;
    };
    let wo = at.frame.to_local(carried.direction);
    if !rules.allows(&at, carried.direction, wo.z) {
        return Rgb::ZERO;
    }
    let wi = driver.path.subpath.local_direction(&at);
    let scattered = driver.bsdf.eval_cosine(tables.data, wi, wo);
    let emitted = if record.kind == emitter_kind::AREA {
        area_radiance(tables, &point, carried.outgoing)
    } else {
        delta::intensity(tables, emitter, carried.outgoing)
    };
    let value = scattered * carried.value * emitted / (pdf * density);
    if value.is_finite() { value } else { Rgb::ZERO }
}
