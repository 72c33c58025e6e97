//! Textures over a surface, and parameters that may hold one.
//!
//! Texture coordinates: u runs along a bitmap's rows, v down its columns, so (0, 0) is the outer corner of the first
//! texel in memory ([`super::bitmap`]). Nested textures are followed by a bounded loop: scales multiply, checkerboards choose
//! one child. Every lookup is total. Conventions were taken from an independent renderer's output; the tests hold the
//! numbers.

use super::bitmap::Bitmap;
use super::features;
use super::records::*;
use super::surface::SurfacePoint;
use super::view::Tables;
use crate::math::{Rgb, float, luminance, vec3};
use glam::{Vec2, Vec3};

/// Deepest nesting of textures that is followed.
pub(crate) const MAX_NESTING: u32 = 8;

/// The point of a texture lookup: coordinates, and the primitive for mesh attributes.
#[derive(Clone, Copy)]
struct LookupPoint {
    uv: Vec2,
    barycentric: Vec2,
    /// Triangle, or [`NONE`] where there is no mesh.
    primitive: u32,
}

impl LookupPoint {
    #[inline]
    fn on_surface(point: &SurfacePoint) -> LookupPoint {
        LookupPoint {
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
    vec3(parameter.value) * eval_at(tables, parameter.texture, LookupPoint::on_surface(point))
}

/// A scalar parameter at a surface point; a texture counts by its luminance.
#[inline]
pub fn eval_scalar(tables: &Tables<'_>, parameter: &ScalarParameter, point: &SurfacePoint) -> f32 {
    if !tables.has(features::TEXTURES) || parameter.texture == NONE {
        return parameter.value;
    }
    parameter.value
        * luminance(eval_at(
            tables,
            parameter.texture,
            LookupPoint::on_surface(point),
        ))
}

/// A texture by its index at a surface point.
#[inline]
pub fn eval_at_point(tables: &Tables<'_>, texture: u32, point: &SurfacePoint) -> Rgb {
    eval_at(tables, texture, LookupPoint::on_surface(point))
}

/// A texture by its index at bare coordinates (emitters); mesh attributes are zero there.
#[inline]
pub fn eval_uv(tables: &Tables<'_>, texture: u32, uv: Vec2) -> Rgb {
    let point = LookupPoint {
        uv,
        barycentric: Vec2::ZERO,
        primitive: NONE,
    };
    eval_at(tables, texture, point)
}

/// Derivatives of a texture's luminance in u and v at a surface point: of the bilinear patch for bitmaps, zero for
/// the rest (checkerboards and attributes count as flat).
pub fn eval_gradient(tables: &Tables<'_>, texture: u32, point: &SurfacePoint) -> Vec2 {
    let (leaf, factor) = resolve(tables, texture, point.uv);
    if leaf == NONE || tables.textures[leaf as usize].kind != texture_kind::BITMAP {
        return Vec2::ZERO;
    }
    let texture = &tables.textures[leaf as usize];
    let bitmap = Bitmap::new(texture);
    let gradient = bitmap.gradient(tables, transform_uv(&texture.to_uv, point.uv), factor);
    // Chain rule through the affine map.
    let m = &texture.to_uv;
    Vec2::new(
        m[0] * gradient.x + m[3] * gradient.y,
        m[1] * gradient.x + m[4] * gradient.y,
    )
}

/// The affine map of a texture's coordinates.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub(crate) fn transform_uv(m: &[f32; 6], uv: Vec2) -> Vec2 {
    Vec2::new(
        m[0] * uv.x + m[1] * uv.y + m[2],
        m[3] * uv.x + m[4] * uv.y + m[5],
    )
}

/// Whether a texture of a kind only leads to another one.
#[inline(always)]
pub(crate) fn is_nested(kind: u32) -> bool {
    (kind == texture_kind::CHECKERBOARD) | (kind == texture_kind::SCALE)
}

/// Whether a nested texture leads to its second child at transformed coordinates.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub(crate) fn leads_to_second(kind: u32, p: Vec2) -> bool {
    // Quarters of the unit square: both halves the same is the first colour.
    let is_odd = (p.x - float::floor(p.x) > 0.5) != (p.y - float::floor(p.y) > 0.5);
    (kind == texture_kind::CHECKERBOARD) & is_odd
}

