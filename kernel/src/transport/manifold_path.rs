//! Path tracing that also connects to lights through refracting interfaces (Hanika, Droske and Fascione 2015).
//!
//! The walk is that of [`super::path`]. At anchors a point of a light is chosen once more, and connected through the interfaces
//! in the way ([`super::manifold_connection`]). What the walk finds behind interfaces, by hitting a light or by sampling one from the
//! last interface, counts where the connection from the anchor would not have found the same path: the mean is that of path tracing
//! wherever path tracing has one; of points that light through smooth glass it has none, and the paths of unique walks are
//! all there is.
//!
//! Hosts only, as the connections.

use super::bounce::{Rays, Shading};
use super::manifold_connection::{Anchor, connect, is_anchor, light_point, passes};
use super::path::{Path, SinglePath, step};
use super::settings::IntegratorSettings;
use crate::bsdf::Bsdf;
use crate::manifold::ChainVertex;
use crate::math::{Ray, Rgb};
use crate::path::through_interfaces::{interface, interface_vertex};
use crate::sampler::Sampler;
use crate::scene::emitter::DirectSample;
use crate::scene::{SceneView, SurfacePoint, Traverse};

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
            let is_left =
                anchor.is_some_and(|a| is_surface && a.is_found_by_walk(view, light, &mut scratch));
            if !is_left {
                radiance += driver.path.radiance;
            }
        }
        let at = driver.point;
        let before = driver.path.subpath.ray.direction;
        let depth = driver.path.subpath.depth;
        let scatters = driver.next == step::SCATTER;
        let alpha = interface(driver.bsdf).filter(|_| scatters);
        let is_anchor = scatters && is_anchor(driver.bsdf);
        driver.sample_emitter();
        driver.evaluate_emitter();
        if driver.shadow_ray.is_some() {
            let found = driver.shadow_ray.unshadowed(view);
            let is_left = found.max_element() > 0.0
                && anchor.zip(alpha).is_some_and(|(mut anchor, alpha)| {
                    let to_light = driver.light.direction;
                    let vertex = interface_vertex(&at, driver.bsdf, alpha, to_light);
                    passes(&at, before, to_light)
                        && anchor.push(vertex)
                        && sampled_light(view, &at, &driver.light)
                            .is_some_and(|light| anchor.is_found_by_walk(view, light, &mut scratch))
                });
            if !is_left {
                radiance += found;
            }
        }
        if is_anchor {
            let wi = driver.path.subpath.local_direction(&at);
            let found = connect(
                view,
                &settings.rules,
                (&at, driver.bsdf, wi),
                depth,
                driver.sampler,
                &mut scratch,
            );
            radiance += driver.path.subpath.throughput * found;
        }
        driver.sample_bsdf();
        driver.mix_lobes();
        driver.scatter();
        if driver.next == step::TRACE && driver.path.subpath.depth > depth {
            let after = driver.path.subpath.ray.direction;
            let is_discrete = driver.path.light_samples == 0.0;
            anchor = match (anchor, alpha) {
                _ if is_anchor && !is_discrete => Some(Anchor::new(&at)),
                (Some(mut anchor), Some(alpha)) if passes(&at, before, after) => {
                    let vertex = interface_vertex(&at, driver.bsdf, alpha, after);
                    anchor.push(vertex).then_some(anchor)
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
    let is_near = light.distance < f32::MAX;
    is_near
        .then(|| light_point(view, &at.spawn(light.direction), light.emitter))
        .flatten()
}
