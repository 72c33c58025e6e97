//! Integrator plugins to the kernel's settings.
//!
//! Some integrators enclose others and add to their results: `aov`, `moment`, `adaptive`, `irrcache`, and `multichannel` with
//! its `field`s. The enclosed integrator runs, with its own parameters; the additions become layers of the image.

use super::chain_settings::{read_chains, redistribute, with_half_vectors, with_manifold};
use super::integrator_properties;
use super::options::BuildOptions;
use super::regularization;
use crate::film::aov::{Aov, AovSet};
use crate::integrators::{self, INTEGRATORS};
use crate::scene::error::SceneError;
use crate::scene::xml::{Object, ObjectKind};
use halflight_kernel::transport::markov::primary_space::technique;
use halflight_kernel::transport::photon::nearest::MOST_NEAREST;
use halflight_kernel::transport::settings::{PhotonSettings, RegularizationSettings};
use halflight_kernel::transport::{IntegratorSettings, integrator_kind};
use std::sync::Arc;

/// Deeper nesting is a mistake.
const MAX_DEPTH: usize = 16;

/// Most light walks of a pass: their photons take some hundred gigabytes.
const MAX_PHOTONS: i64 = 1 << 28;

/// The integrator that will run.
pub(super) struct Integrator {
    /// Its parameters, but for what depends on the size of the scene: see [`Integrator::settings_in`].
    pub settings: IntegratorSettings,
    /// Length of the rays of ambient occlusion, if it is given.
    ray_length: Option<f32>,
    /// Its name.
    pub name: String,
    /// Additional layers of the image.
    pub layers: AovSet,
}

impl Integrator {
    /// The parameters in a scene of a radius.
    pub(super) fn settings_in(&self, radius: f32) -> IntegratorSettings {
        let mut settings = self.settings;
        if let Some(length) = self.ray_length {
            // The kernel has it as a share of the radius, which is not known while the integrator is read.
            settings.occlusion.distance = length / radius;
        }
        settings
    }
}

/// The algorithm that will run.
pub(super) fn build(root: &Object, options: &BuildOptions) -> Result<Integrator, SceneError> {
    let mut layers = AovSet::NONE;
    let object = root.single_child_of(ObjectKind::Integrator)?;
    let object = match object {
        Some(object) => Some(innermost(object, &mut layers, 0)?),
        None => None,
    };
    let mut settings = IntegratorSettings::PATH;
    let mut ray_length = None;
    let mut name = match (object, &options.integrator) {
        (_, Some(name)) => name.clone(),
        (Some(object), None) => object.plugin.clone(),
        (None, None) => "path".to_string(),
    };
    if let Some(object) = object {
        // How the work is divided.
        for name in ["samples_per_pass", "block_size"] {
            object.get(name);
        }
        settings.rules.hide_emitters = object.get_bool("hide_emitters", false)?.into();
        settings.rules.strict_normals = object.get_bool("strict_normals", false)?.into();
        settings.rules.max_depth = depth(object, "max_depth", -1)?;
        settings.rules.rr_depth = depth(object, "rr_depth", 5)?;
        let shading = object.get_int_in("shading_samples", 1, 0, 1 << 20)?;
        settings.direct.emitter_samples =
            object.get_int_in("emitter_samples", shading, 0, 1 << 20)? as u32;
        settings.direct.bsdf_samples =
            object.get_int_in("bsdf_samples", shading, 0, 1 << 20)? as u32;
        if object.plugin == "ao" {
            settings.occlusion.samples =
                object.get_int_in("shading_samples", 1, 1, 1 << 20)? as u32;
        }
        settings.bidirectional.light_image = object.get_bool("light_image", true)?.into();
        settings.bidirectional.sample_direct = object.get_bool("sample_direct", true)?.into();
        settings.bidirectional.connections =
            object.get_int_in("connections", 0, 0, 1 << 10)? as u32;
        read_photon_settings(object, &mut settings.photon)?;
        read_chains(object, &mut settings.chains)?;
        regularization::read(object, &mut settings.regularization)?;
        // Mitsuba 0.6: -1 takes half of the scene's radius.
        let length = object.get_float("ray_length", -1.0)?;
        ray_length = (length > 0.0).then_some(length as f32);
    }
    if let (Some(object), None) = (object, &options.integrator)
        && object.is_literal
    {
        integrator_properties::warn_of_others(object)?;
    }
    let integrator = integrators::find(&name);
    settings.kind = match integrator {
        Some(integrator) => integrator.kind,
        None if options.integrator.is_some() => {
            return Err(SceneError::Request(format!(
                "there is no integrator \"{name}\"; known are {}",
                integrators::names(INTEGRATORS.iter())
            )));
        }
        None => {
            if let Some(object) = object {
                object.warn(format!(
                    "the integrator \"{name}\" is not supported; \"path\" is used instead"
                ))?;
            }
            name = "path".to_string();
            integrator_kind::PATH
        }
    };
    // Other names mean the same.
    match integrator.map_or("path", |i| i.name) {
        "mmlt" => settings.chains.technique = technique::MULTIPLEXED,
        "memlt" => with_manifold(&mut settings.chains),
        "hslt" => with_half_vectors(&mut settings.chains),
        "meerpt" => {
            redistribute(object.map(|o| &**o), &mut settings.chains)?;
            with_manifold(&mut settings.chains);
        }
        "erpt" => redistribute(object.map(|o| &**o), &mut settings.chains)?,
        _ => {}
    }
    settings.photon.connections = u32::from(name == "vcm");
    if settings.kind == integrator_kind::DIRECT {
        settings.rules.max_depth = settings.rules.max_depth.min(2);
        if settings.direct.emitter_samples + settings.direct.bsdf_samples == 0 {
            return Err(object.map_or_else(
                || SceneError::Request("no samples".to_string()),
                |o| o.error("needs at least one emitter or BSDF sample"),
            ));
        }
    }
    if let Some(reason) = regularization::refusal(&settings) {
        settings.regularization = RegularizationSettings::NONE;
        if let Some(object) = object {
            object.warn(format!("{reason}; \"{name}\" runs without"))?;
        }
    }
    Ok(Integrator {
        settings,
        ray_length,
        name,
        layers,
    })
}

