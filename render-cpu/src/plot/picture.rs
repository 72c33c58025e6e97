//! Small pictures in 8-bit sRGB: cut out, scaled and framed, to be put on sheets.

use image::imageops::{FilterType, resize};
use image::{Rgb, RgbImage};

/// A rectangle in pixels: left, top, width, height.
pub type Window = [u32; 4];

/// A picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture(RgbImage);

impl Picture {
    /// Of three bytes per pixel.
    ///
    /// # Panics
    /// If there are not `3 * width * height` bytes.
    pub fn new(width: u32, height: u32, rgb: Vec<u8>) -> Picture {
        let pixels = (width as usize) * (height as usize);
        assert_eq!(rgb.len(), 3 * pixels, "bytes do not fill the picture");
        Picture(RgbImage::from_fn(width, height, |x, y| {
            let at = 3 * (y as usize * width as usize + x as usize);
            Rgb([rgb[at], rgb[at + 1], rgb[at + 2]])
        }))
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        [self.0.width(), self.0.height()]
    }

    /// Three bytes per pixel.
    pub fn rgb(&self) -> &[u8] {
        self.0.as_raw()
    }

    /// A part of it; what lies outside is cut off.
    pub fn part(&self, [x, y, width, height]: Window) -> Picture {
        Picture(image::imageops::crop_imm(&self.0, x, y, width, height).to_image())
    }

    /// In another size: averaged where it shrinks, in whole pixels where it grows.
    pub fn scaled(&self, width: u32, height: u32) -> Picture {
        let shrinks = width < self.0.width();
        let filter = if shrinks {
            FilterType::Triangle
        } else {
            FilterType::Nearest
        };
        Picture(resize(&self.0, width.max(1), height.max(1), filter))
    }

    /// Draws the border of a window, `thickness` pixels inwards.
    pub fn frame(&mut self, [x, y, width, height]: Window, thickness: u32, color: [u8; 3]) {
        for row in y..(y + height).min(self.0.height()) {
            for column in x..(x + width).min(self.0.width()) {
                let near_x = column - x < thickness || x + width - column <= thickness;
                let near_y = row - y < thickness || y + height - row <= thickness;
                if near_x || near_y {
                    self.0.put_pixel(column, row, Rgb(color));
                }
            }
        }
    }
}
