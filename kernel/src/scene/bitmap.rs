//! Bitmaps: images over the unit square of texture coordinates, and what lies around them.
//!
//! Texel (i, j) of a bitmap of w by h has its centre at ((i + 1/2) / w, (j + 1/2) / h). Every lookup is total:
//! coordinates that are not finite or absurdly large read some texel. The functions have no early returns, so that loops over
//! lanes can be vectorised ([`crate::simd::lanes`]).

use super::records::*;
use super::view::Tables;
use crate::math::{Rgb, element, float, luminance};
use glam::{Vec2, Vec3};

/// Location, size and lookup modes of a bitmap; see [`texture_kind::BITMAP`].
#[derive(Clone, Copy)]
pub(crate) struct Bitmap {
    first: u32,
    width: u32,
    height: u32,
    format: u32,
    filter: u32,
    wrap: u32,
}

impl Bitmap {
    /// That of a texture of [`texture_kind::BITMAP`].
    #[inline]
    pub fn new(texture: &Texture) -> Bitmap {
        let [first, width, height, format, filter, wrap] = texture.data;
        Bitmap {
            first,
            width,
            height,
            format,
            filter,
            wrap,
        }
    }

    /// [`Bitmap::new`] of texture `index`, for lanes.
    #[cfg(not(target_arch = "spirv"))]
    #[inline(always)]
    pub fn of(tables: &Tables<'_>, index: u32) -> Bitmap {
        use crate::math::field;
        Bitmap {
            first: field(tables.textures, index, |t| t.data[0]),
            width: field(tables.textures, index, |t| t.data[1]),
            height: field(tables.textures, index, |t| t.data[2]),
            format: field(tables.textures, index, |t| t.data[3]),
            filter: field(tables.textures, index, |t| t.data[4]),
            wrap: field(tables.textures, index, |t| t.data[5]),
        }
    }

    /// The value at transformed coordinates.
    #[cfg_attr(target_arch = "spirv", inline)]
    #[cfg_attr(not(target_arch = "spirv"), inline(always))]
    pub fn eval(&self, tables: &Tables<'_>, uv: Vec2) -> Rgb {
        let (c, f) = self.patch(tables, uv);
        let low = c[0] + (c[1] - c[0]) * f.x;
        let high = c[2] + (c[3] - c[2]) * f.x;
        if self.filter == filter_mode::NEAREST {
            c[0]
        } else {
            low + (high - low) * f.y
        }
    }

    /// Luminance gradient times `factor` per channel, in transformed coordinates; zero for nearest texels.
    pub fn gradient(&self, tables: &Tables<'_>, uv: Vec2, factor: Rgb) -> Vec2 {
        if self.filter == filter_mode::NEAREST {
            return Vec2::ZERO;
        }
        let (c, f) = self.patch(tables, uv);
        let h00 = luminance(c[0] * factor);
        let h10 = luminance(c[1] * factor);
        let h01 = luminance(c[2] * factor);
        let h11 = luminance(c[3] * factor);
        // One texel is 1/w wide: differences between texels count w times.
        Vec2::new(
            float::lerp(h10 - h00, h11 - h01, f.y) * self.width as f32,
            float::lerp(h01 - h00, h11 - h10, f.x) * self.height as f32,
        )
    }

    /// Four texels, row by row, and the position between them; with nearest-texel lookup the first one is the nearest.
    #[cfg_attr(target_arch = "spirv", inline)]
    #[cfg_attr(not(target_arch = "spirv"), inline(always))]
    fn patch(&self, tables: &Tables<'_>, uv: Vec2) -> ([Rgb; 4], Vec2) {
        let to_corner = if self.filter == filter_mode::NEAREST {
            0.0
        } else {
            0.5
        };
        let x = fold(uv.x, self.wrap) * self.width as f32 - to_corner;
        let y = fold(uv.y, self.wrap) * self.height as f32 - to_corner;
        let (floor_x, floor_y) = (float::floor(x), float::floor(y));
        let (column, row) = (float::to_integer(floor_x), float::to_integer(floor_y));
        #[cfg(target_arch = "spirv")]
        let corners = {
            // A loop, because shader compilers copy what is called four times in a row.
            let mut corners = [Vec3::ZERO; 4];
            for i in 0..4 {
                corners[i] = self.corner(tables, column + (i & 1) as i32, row + (i >> 1) as i32);
            }
            corners
        };
        // None, because a loop over lanes is to have no other inside.
        #[cfg(not(target_arch = "spirv"))]
        let corners = [
            self.corner(tables, column, row),
            self.corner(tables, column + 1, row),
            self.corner(tables, column, row + 1),
            self.corner(tables, column + 1, row + 1),
        ];
        (corners, Vec2::new(x - floor_x, y - floor_y))
    }

