//! Integrator plugins to the kernel's settings.

use super::BuildOptions;
use crate::scene::error::SceneError;
use crate::scene::xml::{Object, ObjectKind};
use halflight_kernel::transport::{IntegratorSettings, integrator_kind};

/// Settings and the name of the algorithm that will run.
pub(super) fn build(
    root: &Object,
    options: &BuildOptions,
) -> Result<(IntegratorSettings, String), SceneError> {
    let object = root.single_child_of(ObjectKind::Integrator)?;
    let mut settings = IntegratorSettings::PATH;
    let mut name = match (object, &options.integrator) {
        (_, Some(name)) => name.clone(),
        (Some(object), None) => object.plugin.clone(),
        (None, None) => "path".to_string(),
    };
    if let Some(object) = object {
        settings.hide_emitters = object.get_bool("hide_emitters", false)?.into();
        settings.strict_normals = object.get_bool("strict_normals", false)?.into();
        settings.max_depth = depth(object, "max_depth", -1)?;
        settings.rr_depth = depth(object, "rr_depth", 5)?;
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
        // Mitsuba 0.6: -1 takes half of the scene's size.
        let length = object.get_float("ray_length", -1.0)?;
        if length > 0.0 {
            settings.occlusion.distance = length as f32;
        }
    }
    settings.kind = match name.as_str() {
        "path" | "volpath" | "volpath_simple" | "volpathmis" => integrator_kind::PATH,
        "direct" => integrator_kind::DIRECT,
        "ao" => integrator_kind::AMBIENT_OCCLUSION,
        "bdpt" => integrator_kind::BIDIRECTIONAL,
        "ptracer" => integrator_kind::LIGHT_TRACING,
        other if options.integrator.is_some() => {
            return Err(SceneError::Request(format!(
                "there is no integrator \"{other}\"; known are path, direct, ao, ptracer and bdpt"
            )));
        }
        other => {
            if let Some(object) = object {
                object.warn(format!(
                    "the integrator \"{other}\" is not supported; \"path\" is used instead"
                ))?;
            }
            name = "path".to_string();
            integrator_kind::PATH
        }
    };
    if settings.kind == integrator_kind::DIRECT {
        settings.max_depth = settings.max_depth.min(2);
        if settings.direct.emitter_samples + settings.direct.bsdf_samples == 0 {
            return Err(object.map_or_else(
                || SceneError::Request("no samples".to_string()),
                |o| o.error("needs at least one emitter or BSDF sample"),
            ));
        }
    }
    Ok((settings, name))
}

/// A number of edges; negative means no limit.
fn depth(object: &Object, name: &str, default: i64) -> Result<u32, SceneError> {
    let value = object.get_int_in(name, default, -1, i64::from(u32::MAX))?;
    Ok(if value < 0 { u32::MAX } else { value as u32 })
}
