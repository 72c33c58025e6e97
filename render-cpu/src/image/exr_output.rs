//! Writing images as OpenEXR: one file, one part, named layers.
//!
//! Channels: `R`, `G`, `B` radiance; `albedo.R` ..., `normal.X` ..., `depth.Z`, `position.X` ..., `uv.U`, `uv.V`;
//! `NAME.R` ... the parts by path expressions; `variance.R` ... the variance of the pixel's mean, `variance.NAME.R` ... of a part's; `A` the share of its samples that met a surface; `samples` its number of
//! samples (unsigned integers), unless all pixels have as many: then the attribute `samplesPerPixel` says how many, and programs
//! that know no layers see a plain RGB image.
//! ZIP compression line by line: half the time of blocks of sixteen lines, and files that are 2 to 5 % longer, noisy as
//! radiance is. The data window is the crop, the display window the whole image. The file is written atomically.

use crate::atomic_file::{WriteError, write_atomically};
use crate::film::Film;
use crate::film::aov::Aov;
use crate::image::metadata::ImageMetadata;
use exr::image::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, write::WritableImage,
};
use exr::math::Vec2;
use exr::meta::attribute::{AttributeValue, IntegerBounds, Text};
use exr::meta::header::{ImageAttributes, LayerAttributes};
use exr::prelude::{Blocks, Compression, LineOrder, f16};
use std::path::Path;

/// Values of one channel, by rows.
#[derive(Clone, Debug, PartialEq)]
pub enum ChannelValues {
    /// Floats, written with 32 bits.
    Float(Vec<f32>),
    /// Colours, written with 32 bits, or with 16 as half floats.
    Colour(Vec<f32>),
    /// Counts.
    Count(Vec<u32>),
}

impl ChannelValues {
    fn len(&self) -> usize {
        match self {
            Self::Float(values) | Self::Colour(values) => values.len(),
            Self::Count(values) => values.len(),
        }
    }
}

/// An image that is ready to be written.
#[derive(Clone, Debug, PartialEq)]
pub struct LayeredImage {
    /// Width of the data in pixels.
    pub width: u32,
    /// Height of the data in pixels.
    pub height: u32,
    /// Position of the data in the whole image.
    pub offset: [i32; 2],
    /// Size of the whole image.
    pub full_size: [u32; 2],
    /// Channels by EXR name.
    pub channels: Vec<(String, ChannelValues)>,
    /// How the image was made.
    pub metadata: ImageMetadata,
}

impl LayeredImage {
    /// The image of a film with all its output variables. `full_size` is the size of the whole image, of which the
    /// film may be a crop.
    pub fn from_film(film: &Film, full_size: [u32; 2], metadata: ImageMetadata) -> Self {
        let statistics = film.statistics();
        let mut channels = Vec::new();
        for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
            let values = statistics.iter().map(|p| p.mean[c] as f32).collect();
            channels.push((name.to_owned(), ChannelValues::Colour(values)));
        }
        for aov in film.aovs().iter() {
            let values = match aov {
                // Where all pixels have as many, the metadata say so, and other programs see three channels.
                Aov::Samples if metadata.samples_per_pixel.is_some() => None,
                Aov::Samples => Some(ChannelValues::Count(
                    statistics.iter().map(|p| p.count).collect(),
                )),
                _ if aov.channel().is_some() => Some(ChannelValues::Float(
                    (0..statistics.len())
                        .map(|i| film.aov_mean(aov, 0, i) as f32)
                        .collect(),
                )),
                _ => None,
            };
            if let (Some(name), Some(values)) = (aov.channel(), values) {
                channels.push((name.to_owned(), values));
            }
            for (c, suffix) in aov.channels().iter().enumerate() {
                let values = (0..statistics.len())
                    .map(|i| film.aov_mean(aov, c, i) as f32)
                    .collect();
                let values = match aov {
                    Aov::Albedo | Aov::Normal => ChannelValues::Colour(values),
                    _ => ChannelValues::Float(values),
                };
                channels.push((format!("{}.{suffix}", aov.name()), values));
            }
        }
        for (part, layer) in film.parts().iter().enumerate() {
            for (c, suffix) in ["R", "G", "B"].into_iter().enumerate() {
                let means = (0..statistics.len()).map(|i| film.part_mean(part, c, i) as f32);
                let values = ChannelValues::Colour(means.collect());
                channels.push((format!("{layer}.{suffix}"), values));
                let variances = (0..statistics.len()).map(|i| film.part_variance(part, c, i));
                let variances: Option<Vec<f32>> = variances.map(|v| v.map(|v| v as f32)).collect();
                if let Some(variances) = variances {
                    let values = ChannelValues::Float(variances);
                    channels.push((format!("variance.{layer}.{suffix}"), values));
                }
            }
        }
        let [x, y] = film.crop_offset();
        Self {
            width: film.width(),
            height: film.height(),
            offset: [x as i32, y as i32],
            full_size,
            channels,
            metadata,
        }
    }
}