    /// A texel of the repeated image.
    #[cfg_attr(target_arch = "spirv", inline)]
    #[cfg_attr(not(target_arch = "spirv"), inline(always))]
    fn corner(&self, tables: &Tables<'_>, x: i32, y: i32) -> Rgb {
        self.texel(
            tables,
            wrap_index(x, self.width as i32, self.wrap),
            wrap_index(y, self.height as i32, self.wrap),
        )
    }

    /// One texel, decoded; zero at -1 and one at -2, see [`wrap_index`].
    #[cfg_attr(target_arch = "spirv", inline)]
    #[cfg_attr(not(target_arch = "spirv"), inline(always))]
    fn texel(&self, tables: &Tables<'_>, x: i32, y: i32) -> Rgb {
        let is_float = self.format == texel_format::RGB32F;
        let index = (y.max(0) as u32)
            .wrapping_mul(self.width)
            .wrapping_add(x.max(0) as u32);
        let words = if is_float { 3 } else { 1 };
        let at = self.first.wrapping_add(index.wrapping_mul(words));
        let first = element(tables.texels, at);
        let color = if is_float {
            let second = element(tables.texels, at.wrapping_add(1));
            let third = element(tables.texels, at.wrapping_add(2));
            Vec3::new(
                f32::from_bits(first),
                f32::from_bits(second),
                f32::from_bits(third),
            )
        } else {
            let (r, g, b) = (first & 255, (first >> 8) & 255, (first >> 16) & 255);
            if self.format == texel_format::RGBA8_SRGB {
                let table = tables.info.srgb_table;
                Vec3::new(
                    element(tables.data, table + r),
                    element(tables.data, table + g),
                    element(tables.data, table + b),
                )
            } else {
                Vec3::new(r as f32, g as f32, b as f32) * (1.0 / 255.0)
            }
        };
        let outside = if (x == -2) | (y == -2) { 1.0 } else { 0.0 };
        if (x < 0) | (y < 0) {
            Vec3::splat(outside)
        } else {
            color
        }
    }
}

/// Brings a coordinate near the unit interval, so that [`wrap_index`] needs no division: the period of repetition is 1,
/// of mirroring 2; the rest changes nothing beyond one image's width outside.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
fn fold(u: f32, wrap: u32) -> f32 {
    let folded = if wrap == wrap_mode::REPEAT {
        u - float::floor(u)
    } else if wrap == wrap_mode::MIRROR {
        u - 2.0 * float::floor(0.5 * u)
    } else {
        u.max(-2.0).min(3.0)
    };
    if float::is_finite(u) { folded } else { 0.0 }
}

/// The texel index inside the image for `i` next to the folded range, or -1 for the value zero, -2 for one.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
fn wrap_index(i: i32, size: i32, wrap: u32) -> i32 {
    let last = size - 1;
    let repeated = if i < 0 { last } else { 0 };
    let mirrored = if i < 0 { -1 - i } else { 2 * size - 1 - i };
    let outside = if wrap == wrap_mode::REPEAT {
        repeated
    } else if wrap == wrap_mode::MIRROR {
        mirrored.min(last).max(0)
    } else if wrap == wrap_mode::CLAMP {
        i.min(last).max(0)
    } else if wrap == wrap_mode::ZERO {
        -1
    } else {
        -2
    };
    if (i >= 0) & (i < size) { i } else { outside }
}
