//! Images as three floats per pixel, of any file that this crate reads, and what can be done with them.

use super::exr_read::{ExrImage, read_exr_bytes};
use super::window::Window;
use super::{ImageError, Texels, read_bitmap, read_file};
use crate::film::aov::Aov;
use crate::scene::color::srgb_to_linear;
use std::path::Path;
use std::str::FromStr;

/// An image or a crop of one; rows from top to bottom.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Which pixels of the whole image these are.
    pub window: Window,
    /// Size of the whole image.
    pub full_size: [u32; 2],
    /// Linear values.
    pub pixels: Vec<[f32; 3]>,
}

/// Why pictures do not go together.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PictureError {
    /// A file without the layer.
    #[error("{file}: there is no layer \"{layer}\"; there are {known}")]
    NoLayer {
        /// The file.
        file: String,
        /// What was asked for.
        layer: String,
        /// What there is.
        known: String,
    },
    /// Pictures of different sizes.
    #[error("the images have different sizes, {0} x {1} and {2} x {3} pixels")]
    Sizes(u32, u32, u32, u32),
    /// A crop beyond the image.
    #[error("the crop is not inside of {0} x {1} pixels")]
    Crop(u32, u32),
    /// Crops that are too far apart.
    #[error("an image that holds all crops is too large")]
    TooLarge,
}

/// Names of the channels of a layer, in order.
const CHANNELS: [[&str; 3]; 3] = [["R", "G", "B"], ["X", "Y", "Z"], ["U", "V", ""]];

impl Picture {
    /// Reads a file; of an OpenEXR file the layer, radiance without one.
    ///
    /// # Errors
    /// If the file cannot be read or has no such layer.
    pub fn load(
        path: &Path,
        layer: Option<&str>,
    ) -> Result<Picture, Box<dyn std::error::Error + Send + Sync>> {
        const EXR_MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
        let bytes = read_file(path)?;
        if bytes.starts_with(&EXR_MAGIC) {
            let image = read_exr_bytes(&bytes, path)?;
            return Ok(Picture::of_layer(&image, layer, path)?);
        }
        if let Some(layer) = layer {
            return Err(PictureError::NoLayer {
                file: path.display().to_string(),
                layer: layer.to_owned(),
                known: "none, it is no OpenEXR file".to_owned(),
            }
            .into());
        }
        Ok(Picture::of_bitmap(&bytes, path)?)
    }

    fn of_bitmap(bytes: &[u8], path: &Path) -> Result<Picture, ImageError> {
        let bitmap = read_bitmap(bytes, false, path)?;
        let pixels = match &bitmap.texels {
            Texels::Rgba8 { data, srgb } => {
                let value = |byte: u8| {
                    let value = f64::from(byte) / 255.0;
                    if *srgb {
                        srgb_to_linear(value) as f32
                    } else {
                        value as f32
                    }
                };
                let colour = |p: &[u8; 4]| [value(p[0]), value(p[1]), value(p[2])];
                data.as_chunks::<4>().0.iter().map(colour).collect()
            }
            Texels::Rgb32F(data) => data.as_chunks::<3>().0.to_vec(),
        };
        Ok(Picture {
            window: Window {
                origin: [0, 0],
                width: bitmap.width,
                height: bitmap.height,
            },
            full_size: [bitmap.width, bitmap.height],
            pixels,
        })
    }

