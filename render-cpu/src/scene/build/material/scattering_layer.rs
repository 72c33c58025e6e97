//! `hk` of Mitsuba 0.6: single scattering in a thin layer ([`halflight_kernel::bsdf::hanrahan_krueger`]).
//!
//! | parameter | meaning | default |
//! |---|---|---|
//! | `material` | one of the media that Jensen et al. measured | skin1 |
//! | `sigmaS` and `sigmaA` | coefficients of scattering and of absorption, colours or textures | the material's |
//! | `sigmaT` and `albedo` | the same by their sum, a colour or texture | |
//! | `thickness` | of the layer, in the unit of the coefficients | 1 |
//! | a nested phase function | `isotropic`, or `hg` with the mean cosine `g` (0.8) | isotropic |

use super::parameters::empty_lobe;
use crate::scene::build::builder::Builder;
use crate::scene::build::texture::MeshAttributes;
use crate::scene::color::ColorUse;
use crate::scene::error::SceneError;
use crate::scene::xml::{Object, ObjectKind};
use halflight_kernel::bsdf::hanrahan_krueger::{LARGEST_DEPTH, layer_parameters};
use halflight_kernel::scene::{LobeRecord, RgbParameter, ScalarParameter, lobe_kind};

/// Names, reduced scattering and absorption of red, green and blue light per millimetre: Jensen et al. 2001, "A Practical Model
/// for Subsurface Light Transport", figure 5.
const MEDIA: &[(&str, [f32; 3], [f32; 3])] = &[
    ("apple", [2.29, 2.39, 1.97], [0.003, 0.0034, 0.046]),
    ("chicken1", [0.15, 0.21, 0.38], [0.015, 0.077, 0.19]),
    ("chicken2", [0.19, 0.25, 0.32], [0.018, 0.088, 0.2]),
    ("cream", [7.38, 5.47, 3.15], [0.0002, 0.0028, 0.0163]),
    ("ketchup", [0.18, 0.07, 0.03], [0.061, 0.97, 1.45]),
    ("marble", [2.19, 2.62, 3.0], [0.0021, 0.0041, 0.0071]),
    ("potato", [0.68, 0.7, 0.55], [0.0024, 0.009, 0.12]),
    ("skimmilk", [0.7, 1.22, 1.9], [0.0014, 0.0025, 0.0142]),
    ("skin1", [0.74, 0.88, 1.01], [0.032, 0.17, 0.48]),
    ("skin2", [1.09, 1.59, 1.79], [0.013, 0.07, 0.145]),
    ("spectralon", [11.6, 20.4, 14.9], [0.0; 3]),
    ("wholemilk", [2.55, 3.21, 3.77], [0.0011, 0.0024, 0.014]),
];

/// The material of `hk` without any parameter.
const SKIN: &str = "skin1";

impl Builder {
    /// The lobe of `hk`.
    pub(super) fn scattering_layer(
        &mut self,
        object: &Object,
        mesh: Option<&MeshAttributes>,
    ) -> Result<LobeRecord, SceneError> {
        let mut lobe = empty_lobe(lobe_kind::HANRAHAN_KRUEGER);
        let thickness = object.get_float("thickness", 1.0)?;
        // Also where it is not a number.
        if !(thickness >= 0.0) {
            return Err(object.property_error("thickness", "cannot be negative"));
        }
        // An infinite layer lets nothing pass.
        let thickness = thickness.min(f64::from(LARGEST_DEPTH)) as f32;
        let (scattering, absorption) = medium(object)?;
        let usage = ColorUse::Unbounded;
        let by_sum = object.has("sigma_t") || object.has("albedo");
        if by_sum {
            if object.has("sigma_s") || object.has("sigma_a") {
                let name = if object.has("sigma_t") {
                    "sigma_t"
                } else {
                    "albedo"
                };
                return Err(object.property_error(
                    name,
                    "cannot be given together with the coefficients of scattering and absorption",
                ));
            }
            let sum = [0, 1, 2].map(|c| scattering[c] + absorption[c]);
            let albedo = [0, 1, 2].map(|c| scattering[c] / sum[c].max(f32::MIN_POSITIVE));
            lobe.distribution = layer_parameters::ALBEDO;
            lobe.reflectance =
                self.rgb_parameter(object, "albedo", ColorUse::Reflectance, albedo, mesh)?;
            lobe.specular_transmittance =
                self.rgb_parameter(object, "sigma_t", usage, sum, mesh)?;
        } else {
            lobe.distribution = layer_parameters::DEPTHS;
            lobe.reflectance = self.rgb_parameter(object, "sigma_s", usage, scattering, mesh)?;
            scale(&mut lobe.reflectance, thickness);
            lobe.specular_transmittance =
                self.rgb_parameter(object, "sigma_a", usage, absorption, mesh)?;
        }
        scale(&mut lobe.specular_transmittance, thickness);
        lobe.exponent = ScalarParameter::constant(mean_cosine(object)?);
        Ok(lobe)
    }
}

/// Depths of coefficients.
fn scale(parameter: &mut RgbParameter, thickness: f32) {
    parameter.value = parameter.value.map(|v| v * thickness);
}

/// Scattering and absorption of the `material`.
fn medium(object: &Object) -> Result<([f32; 3], [f32; 3]), SceneError> {
    let name = object.get_string("material", SKIN)?;
    let find = |name: &str| {
        MEDIA
            .iter()
            .find(|medium| medium.0.eq_ignore_ascii_case(name))
    };
    let found = match find(name) {
        Some(found) => Some(found),
        None => {
            object.property_warn(
                "material",
                format!("the medium \"{name}\" is not known; \"{SKIN}\" is used instead"),
            )?;
            find(SKIN)
        }
    };
    Ok(found.map_or(([0.0; 3], [0.0; 3]), |medium| (medium.1, medium.2)))
}

/// g of the nested phase function.
fn mean_cosine(object: &Object) -> Result<f32, SceneError> {
    let Some(phase) = object.single_child_of(ObjectKind::Phase)? else {
        return Ok(0.0);
    };
    phase.touch();
    match phase.plugin.as_str() {
        "isotropic" => Ok(0.0),
        "hg" => {
            let g = phase.get_float("g", 0.8)?;
            if !(g.abs() < 1.0) {
                return Err(phase.property_error("g", "must be between -1 and 1"));
            }
            Ok(g as f32)
        }
        other => {
            phase.warn(format!(
                "phase functions of type \"{other}\" are not supported; light is scattered evenly"
            ))?;
            Ok(0.0)
        }
    }
}
