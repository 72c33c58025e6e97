//! Textures over a surface, and parameters that may hold one.
//!
//! Texture coordinates: u runs along a bitmap's rows, v down its columns, so (0, 0) is the outer corner of the first
//! texel in memory and texel (i, j) has its centre at ((i + 1/2) / w, (j + 1/2) / h). Nested textures are followed by a
//! bounded loop: scales multiply, checkerboards choose one child. Every lookup is total: coordinates that are not finite
//! or absurdly large read some texel. Conventions were taken from an independent renderer's output; the tests hold
//! the numbers.

use super::features;
use super::records::*;
use super::surface::SurfacePoint;
use super::view::Tables;
use crate::math::{Rgb, float, luminance, vec3};
use glam::{Vec2, Vec3};

/// Deepest nesting of textures that is followed.
const MAX_NESTING: u32 = 8;

/// Where a texture is looked up: coordinates, and the primitive for mesh attributes.
#[derive(Clone, Copy)]
struct Place {
    uv: Vec2,
    barycentric: Vec2,
    /// Triangle, or [`NONE`] where there is no mesh.
    primitive: u32,
}

impl Place {
    #[inline]
    fn on_surface(point: &SurfacePoint) -> Place {
        Place {
            uv: point.uv,
            barycentric: point.barycentric,
            primitive: point.primitive,
        }
    }
}

/// A colour parameter at a surface point.
#[inline]
pub fn eval_rgb(tables: &Tables<'_>, parameter: &RgbParameter, point: &SurfacePoint) -> Rgb {
    if !tables.has(features::TEXTURES) || parameter.texture == NONE {
        return vec3(parameter.value);
    }
    vec3(parameter.value) * eval_at(tables, parameter.texture, Place::on_surface(point))
}

/// A scalar parameter at a surface point; a texture counts by its luminance.
#[inline]
pub fn eval_scalar(tables: &Tables<'_>, parameter: &ScalarParameter, point: &SurfacePoint) -> f32 {
    if !tables.has(features::TEXTURES) || parameter.texture == NONE {
        return parameter.value;
    }
    parameter.value * luminance(eval_at(tables, parameter.texture, Place::on_surface(point)))
}

/// A texture by its index at a surface point.
#[inline]
pub fn eval_at_point(tables: &Tables<'_>, texture: u32, point: &SurfacePoint) -> Rgb {
    eval_at(tables, texture, Place::on_surface(point))
}

/// A texture by its index at bare coordinates (emitters); mesh attributes are zero there.
#[inline]
pub fn eval_uv(tables: &Tables<'_>, texture: u32, uv: Vec2) -> Rgb {
    let place = Place {
        uv,
        barycentric: Vec2::ZERO,
        primitive: NONE,
    };
    eval_at(tables, texture, place)
}

/// Derivatives of a texture's luminance in u and v at a surface point: of the bilinear patch for bitmaps, zero for
/// the rest (checkerboards and attributes count as flat).
pub fn eval_gradient(tables: &Tables<'_>, texture: u32, point: &SurfacePoint) -> Vec2 {
    let (leaf, factor) = resolve(tables, texture, point.uv);
    if leaf == NONE || tables.textures[leaf as usize].kind != texture_kind::BITMAP {
        return Vec2::ZERO;
    }
    let texture = &tables.textures[leaf as usize];
    let gradient = bitmap_gradient(tables, texture, transform_uv(texture, point.uv), factor);
    // Chain rule through the affine map.
    let m = &texture.to_uv;
    Vec2::new(
        m[0] * gradient.x + m[3] * gradient.y,
        m[1] * gradient.x + m[4] * gradient.y,
    )
}

/// The affine map of a texture's coordinates.
#[inline]
fn transform_uv(texture: &Texture, uv: Vec2) -> Vec2 {
    let m = &texture.to_uv;
    Vec2::new(
        m[0] * uv.x + m[1] * uv.y + m[2],
        m[3] * uv.x + m[4] * uv.y + m[5],
    )
}