    /// A layer of an image: its colours or coordinates, or one channel as grey.
    ///
    /// # Errors
    /// If it is not there.
    pub fn of_layer(
        image: &ExrImage,
        layer: Option<&str>,
        file: &Path,
    ) -> Result<Picture, PictureError> {
        // By the names of `--aov` as well.
        let layer = layer.map(|name| match Aov::from_str(name) {
            Ok(aov) => aov.channel().unwrap_or(name),
            Err(_) => name,
        });
        let prefix = layer.map_or(String::new(), |layer| format!("{layer}."));
        let three = CHANNELS.iter().find_map(|names| {
            let find = |name: &str| image.channel(&format!("{prefix}{name}"));
            let first = find(names[0])?;
            Some([Some(first), find(names[1]), find(names[2])])
        });
        let grey = || {
            let names = [
                layer.unwrap_or("Y").to_owned(),
                format!("{prefix}Z"),
                format!("{prefix}Y"),
            ];
            let found = names.iter().find_map(|name| image.channel(name))?;
            Some([Some(found); 3])
        };
        let channels = three.or_else(grey).ok_or_else(|| PictureError::NoLayer {
            file: file.display().to_string(),
            layer: layer.unwrap_or("R, G, B").to_owned(),
            known: layers(image).join(", "),
        })?;
        let pixels = image.width as usize * image.height as usize;
        let value = |i: usize, c: usize| channels[c].map_or(0.0, |values: &[f32]| values[i]);
        Ok(Picture {
            window: Window {
                origin: image.origin,
                width: image.width,
                height: image.height,
            },
            full_size: image.display_size,
            pixels: (0..pixels)
                .map(|i| [value(i, 0), value(i, 1), value(i, 2)])
                .collect(),
        })
    }

    /// A part of it, in pixels of the whole image.
    ///
    /// # Errors
    /// If it is empty or not all there.
    pub fn crop(&self, [x, y, width, height]: [u32; 4]) -> Result<Picture, PictureError> {
        let outside = || PictureError::Crop(self.window.width, self.window.height);
        let part = Window {
            origin: [
                i32::try_from(x).map_err(|_| outside())?,
                i32::try_from(y).map_err(|_| outside())?,
            ],
            width,
            height,
        };
        if width == 0 || height == 0 || self.window.union(&part) != Some(self.window) {
            return Err(outside());
        }
        Ok(Picture {
            window: part,
            full_size: self.full_size,
            pixels: part
                .indices_in(&self.window)
                .map(|i| self.pixels[i])
                .collect(),
        })
    }

    /// Two pictures, value by value.
    ///
    /// # Errors
    /// If they differ in size.
    pub fn combine(
        &self,
        other: &Picture,
        f: impl Fn(f32, f32) -> f32,
    ) -> Result<Picture, PictureError> {
        let (a, b) = (&self.window, &other.window);
        if (a.width, a.height) != (b.width, b.height) {
            return Err(PictureError::Sizes(a.width, a.height, b.width, b.height));
        }
        let both = self.pixels.iter().zip(&other.pixels);
        Ok(Picture {
            pixels: both
                .map(|(a, b)| std::array::from_fn(|c| f(a[c], b[c])))
                .collect(),
            ..*self
        })
    }

    /// All crops in one picture; where several have a pixel, the last one counts, and where none has, it is black.
    ///
    /// # Errors
    /// If they are crops of images of different sizes, or too far apart.
    pub fn assemble(parts: &[Picture]) -> Result<Picture, PictureError> {
        let Some((first, rest)) = parts.split_first() else {
            return Err(PictureError::TooLarge);
        };
        let mut window = first.window;
        for part in rest {
            let ([a, b], [c, d]) = (first.full_size, part.full_size);
            if [a, b] != [c, d] {
                return Err(PictureError::Sizes(a, b, c, d));
            }
            window = window.union(&part.window).ok_or(PictureError::TooLarge)?;
        }
        let mut pixels = vec![[0.0; 3]; window.width as usize * window.height as usize];
        for part in parts {
            for (index, pixel) in part.window.indices_in(&window).zip(&part.pixels) {
                pixels[index] = *pixel;
            }
        }
        Ok(Picture {
            window,
            full_size: first.full_size,
            pixels,
        })
    }
}

/// Names of the layers of an image, and of channels that stand alone.
fn layers(image: &ExrImage) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for (channel, _) in &image.channels {
        let name = channel
            .rsplit_once('.')
            .map_or(channel.as_str(), |(layer, _)| layer);
        if !names.iter().any(|known| known == name) {
            names.push(name.to_owned());
        }
    }
    names
}