/// Writes the image to `path`; `half` stores colours and normals with 16 bits.
///
/// # Errors
/// If the file cannot be written; nothing is left under its name then.
///
/// # Panics
/// If a channel has another number of values than the image has pixels.
pub fn write_exr(path: &Path, image: &LayeredImage, half: bool) -> Result<(), WriteError> {
    let size = Vec2(image.width as usize, image.height as usize);
    if half {
        warn_of_clipped(path, image);
    }
    let list = image
        .channels
        .iter()
        .map(|(name, values)| {
            assert_eq!(
                values.len(),
                size.0 * size.1,
                "channel {name} does not fill the image"
            );
            let samples = match values {
                ChannelValues::Colour(values) if half => {
                    FlatSamples::F16(values.iter().map(|&v| half_float(v)).collect())
                }
                ChannelValues::Float(values) | ChannelValues::Colour(values) => {
                    FlatSamples::F32(values.clone())
                }
                ChannelValues::Count(values) => FlatSamples::U32(values.clone()),
            };
            AnyChannel::new(text(name), samples)
        })
        .collect();
    let mut layer_attributes = LayerAttributes {
        layer_position: Vec2(image.offset[0], image.offset[1]),
        ..LayerAttributes::default()
    };
    let metadata = &image.metadata;
    for (name, value) in metadata.attributes() {
        // Those among the standard attributes have fields of their own.
        match name {
            "software" => layer_attributes.software_name = Some(text(&value)),
            "owner" => layer_attributes.owner = Some(text(&value)),
            _ => {
                let value = AttributeValue::Text(text(&value));
                layer_attributes.other.insert(text(name), value);
            }
        }
    }
    for (name, value) in metadata.numbers() {
        let value = AttributeValue::F64(value);
        layer_attributes.other.insert(text(name), value);
    }
    layer_attributes.world_to_camera = metadata.camera.world_to_camera;
    layer_attributes.world_to_normalized_device = metadata.camera.world_to_ndc;
    let encoding = Encoding {
        compression: Compression::ZIP1,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let layer = Layer::new(size, layer_attributes, encoding, AnyChannels::sort(list));
    let full = Vec2(image.full_size[0] as usize, image.full_size[1] as usize);
    let exr = Image::new(
        ImageAttributes::new(IntegerBounds::new((0, 0), full)),
        layer,
    );
    write_atomically(path, |file| {
        exr.write().to_buffered(file).map_err(|e| match e {
            exr::error::Error::Io(e) => e,
            e => std::io::Error::other(e.to_string()),
        })
    })
}

/// Says how many values 16 bits cannot hold.
fn warn_of_clipped(path: &Path, image: &LayeredImage) {
    let colours = image
        .channels
        .iter()
        .filter_map(|(_, values)| match values {
            ChannelValues::Colour(values) => Some(values),
            _ => None,
        });
    let is_beyond = |v: &&f32| v.abs() > f16::MAX.to_f32();
    let clipped = colours.flatten().filter(is_beyond).count();
    if clipped > 0 {
        tracing::warn!(
            "{}: {clipped} values are too large for 16 bits and are stored as {}; without --half they are kept",
            path.display(),
            f16::MAX
        );
    }
}

/// The nearest half float; what is too bright becomes the largest one rather than an infinity.
fn half_float(v: f32) -> f16 {
    f16::from_f32(v.clamp(f16::MIN.to_f32(), f16::MAX.to_f32()))
}

/// EXR text is bytes; UTF-8 by convention.
fn text(s: &str) -> Text {
    Text::from_slice_unchecked(s.as_bytes())
}