/// Follows scales and checkerboards to a texture that holds data, with the product of the factors on the way; a
/// constant is [`NONE`] with its value as the factor.
#[inline]
fn resolve(tables: &Tables<'_>, texture: u32, uv: Vec2) -> (u32, Rgb) {
    let mut factor = Vec3::ONE;
    let mut current = texture;
    for _ in 0..MAX_NESTING {
        if current == NONE {
            return (NONE, factor);
        }
        let record = &tables.textures[current as usize];
        let second = if record.kind == texture_kind::CHECKERBOARD {
            // Quarters of the unit square: both halves the same is the first colour.
            let p = transform_uv(record, uv);
            (p.x - float::floor(p.x) > 0.5) != (p.y - float::floor(p.y) > 0.5)
        } else if record.kind == texture_kind::SCALE {
            false
        } else {
            return (current, factor);
        };
        let child = if second { record.color1 } else { record.color0 };
        factor *= vec3(child.value);
        current = child.texture;
    }
    (NONE, Vec3::ZERO)
}

#[inline]
fn eval_at(tables: &Tables<'_>, texture: u32, place: Place) -> Rgb {
    if !tables.has(features::TEXTURES) {
        return Vec3::ZERO;
    }
    let (leaf, factor) = resolve(tables, texture, place.uv);
    if leaf == NONE {
        return factor;
    }
    let record = &tables.textures[leaf as usize];
    if tables.has(features::BITMAPS) && record.kind == texture_kind::BITMAP {
        factor * bitmap(tables, record, transform_uv(record, place.uv))
    } else if tables.has(features::ATTRIBUTES) {
        factor * attribute(tables, record, place)
    } else {
        Vec3::ZERO
    }
}

/// An interpolated vertex attribute or a face attribute; zero off the triangles.
fn attribute(tables: &Tables<'_>, texture: &Texture, place: Place) -> Rgb {
    if place.primitive as usize >= tables.triangles.len() {
        return Vec3::ZERO;
    }
    let (first, channels, base) = (texture.data[0], texture.data[1], texture.data[2]);
    if texture.kind == texture_kind::FACE_ATTRIBUTE {
        return attribute_value(tables, first, channels, place.primitive.wrapping_sub(base));
    }
    let vertices = tables.triangles[place.primitive as usize].vertices;
    let (b1, b2) = (place.barycentric.x, place.barycentric.y);
    let weights = [1.0 - b1 - b2, b1, b2];
    let mut sum = Vec3::ZERO;
    for i in 0..3 {
        sum +=
            attribute_value(tables, first, channels, vertices[i].wrapping_sub(base)) * weights[i];
    }
    sum
}

#[inline]
fn attribute_value(tables: &Tables<'_>, first: u32, channels: u32, item: u32) -> Rgb {
    let at = first.wrapping_add(item.wrapping_mul(channels)) as usize;
    if at >= tables.data.len() || at + channels as usize > tables.data.len() {
        return Vec3::ZERO;
    }
    if channels < 3 {
        return Vec3::splat(tables.data[at]);
    }
    Vec3::new(tables.data[at], tables.data[at + 1], tables.data[at + 2])
}

/// A bitmap at transformed coordinates.
fn bitmap(tables: &Tables<'_>, texture: &Texture, uv: Vec2) -> Rgb {
    let (width, height, wrap) = (texture.data[1], texture.data[2], texture.data[5]);
    let p = fold(uv, wrap);
    if texture.data[4] == filter_mode::NEAREST {
        let x = wrap_index(float::floor(p.x * width as f32) as i32, width as i32, wrap);
        let y = wrap_index(
            float::floor(p.y * height as f32) as i32,
            height as i32,
            wrap,
        );
        return texel(tables, texture, x, y);
    }
    let (c, f) = patch(tables, texture, p);
    let low = c[0] + (c[1] - c[0]) * f.x;
    let high = c[2] + (c[3] - c[2]) * f.x;
    low + (high - low) * f.y
}

