//! `principled`: Disney's model as Mitsuba 3 has it, from lobes whose weights are its mixing parameters.
//!
//! | parameter | meaning | default |
//! |---|---|---|
//! | `base_color` | colour, texture | 0.5 |
//! | `roughness`, `anisotropic` | number or texture | 0.5, 0 |
//! | `metallic`, `spec_trans` | number or texture | 0, 0 |
//! | `eta`, or `specular` | index inside over outside, or what gives it by 2 / (1 - sqrt(0.08 s)) - 1 | 0.5 |
//! | `spec_tint`, `sheen`, `sheen_tint`, `flatness`, `clearcoat`, `clearcoat_gloss` | number or texture | 0 |
//!
//! With m for `metallic`, t for `spec_trans` and s for `spec_tint`, the lobes are: the diffuse part with the weight (1 - m)(1 - t) and the
//! sheen with (1 - m), on the outside; the reflection of a dielectric on the outside with (1 - m)(1 - s), its tinted form with (1 - m) s,
//! and that of a metal with m; refraction from both sides, and reflection inside, with (1 - m) t; the clear coat on the
//! outside. Their sum is the model of Mitsuba 3 (tested against its values).

use super::context::{Context, PendingLobe};
use super::parameters::empty_lobe;
use crate::scene::build::builder::Builder;
use crate::scene::build::texture::MeshAttributes;
use crate::scene::color::ColorUse;
use crate::scene::error::SceneError;
use crate::scene::xml::Object;
use halflight_kernel::scene::{
    LobeRecord, NONE, RgbParameter, ScalarParameter, WeightFactor, distribution, lobe_flag,
    lobe_kind,
};
use std::sync::Arc;

/// A factor of a lobe's weight, or nothing where it is one.
pub(super) fn factor(parameter: ScalarParameter, complement: bool) -> Option<WeightFactor> {
    let neutral = if complement { 0.0 } else { 1.0 };
    let is_neutral = parameter.texture == NONE && parameter.value == neutral;
    (!is_neutral).then_some(WeightFactor {
        parameter,
        complement: complement.into(),
    })
}

/// Whether a parameter has a value everywhere.
pub(super) fn is_constant(parameter: &ScalarParameter, value: f32) -> bool {
    parameter.texture == NONE && parameter.value == value
}

/// A parameter between 0 and 1.
pub(super) fn unit_parameter(
    builder: &mut Builder,
    object: &Object,
    name: &str,
    default: f64,
    mesh: Option<&MeshAttributes>,
) -> Result<ScalarParameter, SceneError> {
    let parameter = builder.scalar_parameter(object, name, default, mesh)?;
    if parameter.texture == NONE && !(0.0..=1.0).contains(&parameter.value) {
        return Err(object.property_error(name, "is not within [0, 1]"));
    }
    Ok(parameter)
}

