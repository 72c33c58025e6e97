//! How an image file is read for a texture: the transfer function of its values, and which channel is taken.

use crate::image::{Bitmap, Channel, load_bitmap, load_channel};
use crate::scene::error::SceneError;
use crate::scene::xml::Object;

/// How the values of an image file are interpreted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Reading {
    transfer: Transfer,
    channel: Option<Channel>,
}

/// The transfer function from stored to linear values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Transfer {
    /// Floats are linear, integers sRGB.
    OfFormat,
    /// Linear.
    Linear,
    /// sRGB.
    Srgb,
    /// The bits of the power that makes them linear.
    Gamma(u32),
}

impl Reading {
    /// What a bitmap's properties say: `raw`, and `gamma` and `channel` of 0.6.
    pub(super) fn of(object: &Object) -> Result<Reading, SceneError> {
        let mut transfer = Transfer::OfFormat;
        match object.opt_float("gamma")? {
            // The default.
            None | Some(0.0) => {}
            Some(1.0) => transfer = Transfer::Linear,
            Some(-1.0) => transfer = Transfer::Srgb,
            Some(gamma) if gamma > 0.0 => transfer = Transfer::Gamma((gamma as f32).to_bits()),
            Some(gamma) => {
                return Err(object.property_error(
                    "gamma",
                    format!(
                        "{gamma} is neither positive, nor -1 for sRGB, nor 0 for that of the file"
                    ),
                ));
            }
        }
        if object.get_bool("raw", false)? {
            transfer = Transfer::Linear;
        }
        let channel = match object.opt_string("channel")? {
            None => None,
            Some(name) => Some(match name.to_ascii_lowercase().as_str() {
                "r" | "x" => Channel::Red,
                "g" | "y" => Channel::Green,
                "b" | "z" => Channel::Blue,
                "a" => Channel::Alpha,
                _ => {
                    return Err(object.property_error(
                        "channel",
                        format!("\"{name}\" is none of r, g, b, a, x, y, z"),
                    ));
                }
            }),
        };
        Ok(Reading { transfer, channel })
    }

    /// A number that identifies how the file is read, for the key of a cache.
    pub(super) fn variant(self) -> u64 {
        let transfer = match self.transfer {
            Transfer::OfFormat => 0,
            Transfer::Linear => 1,
            Transfer::Srgb => 2,
            Transfer::Gamma(bits) => 3 | (u64::from(bits) << 8),
        };
        let channel = self.channel.map_or(0, |channel| channel as u64 + 1);
        transfer | (channel << 40)
    }

    /// Reads a file so.
    pub(super) fn load(self, path: &std::path::Path) -> Result<Bitmap, crate::image::ImageError> {
        let raw = self.transfer != Transfer::OfFormat;
        let bitmap = match self.channel {
            None => load_bitmap(path, raw)?,
            Some(channel) => load_channel(path, raw, channel)?,
        };
        // Opacity is never encoded.
        if self.channel == Some(Channel::Alpha) {
            return Ok(bitmap);
        }
        Ok(match self.transfer {
            Transfer::OfFormat | Transfer::Linear => bitmap,
            Transfer::Srgb => bitmap.with_srgb(),
            Transfer::Gamma(bits) => bitmap.with_gamma(f32::from_bits(bits)),
        })
    }
}