/// Resolves nested scales and checkerboards to the texture that holds data, and the product of their factors; a constant is
/// [`NONE`] with its value as the factor.
#[inline]
fn resolve(tables: &Tables<'_>, texture: u32, uv: Vec2) -> (u32, Rgb) {
    let mut factor = Vec3::ONE;
    let mut current = texture;
    for _ in 0..MAX_NESTING {
        if current == NONE {
            return (NONE, factor);
        }
        let record = &tables.textures[current as usize];
        if !is_nested(record.kind) {
            return (current, factor);
        }
        let child = if leads_to_second(record.kind, transform_uv(&record.to_uv, uv)) {
            record.color1
        } else {
            record.color0
        };
        factor *= vec3(child.value);
        current = child.texture;
    }
    (NONE, Vec3::ZERO)
}

#[inline]
fn eval_at(tables: &Tables<'_>, texture: u32, point: LookupPoint) -> Rgb {
    if !tables.has(features::TEXTURES) {
        return Vec3::ZERO;
    }
    let (leaf, factor) = resolve(tables, texture, point.uv);
    if leaf == NONE {
        return factor;
    }
    let record = &tables.textures[leaf as usize];
    if tables.has(features::BITMAPS) && record.kind == texture_kind::BITMAP {
        factor * bitmap(tables, record, transform_uv(&record.to_uv, point.uv))
    } else if tables.has(features::ATTRIBUTES) {
        factor
            * match record.kind {
                texture_kind::GRID => grid(record, transform_uv(&record.to_uv, point.uv)),
                texture_kind::WIREFRAME => wireframe(tables, record, point),
                _ => attribute(tables, record, point),
            }
    } else {
        Vec3::ZERO
    }
}

/// Lines along whole coordinates, of twice the width that the record holds.
fn grid(texture: &Texture, uv: Vec2) -> Rgb {
    let half_width = f32::from_bits(texture.data[0]);
    let (x, y) = (uv.x - float::floor(uv.x), uv.y - float::floor(uv.y));
    let distance = x.min(1.0 - x).min(y.min(1.0 - y));
    vec3(if distance < half_width {
        texture.color1.value
    } else {
        texture.color0.value
    })
}

/// Lines along the edges of triangles, in the space of their mesh, which blend smoothly with what is between them.
fn wireframe(tables: &Tables<'_>, texture: &Texture, point: LookupPoint) -> Rgb {
    let (line, ground) = (vec3(texture.color1.value), vec3(texture.color0.value));
    if point.primitive as usize >= tables.triangles.len() {
        return ground;
    }
    let vertices = tables.triangles[point.primitive as usize].vertices;
    let mut corners = [Vec3::ZERO; 3];
    for i in 0..3 {
        corners[i] = vec3(tables.positions[vertices[i] as usize]);
    }
    let (b1, b2) = (point.barycentric.x, point.barycentric.y);
    let p = corners[0] * (1.0 - b1 - b2) + corners[1] * b1 + corners[2] * b2;
    let mut nearest2 = f32::MAX;
    for i in 0..3 {
        let start = corners[i];
        let edge = (corners[(i + 1) % 3] - start).normalize_or_zero();
        let to_point = p - start;
        nearest2 = nearest2.min((to_point - edge * edge.dot(to_point)).length_squared());
    }
    let (near, far) = (
        f32::from_bits(texture.data[0]),
        f32::from_bits(texture.data[1]),
    );
    let t = ((float::sqrt(nearest2) - near) / (far - near).max(f32::MIN_POSITIVE))
        .max(0.0)
        .min(1.0);
    line.lerp(ground, t * t * (3.0 - 2.0 * t))
}

/// An interpolated vertex attribute or a face attribute; zero off the triangles.
fn attribute(tables: &Tables<'_>, texture: &Texture, point: LookupPoint) -> Rgb {
    if point.primitive as usize >= tables.triangles.len() {
        return Vec3::ZERO;
    }
    let (first, channels, base) = (texture.data[0], texture.data[1], texture.data[2]);
    if texture.kind == texture_kind::FACE_ATTRIBUTE {
        return attribute_value(tables, first, channels, point.primitive.wrapping_sub(base));
    }
    let vertices = tables.triangles[point.primitive as usize].vertices;
    let (b1, b2) = (point.barycentric.x, point.barycentric.y);
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
    Bitmap::new(texture).eval(tables, uv)
}
