//! `phong` and `ward` of Mitsuba 0.6: a highlight beside a diffuse part, each a lobe of its own.
//!
//! | plugin | parameters |
//! |---|---|
//! | `phong` | `exponent` (texture; 30), `diffuse_reflectance` (0.5), `specular_reflectance` (0.2) |
//! | `ward` | `variant` (`ward`, `ward-duer`, `balanced`), `alpha_u`, `alpha_v` (texture; 0.1), and the reflectances |
//!
//! As there, both reflectances are scaled where their sum may exceed one, to 0.99 of it.

use super::context::{Context, PendingLobe};
use super::parameters::empty_lobe;
use crate::scene::build::builder::Builder;
use crate::scene::color::ColorUse;
use crate::scene::error::SceneError;
use crate::scene::xml::Object;
use halflight_kernel::bsdf::ward::variant;
use halflight_kernel::scene::{
    LobeRecord, NONE, RgbParameter, lobe_kind, texel_format, texture_kind,
};
use std::sync::Arc;

/// Sum to which reflectances are scaled that would create energy.
const CONSERVED: f32 = 0.99;

impl Builder {
    /// The lobes of `phong` or `ward`.
    pub(super) fn glossy(
        &mut self,
        object: &Arc<Object>,
        context: &Context<'_>,
        lobes: &mut Vec<PendingLobe>,
    ) -> Result<(), SceneError> {
        let mesh = context.mesh;
        let mut highlight = empty_lobe(lobe_kind::PHONG);
        if object.plugin == "ward" {
            highlight.kind = lobe_kind::WARD;
            highlight.distribution = match object.get_string("variant", "balanced")? {
                "ward" => variant::WARD,
                "ward-duer" => variant::DUER,
                "balanced" => variant::BALANCED,
                other => {
                    return Err(object.property_error(
                        "variant",
                        format!("\"{other}\" is none of ward, ward-duer, balanced"),
                    ));
                }
            };
            self.widths(object, mesh, &mut highlight)?;
        } else {
            highlight.exponent = self.scalar_parameter(object, "exponent", 30.0, mesh)?;
            if highlight.exponent.value < 0.0 {
                return Err(object.property_error("exponent", "cannot be negative"));
            }
        }
        let mut base = empty_lobe(lobe_kind::DIFFUSE);
        let usage = ColorUse::Reflectance;
        base.reflectance =
            self.rgb_parameter(object, "diffuse_reflectance", usage, [0.5; 3], mesh)?;
        highlight.specular_reflectance =
            self.rgb_parameter(object, "specular_reflectance", usage, [0.2; 3], mesh)?;

        let (a, b) = (
            self.largest(&base.reflectance),
            self.largest(&highlight.specular_reflectance),
        );
        let sum = [0, 1, 2]
            .map(|c| a[c] + b[c])
            .into_iter()
            .fold(0.0, f32::max);
        if sum > 1.0 {
            let scale = CONSERVED / sum;
            object.warn(format!(
                "the diffuse and the specular reflectance may reflect {sum} of the light; both are scaled by {scale}, as in Mitsuba 0.6"
            ))?;
            for parameter in [&mut base.reflectance, &mut highlight.specular_reflectance] {
                parameter.value = parameter.value.map(|v| v * scale);
            }
        }
        // A part that reflects nothing is no lobe, unless nothing is left.
        let is_black = |p: &RgbParameter| p.value == [0.0; 3];
        if !is_black(&highlight.specular_reflectance) {
            self.push_lobe(object, highlight, context.clone(), lobes)?;
        }
        if !is_black(&base.reflectance) || is_black(&highlight.specular_reflectance) {
            self.push_lobe(object, base, context.clone(), lobes)?;
        }
        Ok(())
    }

    /// `alpha_u` and `alpha_v`, or `alpha` for both.
    fn widths(
        &mut self,
        object: &Object,
        mesh: Option<&crate::scene::build::texture::MeshAttributes>,
        lobe: &mut LobeRecord,
    ) -> Result<(), SceneError> {
        for (name, parameter) in [
            ("alpha_u", &mut lobe.alpha_u),
            ("alpha_v", &mut lobe.alpha_v),
        ] {
            let named = if object.has(name) { name } else { "alpha" };
            *parameter = self.scalar_parameter(object, named, 0.1, mesh)?;
            if parameter.texture == NONE && parameter.value <= 0.0 {
                return Err(object.property_error(named, "a width must be positive"));
            }
        }
        Ok(())
    }

    /// The largest values of a parameter, its texture included.
    fn largest(&self, parameter: &RgbParameter) -> [f32; 3] {
        let mut values = parameter.value;
        if parameter.texture == NONE {
            return values;
        }
        let texture = &self.tables.textures[parameter.texture as usize];
        let texels = match texture.kind {
            texture_kind::BITMAP => self.largest_texel(texture.data),
            texture_kind::SCALE => self.largest(&texture.color0),
            texture_kind::VERTEX_ATTRIBUTE | texture_kind::FACE_ATTRIBUTE => [1.0; 3],
            _ => {
                let (a, b) = (self.largest(&texture.color0), self.largest(&texture.color1));
                [0, 1, 2].map(|c| a[c].max(b[c]))
            }
        };
        for c in 0..3 {
            values[c] *= texels[c];
        }
        values
    }

    /// The largest value of each channel of a bitmap.
    fn largest_texel(&self, [first, width, height, format, ..]: [u32; 6]) -> [f32; 3] {
        let pixels = width as usize * height as usize;
        let words = &self.tables.texels[first as usize..];
        let mut largest = [0.0_f32; 3];
        if format == texel_format::RGB32F {
            for pixel in words[..3 * pixels].as_chunks::<3>().0 {
                for c in 0..3 {
                    largest[c] = largest[c].max(f32::from_bits(pixel[c]));
                }
            }
            return largest;
        }
        let mut bytes = [0_u8; 3];
        for word in &words[..pixels] {
            for c in 0..3 {
                bytes[c] = bytes[c].max(word.to_le_bytes()[c]);
            }
        }
        // The first words of `data` decode sRGB.
        bytes.map(|byte| match format {
            texel_format::RGBA8_SRGB => self.tables.data[usize::from(byte)],
            _ => f32::from(byte) / 255.0,
        })
    }
}