/// What photon mapping reads, under the names of Mitsuba 0.6.
fn read_photon_settings(object: &Object, photon: &mut PhotonSettings) -> Result<(), SceneError> {
    if object.properties.contains("photon_count") {
        photon.photon_count = object.get_int_in("photon_count", 1, 1, MAX_PHOTONS)? as u32;
    }
    photon.alpha = object.get_float_in("alpha", photon.alpha.into(), 0.0, 1.0)? as f32;
    photon.initial_radius = object.get_float_in("initial_radius", 0.0, 0.0, 1e30)? as f32;
    let nearest = i64::from(photon.nearest);
    photon.nearest = object.get_int_in("nearest", nearest, 0, i64::from(MOST_NEAREST))? as u32;
    let (least, largest) = (photon.least_radius.into(), photon.largest_radius.into());
    photon.least_radius = object.get_float_in("min_radius", least, 0.0, 1.0)? as f32;
    photon.largest_radius = object.get_float_in("max_radius", largest, 0.0, 1.0)? as f32;
    let roughness = photon.gather_roughness.into();
    photon.gather_roughness = object.get_float_in("gather_roughness", roughness, 0.0, 1.0)? as f32;
    Ok(())
}

/// The integrator inside of those that only add to it.
fn innermost<'a>(
    object: &'a Arc<Object>,
    layers: &mut AovSet,
    depth: usize,
) -> Result<&'a Arc<Object>, SceneError> {
    object.touch();
    match object.plugin.as_str() {
        "aov" => {
            // Names of layers and what they hold, `dd:depth,nn:sh_normal`.
            let list = object.get_string("aovs", "")?.to_owned();
            for item in list
                .split(',')
                .map(str::trim)
                .filter(|item| !item.is_empty())
            {
                let kind = item.rsplit(':').next().unwrap_or(item).trim();
                add_layer(object, "aovs", kind, layers)?;
            }
        }
        "moment" => *layers = layers.with(Aov::Variance),
        "multichannel" => {}
        "adaptive" | "irrcache" => {
            let instead = if object.plugin == "adaptive" {
                "all pixels get the same number of samples (--adaptive spreads them by the error)"
            } else {
                "nothing is cached or interpolated"
            };
            object.warn(format!(
                "the integrator \"{}\" is not supported: what it holds runs alone, and {instead}",
                object.plugin
            ))?;
            object.ignore();
        }
        _ => return Ok(object),
    }
    if depth >= MAX_DEPTH {
        return Err(object.error("integrators are nested too deeply"));
    }
    let mut found = None;
    for child in object.children_of(ObjectKind::Integrator) {
        if child.object.plugin == "field" {
            let field = child.object.require_string("field")?.to_owned();
            child.object.get("undefined");
            add_layer(child.object, "field", &field, layers)?;
        } else if found.is_some() {
            child
                .object
                .warn("a second integrator within another is not supported; it is left out")?;
            child.object.ignore();
        } else {
            found = Some(child.object);
        }
    }
    let inner = found.ok_or_else(|| object.error("needs a nested integrator"))?;
    innermost(inner, layers, depth + 1)
}

/// Adds the layer of an `aov` or a `field`, under the names of both versions.
fn add_layer(
    object: &Object,
    property: &str,
    kind: &str,
    layers: &mut AovSet,
) -> Result<(), SceneError> {
    let layer = match kind {
        "depth" | "distance" => Aov::Depth,
        "position" => Aov::Position,
        "uv" => Aov::Uv,
        "sh_normal" | "shNormal" => Aov::Normal,
        "albedo" => Aov::Albedo,
        other => {
            return object.property_warn(
                property,
                format!("layers of \"{other}\" are not supported; it is left out"),
            );
        }
    };
    *layers = layers.with(layer);
    Ok(())
}

/// A number of edges; negative means no limit.
fn depth(object: &Object, name: &str, default: i64) -> Result<u32, SceneError> {
    let value = object.get_int_in(name, default, -1, i64::from(u32::MAX))?;
    Ok(if value < 0 { u32::MAX } else { value as u32 })
}