/// Luminance gradient of a bitmap, times `factor` per channel, in transformed coordinates.
fn bitmap_gradient(tables: &Tables<'_>, texture: &Texture, uv: Vec2, factor: Rgb) -> Vec2 {
    if texture.data[4] == filter_mode::NEAREST {
        return Vec2::ZERO;
    }
    let (c, f) = patch(tables, texture, fold(uv, texture.data[5]));
    let h00 = luminance(c[0] * factor);
    let h10 = luminance(c[1] * factor);
    let h01 = luminance(c[2] * factor);
    let h11 = luminance(c[3] * factor);
    // One texel is 1/w wide: differences between texels count w times.
    Vec2::new(
        float::lerp(h10 - h00, h11 - h01, f.y) * texture.data[1] as f32,
        float::lerp(h01 - h00, h11 - h10, f.x) * texture.data[2] as f32,
    )
}

/// Four texels, row by row, and the position between them.
#[inline]
fn patch(tables: &Tables<'_>, texture: &Texture, p: Vec2) -> ([Rgb; 4], Vec2) {
    let (width, height, wrap) = (
        texture.data[1] as i32,
        texture.data[2] as i32,
        texture.data[5],
    );
    let x = p.x * width as f32 - 0.5;
    let y = p.y * height as f32 - 0.5;
    let (floor_x, floor_y) = (float::floor(x), float::floor(y));
    let mut corners = [Vec3::ZERO; 4];
    // A loop, because shader compilers copy what is called four times in a row.
    for i in 0..4 {
        corners[i] = texel(
            tables,
            texture,
            wrap_index(floor_x as i32 + (i & 1) as i32, width, wrap),
            wrap_index(floor_y as i32 + (i >> 1) as i32, height, wrap),
        );
    }
    (corners, Vec2::new(x - floor_x, y - floor_y))
}

/// Brings coordinates near the unit square, so that [`wrap_index`] needs no division: the period of repetition is 1,
/// of mirroring 2; the rest changes nothing beyond one image's width outside.
#[inline]
fn fold(uv: Vec2, wrap: u32) -> Vec2 {
    Vec2::new(fold_axis(uv.x, wrap), fold_axis(uv.y, wrap))
}

#[inline]
fn fold_axis(u: f32, wrap: u32) -> f32 {
    if !float::is_finite(u) {
        return 0.0;
    }
    if wrap == wrap_mode::REPEAT {
        u - float::floor(u)
    } else if wrap == wrap_mode::MIRROR {
        u - 2.0 * float::floor(0.5 * u)
    } else {
        u.max(-2.0).min(3.0)
    }
}

/// The texel index inside the image for `i` next to the folded range, or -1 for the value zero, -2 for one.
#[inline]
fn wrap_index(i: i32, size: i32, wrap: u32) -> i32 {
    if i >= 0 && i < size {
        return i;
    }
    let last = size - 1;
    if wrap == wrap_mode::REPEAT {
        if i < 0 { last } else { 0 }
    } else if wrap == wrap_mode::MIRROR {
        let j = if i < 0 { -1 - i } else { 2 * size - 1 - i };
        j.min(last).max(0)
    } else if wrap == wrap_mode::CLAMP {
        i.min(last).max(0)
    } else if wrap == wrap_mode::ZERO {
        -1
    } else {
        -2
    }
}

/// One texel, decoded.
#[inline]
fn texel(tables: &Tables<'_>, texture: &Texture, x: i32, y: i32) -> Rgb {
    if x < 0 || y < 0 {
        // Outside, by wrap mode.
        return if x == -2 || y == -2 {
            Vec3::ONE
        } else {
            Vec3::ZERO
        };
    }
    let index = y as u32 * texture.data[1] + x as u32;
    let format = texture.data[3];
    if format == texel_format::RGB32F {
        let at = (texture.data[0] + 3 * index) as usize;
        return Vec3::new(
            f32::from_bits(tables.texels[at]),
            f32::from_bits(tables.texels[at + 1]),
            f32::from_bits(tables.texels[at + 2]),
        );
    }
    let word = tables.texels[(texture.data[0] + index) as usize];
    let (r, g, b) = (word & 255, (word >> 8) & 255, (word >> 16) & 255);
    if format == texel_format::RGBA8_SRGB {
        let table = tables.info.srgb_table;
        return Vec3::new(
            tables.data[(table + r) as usize],
            tables.data[(table + g) as usize],
            tables.data[(table + b) as usize],
        );
    }
    Vec3::new(r as f32, g as f32, b as f32) * (1.0 / 255.0)
}
