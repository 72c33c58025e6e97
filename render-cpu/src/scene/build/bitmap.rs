//! Bitmaps of textures: their texels, their range, and what is between and outside of them.

use super::builder::Builder;
use super::reading::Reading;
use super::value_range::ValueRange;
use crate::image::{Bitmap, Texels};
use crate::scene::error::SceneError;
use crate::scene::xml::Object;
use halflight_kernel::scene::{filter_mode, texel_format, texture_kind, wrap_mode};

/// Above 1 by more than what filters of other programs add to white.
const MAX_REFLECTANCE: f32 = 1.001;

impl Builder {
    /// Says, once for a texture, which of its colours cannot be what they are used as.
    pub(super) fn check_range(
        &mut self,
        object: &Object,
        index: u32,
        range: ValueRange,
    ) -> Result<(), SceneError> {
        if !self.checked_textures.insert(index) {
            return Ok(());
        }
        let Some([least, most]) = self.range_of_bitmap(index) else {
            return Ok(());
        };
        if least < 0.0 {
            object.warn(format!(
                "the values go down to {least}; what is negative counts as 0"
            ))?;
        }
        if range == ValueRange::UnitInterval && most > MAX_REFLECTANCE {
            object.warn(format!(
                "the values go up to {most}; a reflectance above 1 creates energy"
            ))?;
        }
        Ok(())
    }

    /// The least and the largest value of a bitmap of floats, whose range nothing else bounds, with its constant factor.
    fn range_of_bitmap(&self, index: u32) -> Option<[f32; 2]> {
        let mut texture = self.tables.textures.get(index as usize)?;
        let mut factor = 1.0;
        if texture.kind == texture_kind::SCALE {
            let [r, g, b] = texture.color0.value;
            factor = r.max(g).max(b);
            texture = self.tables.textures.get(texture.color0.texture as usize)?;
        }
        if texture.kind != texture_kind::BITMAP {
            return None;
        }
        let [first, width, height, format, ..] = texture.data;
        let range = self.range_of_texels([first, width, height, format])?;
        Some(range.map(|v| factor * v))
    }

    /// Says if light of an image is negative.
    pub(super) fn say_if_negative(
        &self,
        object: &Object,
        texels: [u32; 4],
    ) -> Result<(), SceneError> {
        match self.range_of_texels(texels) {
            Some([least, _]) if least < 0.0 => object.warn(format!(
                "the values go down to {least}; what is negative counts as 0"
            )),
            _ => Ok(()),
        }
    }

    /// The least and the largest value of texels of floats: first word, width, height and format.
    fn range_of_texels(&self, [first, width, height, format]: [u32; 4]) -> Option<[f32; 2]> {
        if format != texel_format::RGB32F {
            return None;
        }
        let count = 3 * width as usize * height as usize;
        let texels = self.tables.texels.get(first as usize..)?.get(..count)?;
        let values = texels.iter().map(|&bits| f32::from_bits(bits));
        Some(
            values.fold([f32::INFINITY, f32::NEG_INFINITY], |[least, most], v| {
                [least.min(v), most.max(v)]
            }),
        )
    }

    /// Texels of a file: first word, width, height and format.
    pub(super) fn bitmap(
        &mut self,
        object: &Object,
        path: &std::path::Path,
        reading: Reading,
    ) -> Result<[u32; 4], SceneError> {
        let key = (path.to_path_buf(), reading);
        if let Some(&known) = self.bitmaps.get(&key) {
            return Ok(known);
        }
        let bitmap = object
            .file_cache()
            .get(path, reading.variant(), || reading.load(path))
            .map_err(|e| object.property_error("filename", e.to_string()))?;
        for warning in &bitmap.warnings {
            object.property_warn("filename", format!("{}: {warning}", path.display()))?;
        }
        let entry = self.push_bitmap(object, &bitmap)?;
        self.bitmaps.insert(key, entry);
        Ok(entry)
    }

    pub(super) fn push_bitmap(
        &mut self,
        object: &Object,
        bitmap: &Bitmap,
    ) -> Result<[u32; 4], SceneError> {
        let first = u32::try_from(self.tables.texels.len())
            .map_err(|_| object.error("all textures together exceed 16 GiB"))?;
        let format = match &bitmap.texels {
            Texels::Rgba8 { data, srgb } => {
                self.tables.texels.extend(
                    data.chunks_exact(4)
                        .map(|texel| u32::from_le_bytes([texel[0], texel[1], texel[2], texel[3]])),
                );
                if *srgb {
                    texel_format::RGBA8_SRGB
                } else {
                    texel_format::RGBA8_LINEAR
                }
            }
            Texels::Rgb32F(data) => {
                self.tables
                    .texels
                    .extend(data.iter().map(|value| value.to_bits()));
                texel_format::RGB32F
            }
        };
        Ok([first, bitmap.width, bitmap.height, format])
    }
}

pub(super) fn filter(object: &Object) -> Result<u32, SceneError> {
    // Properties of the mip maps of 0.6, of which the finest level is used, and how Mitsuba 3 stores texels.
    for name in ["max_anisotropy", "cache", "coordinates", "format", "accel"] {
        object.get(name);
    }
    Ok(match object.get_string("filter_type", "bilinear")? {
        "nearest" => filter_mode::NEAREST,
        // Mitsuba 0.6 has mip maps; without ray differentials their finest level is this.
        "bilinear" | "trilinear" | "ewa" => filter_mode::BILINEAR,
        other => {
            return Err(object.property_error(
                "filter_type",
                format!("\"{other}\" is neither \"bilinear\" nor \"nearest\""),
            ));
        }
    })
}

/// What lies outside of the image: `wrap_mode`, or a mode for each axis as 0.6 has it.
pub(super) fn wrap(object: &Object) -> Result<u32, SceneError> {
    let both = object.get_string("wrap_mode", "repeat")?;
    let (u, v) = (
        object.get_string("wrap_mode_u", both)?,
        object.get_string("wrap_mode_v", both)?,
    );
    if u != v {
        object.property_warn(
            "wrap_mode_v",
            format!("one mode for both axes is supported; \"{u}\" is used for u and v"),
        )?;
    }
    wrap_mode_of(object, u)
}

fn wrap_mode_of(object: &Object, name: &str) -> Result<u32, SceneError> {
    Ok(match name {
        "repeat" => wrap_mode::REPEAT,
        "mirror" => wrap_mode::MIRROR,
        "clamp" => wrap_mode::CLAMP,
        // In some versions of 0.6 by their colours.
        "zero" | "black" => wrap_mode::ZERO,
        "one" | "white" => wrap_mode::ONE,
        other => {
            return Err(object.property_error(
                "wrap_mode",
                format!("\"{other}\" is none of repeat, mirror, clamp, zero, one"),
            ));
        }
    })
}