impl Builder {
    /// The lobes of `principled`.
    pub(super) fn principled(
        &mut self,
        object: &Arc<Object>,
        context: &Context<'_>,
        lobes: &mut Vec<PendingLobe>,
    ) -> Result<(), SceneError> {
        let mesh = context.mesh;
        let unit = |builder: &mut Builder, name: &str, default: f64| {
            unit_parameter(builder, object, name, default, mesh)
        };
        let base_color =
            self.rgb_parameter(object, "base_color", ColorUse::Reflectance, [0.5; 3], mesh)?;
        let roughness = unit(self, "roughness", 0.5)?;
        let anisotropic = unit(self, "anisotropic", 0.0)?;
        let metallic = unit(self, "metallic", 0.0)?;
        let spec_trans = unit(self, "spec_trans", 0.0)?;
        let spec_tint = unit(self, "spec_tint", 0.0)?;
        let sheen = unit(self, "sheen", 0.0)?;
        let sheen_tint = unit(self, "sheen_tint", 0.0)?;
        let flatness = unit(self, "flatness", 0.0)?;
        let coat = unit(self, "clearcoat", 0.0)?;
        let gloss = unit(self, "clearcoat_gloss", 0.0)?;
        let eta = principled_index(object)?;

        let lobe = |kind: u32| {
            let mut lobe = empty_lobe(kind);
            lobe.distribution = distribution::GGX;
            lobe.flags = lobe_flag::PRINCIPLED_ROUGHNESS;
            lobe.reflectance = base_color;
            lobe.alpha_u = roughness;
            lobe.alpha_v = anisotropic;
            lobe.eta = RgbParameter::constant([eta; 3]);
            lobe
        };
        let (dielectric, opaque) = (factor(metallic, true), factor(spec_trans, true));
        let outside = lobe_flag::FRONT;
        let inside = lobe_flag::BACK;
        let is_metal = is_constant(&metallic, 1.0);

        // Each with the factors of its weight, and the side on which it exists.
        let mut parts: Vec<(LobeRecord, Vec<Option<WeightFactor>>, u32)> = Vec::new();
        if !is_metal && !is_constant(&spec_trans, 1.0) {
            let mut part = lobe(lobe_kind::PRINCIPLED_DIFFUSE);
            part.exponent = flatness;
            parts.push((part, vec![dielectric, opaque], outside));
        }
        if !is_metal && !is_constant(&sheen, 0.0) {
            let mut part = lobe(lobe_kind::SHEEN);
            part.specular_reflectance = of_scalar(sheen);
            part.exponent = sheen_tint;
            parts.push((part, vec![dielectric], outside));
        }
        if !is_metal && !is_constant(&spec_tint, 1.0) {
            let part = lobe(lobe_kind::ROUGH_COAT);
            let factors = [dielectric, factor(spec_tint, true)];
            parts.push((part, factors.to_vec(), outside));
        }
        if !is_metal && !is_constant(&spec_tint, 0.0) {
            let mut part = lobe(lobe_kind::SCHLICK_REFLECTION);
            part.flags |= lobe_flag::TINTED;
            let factors = [dielectric, factor(spec_tint, false)];
            parts.push((part, factors.to_vec(), outside));
        }
        if !is_constant(&metallic, 0.0) {
            let part = lobe(lobe_kind::SCHLICK_REFLECTION);
            parts.push((part, vec![factor(metallic, false)], outside));
        }
        if !is_metal && !is_constant(&spec_trans, 0.0) {
            let factors = [dielectric, factor(spec_trans, false)];
            let mut part = lobe(lobe_kind::ROUGH_DIELECTRIC);
            part.flags |= lobe_flag::ROOT_TRANSMITTANCE;
            part.specular_transmittance = base_color;
            parts.push((part, factors.to_vec(), inside));
            // What is reflected outside is in the lobes above.
            part.specular_reflectance = RgbParameter::constant([0.0; 3]);
            parts.push((part, factors.to_vec(), outside));
        }
        if !is_constant(&coat, 0.0) {
            let mut part = lobe(lobe_kind::CLEARCOAT);
            part.flags = 0;
            part.specular_reflectance = of_scalar(coat);
            part.exponent = gloss;
            parts.push((part, Vec::new(), outside));
        }
        for (record, factors, side) in parts {
            let mut context = context.clone();
            // Of a two-sided material the back is a copy of the front.
            if context.sides & lobe_flag::FLIP_BACK == 0 {
                context.sides &= side;
            }
            if context.sides != 0 {
                context.factors.extend(factors.iter().flatten());
                self.push_lobe(object, record, context, lobes)?;
            }
        }
        Ok(())
    }
}

/// A number in every channel; its texture counts by its colour.
pub(super) fn of_scalar(parameter: ScalarParameter) -> RgbParameter {
    RgbParameter {
        value: [parameter.value; 3],
        texture: parameter.texture,
    }
}

/// The index of refraction, from `eta` or `specular`.
fn principled_index(object: &Object) -> Result<f32, SceneError> {
    if let Some(eta) = object.opt_float("eta")? {
        if object.has("specular") {
            return Err(object.property_error("specular", "cannot be given together with \"eta\""));
        }
        if eta < 1.0 {
            return Err(object.property_error("eta", "must be at least 1"));
        }
        return Ok(eta as f32);
    }
    let specular = object.get_float_in("specular", 0.5, 0.0, 1.0)?;
    // No reflection is not in the model's domain: the index stays a little above that of the surroundings.
    let specular = specular.max(1e-3);
    Ok((2.0 / (1.0 - (0.08 * specular).sqrt()) - 1.0) as f32)
}
