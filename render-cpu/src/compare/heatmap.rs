//! Error maps as colours.
//!
//! The colour map is a path through Oklab (Ottosson 2020): lightness rises evenly from 0.13 to 0.97, the hue turns from
//! blue over magenta and red to yellow, and the chroma swells and fades like a sine. Equal steps of error look equal,
//! the order survives grey printing, and the map remains readable with red-green blindness. Below the map is a legend: a bar
//! of all colours with its values. Values that are not finite are cyan, which is not a colour of the map.

use crate::image::png_output::srgb_encode;

/// Colour of values that are not finite.
pub const NOT_FINITE: [u8; 3] = [0, 255, 255];

/// Height of the legend in pixels.
pub const LEGEND_HEIGHT: usize = 26;

/// 8-bit sRGB of a value in [0, 1]; others are clamped.
pub fn color(value: f64) -> [u8; 3] {
    if !value.is_finite() {
        return NOT_FINITE;
    }
    let t = value.clamp(0.0, 1.0);
    let lightness = 0.13 + 0.84 * t;
    // From blue (-80 degrees) through magenta and red to yellow (105 degrees).
    let hue = (-80.0 + 185.0 * t).to_radians();
    let chroma = 0.03 + 0.16 * (std::f64::consts::PI * t.powf(0.9)).sin().max(0.0);
    oklab_to_linear(lightness, chroma * hue.cos(), chroma * hue.sin())
        .map(|v| (srgb_encode(v.clamp(0.0, 1.0)) * 255.0).round() as u8)
}

/// Linear sRGB of Oklab.
fn oklab_to_linear(lightness: f64, a: f64, b: f64) -> [f64; 3] {
    let l = (lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b).powi(3);
    let m = (lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b).powi(3);
    let s = (lightness - 0.089_484_177_5 * a - 1.291_485_548_0 * b).powi(3);
    [
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701_0 * s,
    ]
}

/// An error map with a legend below: width, height and bytes of the picture. `largest` is the value of the last colour.
pub fn render(map: &[f64], width: usize, largest: f64) -> (usize, usize, Vec<u8>) {
    let height = map.len() / width;
    let labels = [(0.0, 0.0), (0.5, 0.5 * largest), (1.0, largest)]
        .map(|(part, value)| (part, format!("{value}")));
    let characters: usize = labels.iter().map(|(_, text)| text.len()).sum();
    // Space for the labels even below a narrow map.
    let full_width = width.max(64).max(8 * (characters + 2));
    let full_height = height + LEGEND_HEIGHT;
    let mut bytes = vec![24; 3 * full_width * full_height];
    let mut set = |x: usize, y: usize, color: [u8; 3]| {
        if x < full_width && y < full_height {
            let at = 3 * (y * full_width + x);
            bytes[at..at + 3].copy_from_slice(&color);
        }
    };
    for (i, value) in map.iter().enumerate() {
        set(i % width, i / width, color(value / largest));
    }
    let bar = full_width - 8;
    for x in 0..bar {
        for y in 4..12 {
            set(4 + x, height + y, color(x as f64 / (bar - 1) as f64));
        }
    }
    for (part, text) in labels {
        let center = 4.0 + part * (bar - 1) as f64;
        let left = (center - 4.0 * text.len() as f64)
            .clamp(2.0, (full_width - 8 * text.len()) as f64) as usize;
        for y in 12..14 {
            set(center as usize, height + y, [255; 3]);
        }
        for (k, character) in text.chars().enumerate() {
            for (row, bits) in glyph(character).into_iter().enumerate() {
                for column in 0..3 {
                    if bits & (4 >> column) != 0 {
                        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                            set(
                                left + 8 * k + 2 * column + dx,
                                height + 15 + 2 * row + dy,
                                [255; 3],
                            );
                        }
                    }
                }
            }
        }
    }
    (full_width, full_height, bytes)
}

/// Three by five dots of a digit or a point, a row per number, the left dot in the highest bit.
const fn glyph(character: char) -> [u8; 5] {
    match character {
        '0' => [7, 5, 5, 5, 7],
        '1' => [2, 6, 2, 2, 7],
        '2' => [7, 1, 7, 4, 7],
        '3' => [7, 1, 7, 1, 7],
        '4' => [5, 5, 7, 1, 1],
        '5' => [7, 4, 7, 1, 7],
        '6' => [7, 4, 7, 5, 7],
        '7' => [7, 1, 1, 2, 2],
        '8' => [7, 5, 7, 5, 7],
        '9' => [7, 5, 7, 1, 7],
        '.' => [0, 0, 0, 0, 2],
        _ => [0; 5],
    }
}
