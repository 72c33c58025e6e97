//! Parameters that several BSDF plugins share: indices of refraction, roughness, and a neutral lobe to fill.

use crate::scene::build::builder::Builder;
use crate::scene::build::texture::MeshAttributes;
use crate::scene::color::ColorUse;
use crate::scene::error::SceneError;
use crate::scene::ior;
use crate::scene::xml::Object;
use halflight_kernel::scene::{
    CoatRecord, LobeRecord, MAX_COATS, NONE, RgbParameter, ScalarParameter, distribution, lobe_flag,
};

/// Roughness below which a microfacet model counts as the smooth one.
const MIN_ALPHA: f64 = 1e-4;

impl Builder {
    /// `material`, or `eta` and `k`, which may be textures.
    pub(super) fn conductor_index(
        &mut self,
        object: &Object,
        mesh: Option<&MeshAttributes>,
        lobe: &mut LobeRecord,
    ) -> Result<(), SceneError> {
        if object.texture("eta").is_some() || object.texture("k").is_some() {
            lobe.eta = self.rgb_parameter(object, "eta", ColorUse::Unbounded, [0.0; 3], mesh)?;
            lobe.k = self.rgb_parameter(object, "k", ColorUse::Unbounded, [1.0; 3], mesh)?;
            return Ok(());
        }
        let conductor = ior::get_conductor(object)?;
        // Mitsuba 0.6 gives the index relative to vacuum and the surroundings apart, which are air.
        let surroundings = if object.is_legacy { "air" } else { "vacuum" };
        let surroundings = ior::dielectric(surroundings).unwrap_or(1.0);
        let outside = ior::get_dielectric(object, "ext_eta", surroundings)? as f32;
        lobe.eta = RgbParameter::constant(conductor.eta.map(|eta| eta / outside));
        lobe.k = RgbParameter::constant(conductor.k.map(|k| k / outside));
        Ok(())
    }

    /// `distribution`, `alpha` or `alpha_u` and `alpha_v`.
    pub(super) fn roughness(
        &mut self,
        object: &Object,
        mesh: Option<&MeshAttributes>,
        lobe: &mut LobeRecord,
    ) -> Result<(), SceneError> {
        lobe.distribution = match object.get_string("distribution", "beckmann")? {
            "beckmann" => distribution::BECKMANN,
            "ggx" => distribution::GGX,
            // Mitsuba 0.6 calls the anisotropic form by its authors.
            "phong" | "as" => distribution::PHONG,
            "epd" => {
                lobe.exponent = self.scalar_parameter(object, "exponent", 1.0, mesh)?;
                distribution::EXPONENTIAL_POWER
            }
            other => {
                object.warn(format!(
                    "the distribution \"{other}\" is not supported; \"beckmann\" is used instead"
                ))?;
                distribution::BECKMANN
            }
        };
        if !object.get_bool("sample_visible", true)? {
            lobe.flags |= lobe_flag::SAMPLE_ALL_NORMALS;
        }
        let alpha = self.scalar_parameter(object, "alpha", 0.1, mesh)?;
        lobe.alpha_u = if object.has("alpha_u") {
            self.scalar_parameter(object, "alpha_u", 0.1, mesh)?
        } else {
            alpha
        };
        lobe.alpha_v = if object.has("alpha_v") {
            self.scalar_parameter(object, "alpha_v", 0.1, mesh)?
        } else {
            alpha
        };
        for (name, parameter) in [
            ("alpha_u", &mut lobe.alpha_u),
            ("alpha_v", &mut lobe.alpha_v),
        ] {
            let named = if object.has(name) { name } else { "alpha" };
            check_alpha(object, named, parameter)?;
        }
        Ok(())
    }
}

/// Keeps a constant roughness in the models' domain.
fn check_alpha(
    object: &Object,
    name: &str,
    parameter: &mut ScalarParameter,
) -> Result<(), SceneError> {
    if parameter.texture != NONE {
        return Ok(());
    }
    if parameter.value < 0.0 {
        return Err(object.property_error(name, "a roughness cannot be negative"));
    }
    parameter.value = parameter.value.max(MIN_ALPHA as f32);
    Ok(())
}

/// Interior over exterior index of refraction.
pub(super) fn relative_index(object: &Object, interior: &str) -> Result<f32, SceneError> {
    if let Some(eta) = object.opt_float("eta")? {
        if eta <= 0.0 {
            return Err(object.property_error("eta", "an index of refraction must be positive"));
        }
        return Ok(eta as f32);
    }
    let named = |name: &str| ior::dielectric(name).unwrap_or(1.0);
    let inside = ior::get_dielectric(object, "int_ior", named(interior))?;
    let outside = ior::get_dielectric(object, "ext_ior", named("air"))?;
    Ok((inside / outside) as f32)
}

/// A lobe with neutral parameters.
pub(super) fn empty_lobe(kind: u32) -> LobeRecord {
    LobeRecord {
        kind,
        distribution: distribution::BECKMANN,
        flags: 0,
        first_factor: 0,
        factor_count: 0,
        frame: NONE,
        reflectance: RgbParameter::constant([0.0; 3]),
        specular_reflectance: RgbParameter::constant([1.0; 3]),
        specular_transmittance: RgbParameter::constant([1.0; 3]),
        eta: RgbParameter::constant([1.0; 3]),
        k: RgbParameter::constant([0.0; 3]),
        alpha_u: ScalarParameter::constant(0.1),
        alpha_v: ScalarParameter::constant(0.1),
        table: NONE,
        table_rows: 1,
        internal_reflectance: 0.0,
        optical_depth: RgbParameter::constant([0.0; 3]),
        coat_count: 0,
        coats: [CoatRecord::NONE; MAX_COATS],
        exponent: ScalarParameter::constant(1.0),
    }
}
