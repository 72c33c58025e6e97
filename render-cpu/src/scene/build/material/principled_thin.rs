//! `principledthin`: Disney's model for thin sheets as Mitsuba 3 has it, from lobes whose weights are its mixing parameters.
//!
//! | parameter | meaning | default |
//! |---|---|---|
//! | `base_color` | colour, texture | 0.5 |
//! | `roughness`, `anisotropic` | number or texture | 0.5, 0 |
//! | `spec_trans` | share of the specular sheet, number or texture | 0 |
//! | `diff_trans` | 0 to 2: half of it is the share of diffuse light that passes, number or texture | 0 |
//! | `eta` | index of the sheet over that of its surroundings | 1.5 |
//! | `spec_tint`, `sheen`, `sheen_tint`, `flatness` | number or texture | 0 |
//!
//! With t for `spec_trans`, d for half of `diff_trans` and s for `spec_tint`, the lobes are: the diffuse part and the sheen with the
//! weight (1 - t)(1 - d), diffuse transmission with (1 - t) d, the reflection of a dielectric with t (1 - s), its tinted form with
//! t s, and what passes the sheet with t. Both sides are alike. The blur of what passes has the roughness r (0.65 eta - 0.35), as
//! light is refracted back as it leaves (Burley 2015).

use super::context::{Context, PendingLobe};
use super::parameters::empty_lobe;
use super::principled::{factor, is_constant, of_scalar, unit_parameter};
use crate::scene::build::builder::Builder;
use crate::scene::color::ColorUse;
use crate::scene::error::SceneError;
use crate::scene::xml::Object;
use halflight_kernel::scene::{
    LobeRecord, NONE, RgbParameter, WeightFactor, distribution, lobe_flag, lobe_kind,
};
use std::sync::Arc;

impl Builder {
    /// The lobes of `principledthin`.
    pub(super) fn principled_thin(
        &mut self,
        object: &Arc<Object>,
        context: &Context<'_>,
        lobes: &mut Vec<PendingLobe>,
    ) -> Result<(), SceneError> {
        let mesh = context.mesh;
        let base_color =
            self.rgb_parameter(object, "base_color", ColorUse::Reflectance, [0.5; 3], mesh)?;
        let mut unit = |name: &str, default: f64| unit_parameter(self, object, name, default, mesh);
        let roughness = unit("roughness", 0.5)?;
        let anisotropic = unit("anisotropic", 0.0)?;
        let specular = unit("spec_trans", 0.0)?;
        let spec_tint = unit("spec_tint", 0.0)?;
        let sheen = unit("sheen", 0.0)?;
        let sheen_tint = unit("sheen_tint", 0.0)?;
        let flatness = unit("flatness", 0.0)?;
        let mut passing = self.scalar_parameter(object, "diff_trans", 0.0, mesh)?;
        if passing.texture == NONE && !(0.0..=2.0).contains(&passing.value) {
            return Err(object.property_error("diff_trans", "is not within [0, 2]"));
        }
        passing.value *= 0.5;
        let eta = object.get_float_in("eta", 1.5, 1.0, 100.0)? as f32;

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
        let diffuse = factor(specular, true);
        // Each with the factors of its weight.
        let mut parts: Vec<(LobeRecord, [Option<WeightFactor>; 2])> = Vec::new();
        if !is_constant(&specular, 1.0) && !is_constant(&passing, 1.0) {
            let factors = [diffuse, factor(passing, true)];
            let mut part = lobe(lobe_kind::PRINCIPLED_DIFFUSE);
            part.exponent = flatness;
            parts.push((part, factors));
            if !is_constant(&sheen, 0.0) {
                let mut part = lobe(lobe_kind::SHEEN);
                part.specular_reflectance = of_scalar(sheen);
                part.exponent = sheen_tint;
                parts.push((part, factors));
            }
        }
        if !is_constant(&specular, 1.0) && !is_constant(&passing, 0.0) {
            let mut part = lobe(lobe_kind::DIFFUSE_TRANSMISSION);
            part.specular_transmittance = base_color;
            parts.push((part, [diffuse, factor(passing, false)]));
        }
        if !is_constant(&specular, 0.0) {
            let share = factor(specular, false);
            if !is_constant(&spec_tint, 1.0) {
                parts.push((
                    lobe(lobe_kind::ROUGH_COAT),
                    [share, factor(spec_tint, true)],
                ));
            }
            if !is_constant(&spec_tint, 0.0) {
                let mut part = lobe(lobe_kind::SCHLICK_REFLECTION);
                part.flags |= lobe_flag::TINTED;
                parts.push((part, [share, factor(spec_tint, false)]));
            }
            let mut part = lobe(lobe_kind::THIN_TRANSMISSION);
            part.specular_transmittance = base_color;
            part.alpha_u.value *= 0.65 * eta - 0.35;
            parts.push((part, [share, None]));
        }
        for (mut record, factors) in parts {
            let mut context = context.clone();
            // The sheet looks alike from both sides.
            record.flags |= lobe_flag::FLIP_BACK;
            context.factors.extend(factors.iter().flatten());
            self.push_lobe(object, record, context, lobes)?;
        }
        Ok(())
    }
}
