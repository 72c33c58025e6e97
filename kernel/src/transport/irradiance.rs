//! Irradiance at what a camera ray meets: the light that falls on the side of the surface that the ray sees.
//!
//! A white diffuse surface reflects the radiance E / pi, so that E is pi times what path tracing finds where the first surface
//! is one: both its emitter samples and its own directions count. What the surface emits is left out. In W/m^2 where radiance
//! is in W/(m^2 sr).
//! Invariant (tests): pi times the radiance in a closed room of constant radiance, and cos / d^2 under a point light.

use super::bounce::{Shading, bounce, shade};
use super::divided::{DividedPath, Mixture};
use super::path::{Path, SinglePath, step};
use super::settings::IntegratorSettings;
use crate::bsdf::{Bsdf, Lobe};
use crate::math::{Ray, Rgb};
use crate::path::PathExpressions;
use crate::sampler::Sampler;
use crate::scene::{MAX_LOBES, SceneView, Traverse, lobe_flag, lobe_kind};
use core::f32::consts::PI;
use glam::Vec3;

/// One sample of the irradiance where `ray` meets a surface, zero where it meets none; of the paths alone that the first of
/// `expressions` matches, if there are any. In them the first surface is diffuse.
pub fn irradiance<T: Traverse, S: Sampler>(
    view: &SceneView<'_, T>,
    settings: &IntegratorSettings,
    expressions: Option<&PathExpressions<'_>>,
    sampler: &mut S,
    ray: &Ray,
) -> Rgb {
    let mut bsdf = Bsdf::BLACK;
    let mut divided = DividedPath::NONE;
    let mut mixture = Mixture::NONE;
    let mut parts = [Vec3::ZERO; crate::path::expression::MAX_PARTS];
    let count = expressions.map_or(0, |e| e.count as usize);
    let parts = &mut parts[..count];
    let mut driver = SinglePath::new(view, settings.rules, sampler, &mut bsdf, Path::new(ray));
    if let Some(expressions) = expressions {
        divided.begin(expressions);
    }
    let mut found = Vec3::ZERO;
    let mut is_first = true;
    while driver.next != step::END {
        let subpath = &driver.path.subpath;
        let (direction, depth) = (subpath.ray.direction, subpath.depth);
        bounce(&mut driver, |driver| {
            if is_first {
                driver.arrive();
                driver.path.radiance = Vec3::ZERO;
                if driver.next == step::SCATTER {
                    let wi = driver.path.subpath.local_direction(&driver.point);
                    *driver.bsdf = white(view.tables.data, wi);
                }
                driver.sample_emitter();
                driver.evaluate_emitter();
                driver.sample_bsdf();
                driver.mix_lobes();
                driver.scatter();
            } else {
                shade(driver);
            }
            if let Some(expressions) = expressions {
                divided.shaded(expressions, &mut mixture, driver, direction, depth, parts);
            }
        });
        is_first = is_first && driver.path.subpath.depth == 0;
        let light = driver.path.radiance;
        driver.path.radiance = Vec3::ZERO;
        if expressions.is_none() {
            found += light;
        } else if light.max_element() > 0.0 {
            divided.add_direct(&mixture, light, parts);
        }
    }
    if count > 0 { parts[0] * PI } else { found * PI }
}

/// White on the side of wi.
fn white(data: &[f32], wi: Vec3) -> Bsdf {
    let mut lobes = [Lobe::NONE; MAX_LOBES];
    lobes[0] = Lobe {
        kind: lobe_kind::DIFFUSE,
        flags: lobe_flag::FRONT | lobe_flag::BACK | lobe_flag::FLIP_BACK,
        weight: 1.0,
        reflectance: Vec3::ONE,
        ..Lobe::NONE
    };
    Bsdf::from_lobes(lobes, 1, data, wi)
}
